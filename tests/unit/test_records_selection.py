"""Parts of a record: usable time, sampled rows, telemetry, and the table of signals."""

from dataclasses import replace

import numpy as np
import pytest

from testbed.errors import InputError
from testbed.records.record import Record, RunDetails
from testbed.records.schema import signals_table
from testbed.records.selection import in_parts, sampled, telemetry_only, usable
from testbed.signals import SIGNALS

TIME = np.arange(100) / 16


def flight(**details):
    truth = np.column_stack([np.sin(TIME), np.cos(TIME), TIME])
    measured = truth.copy()
    measured[1::2] = np.nan
    measured[4, 1] = np.nan  # one axis dropped out
    channels = {"body_rate": measured, "gimbal_angle": np.ones((100, 6)), "true_body_rate": truth}
    channels |= {"reference_body_rate": truth, "singularity_measure": np.ones((100, 1))}
    return Record(
        time=TIME, channels=channels, details=RunDetails(name="flight", **details), extra_columns={"n": np.arange(100)}
    )


def test_the_usable_part_includes_both_ends():
    part = usable(flight(usable_from=1.0, usable_to=3.0))
    assert part.time[[0, -1]].tolist() == [1.0, 3.0]
    assert {len(values) for values in part.channels.values()} == {33}
    assert part.extra_columns["n"].tolist() == list(range(16, 49))
    np.testing.assert_array_equal(part.channels["true_body_rate"][:, 2], part.time)


def test_without_limits_all_of_a_run_is_usable():
    assert usable(flight()).time.size == 100


def test_too_short_a_usable_part_is_refused():
    with pytest.raises(InputError, match="flight: from usable_from_s = 1 s to usable_to_s = 2 s, body_rate has 9"):
        usable(flight(usable_from=1.0, usable_to=2.0))


@pytest.mark.parametrize(
    ("limits", "said"),
    [({"usable_from": 5.9}, "from usable_from_s = 5.9 s, body"), ({"usable_to": 0.1}, "to usable_to_s = 0.1 s, body")],
)
def test_only_the_limits_that_are_set_are_said(limits, said):
    with pytest.raises(InputError, match=f"^flight: {said}"):
        usable(flight(**limits))


def test_a_run_without_limits_that_is_too_short_says_none():
    short = replace(flight(), time=TIME[:9], channels={"body_rate": np.ones((9, 3))}, extra_columns={})
    with pytest.raises(InputError, match=r"^flight: body_rate has 9 samples"):
        usable(short)


def test_a_clock_that_jumps_by_years_is_refused_unless_its_usable_part_is_named():
    jumped = replace(flight(), time=TIME + 1.7e9 * (TIME >= 1.0))
    with pytest.raises(InputError, match=r"pauses for 1\.7e\+09 s.*set usable_from_s and usable_to_s"):
        usable(jumped)
    later = replace(jumped, details=RunDetails(name="flight", usable_from=1e9))
    assert usable(later).time.size == 84


def test_sampled_rows_are_those_with_every_component():
    time, rate = sampled(flight(), "body_rate")
    assert rate.shape == (49, 3)
    assert 4 / 16 not in time
    np.testing.assert_array_equal(rate[:, 2], time)


def test_a_channel_that_is_not_there_is_named_with_those_that_are():
    with pytest.raises(InputError, match="flight: channel rotor_speed is needed; the record holds body_rate, gimbal_a"):
        sampled(flight(), "rotor_speed")


def test_telemetry_is_what_a_flown_platform_could_send():
    sent = telemetry_only(flight())
    assert set(sent.channels) == {"body_rate", "gimbal_angle"}
    assert sent.extra_columns == {}


def test_no_telemetry_signal_bears_the_name_of_a_truth_or_a_reference():
    telemetry = [signal.name for signal in SIGNALS.values() if signal.telemetry]
    assert not [name for name in telemetry if name.startswith(("true_", "reference_"))]


def test_the_markdown_table_has_a_row_for_every_signal():
    rows = signals_table().splitlines()
    assert len(rows) == 3 + len(SIGNALS)
    assert "| `body_rate_x_rad_s` ... `body_rate_z_rad_s` | rad/s | B | body rate, gyro | yes |" in rows
    assert "| `singularity_measure` | 1 |  | singularity measure, 1 at the best | no |" in rows
    assert {row.count("|") for row in rows} == {6}


def test_a_long_record_comes_in_parts_of_equal_length_that_leave_nothing_out():
    rows = 1_001
    time = np.arange(rows) / 10.0
    rate = np.random.default_rng(1).normal(size=(rows, 3))
    rate[::10] = np.nan  # not sampled there
    record = Record(
        time=time, channels={"body_rate": rate}, details=RunDetails(name="long", usable_from=5.0, usable_to=95.0)
    )
    assert in_parts(record, 1_000) == [record]
    parts = in_parts(record, 300)
    assert [part.details.name for part in parts] == ["long part 1", "long part 2", "long part 3"]
    samples = [sampled(usable(part), "body_rate")[0] for part in parts]
    assert max(map(len, samples)) - min(map(len, samples)) <= 1
    np.testing.assert_array_equal(np.concatenate(samples), sampled(usable(record), "body_rate")[0])
