"""Maps: what is wrong with one is said with its line, and what a good one asks for is done to the numbers."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

import testbed as tb
from support import logs
from testbed.diagnosis.settings import SETTINGS
from testbed.logs import convert
from testbed.logs.map import map_file, map_of
from testbed.logs.published import published
from testbed.logs.units import factor_to
from testbed.rotation.quaternion import turned
from testbed.signals import SIGNALS
from tests.unit.test_scenario_published import DOCS


def changed(keys: dict, path: str, value: object) -> dict:
    """Return keys with another value at a dotted path; without it where the value is None."""
    copy = json.loads(json.dumps(keys))
    *tables, last = path.split(".")
    table = copy
    for each in tables:
        table = table.setdefault(each, {})
    table.pop(last, None)
    if value is not None:
        table[last] = value
    return copy


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("schema", 2, "schema: should be 1"),
        ("channels.body_rate", None, "channels.body_rate: is missing; no record is of use without it"),
        ("channels.body_rat", {}, "channels.body_rat: unknown key; did you mean body_rate?"),
        ("channels.body_rate.unitt", "x", "channels.body_rate.unitt: unknown key; did you mean unit?"),
        ("channels.body_rate.fields", ["a", "b"], "body_rate.fields: names 2, but body_rate has 3 (x, y, z)"),
        ("channels.body_rate.fields", ["a", "b", "a"], "body_rate.fields: names a field twice"),
        ("channels.body_rate.unit", None, "body_rate.unit: is missing; say what the fields are in, such as rad/s"),
        (
            "channels.body_rate.unit",
            "m/s",
            "unit 'm/s' is of another quantity than rad/s; such as rad/s, mrad/s, deg/s",
        ),
        ("channels.body_rate.unit", "Hz", "write turn/s for revolutions, rad/s for radians"),
        ("channels.body_rate.unit", "1/s", "1/s does not say of what"),
        ("channels.body_rate.unit", "degg/s", "unit 'degg/s' is not known; did you mean deg/s"),
        ("channels.body_rate.unit", "9**9**9", "unit '9**9**9' is not known"),
        ("channels.body_rate.unit", "__import__('os')", "is not known"),
        ("channels.applied_torque.unit", "J*s", "is of another quantity than N·m"),
        ("channels.acceleration", {"fields": ["a", "b", "c"], "unit": "g"}, "write g_0 for standard gravity"),
        ("clock", {"unit": "parsec"}, "clock.unit: unit 'parsec' is of another quantity than s"),
        ("channels.body_rate.time_unit", "sek", "body_rate.time_unit: unit 'sek' is not known; did you mean"),
        ("channels.body_rate.axes", ["x", "y"], "body_rate.axes: has 2 entries instead of 3"),
        ("channels.body_rate.axes", ["x", "y", "w"], "body_rate.axes[3]: should be 'x', 'y', 'z'"),
        ("channels.body_rate.axes", ["x", "-x", "z"], "names an axis twice; each of x, y and z stands once"),
        ("channels.body_rate.axes", ["-y", "x", "-z"], "mirrors (determinant -1), which no mounting of a right-handed"),
        ("channels.body_rate.scale", [1.0], "body_rate.scale: has 1 numbers for 3 fields"),
        ("channels.body_rate.scale", [0.0, 0.0, 0.0], "body_rate.scale: is zero throughout"),
        (
            "channels.rotor_speed",
            {"fields": list("abcdef"), "unit": "rpm", "axes": ["x", "y", "z"]},
            "rotor_speed has no axes; order its fields, and give signs as scale",
        ),
        ("runs", {"kind": "gap"}, "runs.kind: is 'gap', which is unknown; use one of 'whole', 'flag', 'gaps', 'times'"),
        ("runs", {"kind": "gaps"}, "runs.longer_than_s: is missing; add it"),
        ("runs", {"kind": "times", "spans_s": [[3.0, 1.0]]}, "span 1 ends at 1 s, before it begins (3 s)"),
        ("runs", {"kind": "times", "spans_s": [[0.0, 2.0], [1.0, 3.0]]}, "span 2 begins before span 1 has ended"),
        ("clock", {"origin": "zero"}, "clock.origin: should be 'first' or 'clock'"),
        ("name", "a/b", "name: should match ^[A-Za-z0-9_-]+$"),
    ],
)
def test_what_is_wrong_with_a_map_is_said_with_its_place(path, value, says):
    with pytest.raises(tb.InputError) as refused:
        map_of(map_file(changed(logs.ULOG_MAP, path, value)))
    assert says in str(refused.value)
    assert str(refused.value).startswith("map.toml: 1 problem")


def test_a_usable_span_that_ends_before_it_begins_is_refused():
    keys = {**logs.ULOG_MAP, "usable_from_s": 5.0, "usable_to_s": 2.0}
    with pytest.raises(tb.InputError, match=r"^map\.toml: usable_from_s has to be smaller than usable_to_s$"):
        map_of(map_file(keys))


def test_a_map_that_is_no_toml_is_refused(tmp_path):
    (tmp_path / "map.toml").write_text("schema = ")
    with pytest.raises(tb.InputError, match="is not TOML"):
        tb.import_log(tmp_path, tmp_path / "map.toml")
    with pytest.raises(tb.InputError, match="give the path of a map of a log"):
        tb.import_log(tmp_path, tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (
            "channels.body_rate.topic",
            "vehicle_angular_velocty",
            "topic vehicle_angular_velocty: is not there; did you mean vehicle_angular_velocity?",
        ),
        (
            "channels.body_rate.fields",
            ["xyz[0]", "xyz[1]", "xyz[3]"],
            "topic vehicle_angular_velocity, field xyz[3]: is not there; did you mean xyz[",
        ),
        ("channels.body_rate.topic", "nothing", "there are sensor_gyro, sensor_gyro[1], thrusters, vehicle_angular"),
        ("channels.body_rate.topic", None, "a channel names no topic; give one of sensor_gyro"),
        ("clock.field", "stamp", "topic thrusters, field stamp: is not there; did you mean timestamp?"),
        (
            "runs",
            {"kind": "flag", "topic": "thrusters", "field": "arm"},
            "field arm: is not there; did you mean armed?",
        ),
    ],
)
def test_names_that_the_log_does_not_hold_are_said_with_the_nearest(tmp_path, path, value, says):
    log = logs.write_ulog(tmp_path / "a.ulg")
    with pytest.raises(tb.InputError) as refused:
        tb.import_log(log, changed(logs.ULOG_MAP, path, value))
    assert says in str(refused.value)


# A table in which each number can be followed.

COLUMNS = {"t": 0.01 * np.arange(40), **{name: np.arange(40.0) + place for place, name in enumerate("abcdef")}}
SOURCES = {
    "body_rate": {"fields": ["a", "b", "c"], "unit": "mrad/s"},
    "applied_torque": {"fields": ["d", "e", "f"], "unit": "N*m"},
}


def imported(tmp_path, keys: dict, columns: dict | None = None) -> tb.ImportedRecords:
    table = COLUMNS if columns is None else columns
    lines = [
        ",".join(table),
        *(",".join(map(repr, row)) for row in zip(*(each.tolist() for each in table.values()), strict=True)),
    ]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    return tb.import_log(
        tmp_path / "a.csv", {"schema": 1, "clock": {"field": "t", "unit": "s"}, "channels": SOURCES} | keys
    )


def channels(**changes: object) -> dict:
    return {"channels": SOURCES | {"body_rate": SOURCES["body_rate"] | changes}}


@pytest.mark.parametrize(
    ("axes", "sensor"),
    [
        (["x", "y", "z"], lambda a, b, c: (a, b, c)),
        (["-y", "x", "z"], lambda a, b, c: (-b, a, c)),
        (["+z", "-y", "+x"], lambda a, b, c: (c, -b, a)),
        (["y", "z", "x"], lambda a, b, c: (b, c, a)),
    ],
)
def test_axes_are_permuted_and_signed(tmp_path, axes, sensor):
    records = imported(tmp_path, channels(axes=axes))
    wanted = np.column_stack(sensor(*(COLUMNS[name] * 1e-3 for name in "abc")))
    np.testing.assert_array_equal(records.runs[0].channels["body_rate"], wanted)


def one_axis_rig(tmp_path, **changes):
    """A rig that turns about z: one rate, one torque, in fields of their own."""
    lines = [f"{20 * row},{row % 7},{row % 5}" for row in range(50)]
    path = tmp_path / "rig.csv"
    path.write_text("\n".join(["t_ms,yaw_rate,torque", *lines]) + "\n", encoding="utf-8")
    keys = {
        "schema": 1,
        "axes": ["z"],
        "clock": {"field": "t_ms", "unit": "ms"},
        "channels": {
            "body_rate": {"fields": ["yaw_rate"], "unit": "deg/s", "scale": [-1.0]},
            "applied_torque": {"fields": ["torque"], "unit": "mN*m"},
        },
    }
    return tb.import_log(path, {name: value for name, value in (keys | changes).items() if value is not None})


def test_a_rig_names_the_fields_about_its_own_axes_alone(tmp_path):
    records = one_axis_rig(tmp_path, axes=["y"])
    (record,) = records
    assert record.details.axes == ("y",)
    rates, torques = record.channels["body_rate"], record.channels["applied_torque"]
    assert np.isnan(rates[:, [0, 2]]).all()
    np.testing.assert_allclose(rates[:, 1], -np.radians(np.arange(50) % 7), atol=1e-15)
    assert not torques[:, [0, 2]].any()
    np.testing.assert_allclose(torques[:, 1], 1e-3 * (np.arange(50) % 5), atol=1e-15)
    assert records.channels["body_rate"].converted[-1] == "about y only: x, z left empty"


@pytest.mark.parametrize(
    ("axes", "says"),
    [
        (None, r'body_rate has 3 \(x, y, z\); name one for each; of a rig that turns about z only, say axes = \["z"\]'),
        (["x", "z"], "names 1, but body_rate has 3 .* the map's axes are x, z"),
    ],
)
def test_fewer_fields_than_axes_are_refused(tmp_path, axes, says):
    with pytest.raises(tb.InputError, match=says):
        one_axis_rig(tmp_path, axes=axes)


def test_a_left_handed_sensor_is_taken_where_it_is_known_to_be_one(tmp_path):
    records = imported(tmp_path, channels(axes=["x", "-y", "z"], left_handed=True))
    np.testing.assert_array_equal(records.runs[0].channels["body_rate"][:, 1], -1e-3 * COLUMNS["b"])
    assert "body x, y, z from the sensor's x, -y, z" in records.channels["body_rate"].converted


def test_scale_and_offset(tmp_path):
    records = imported(tmp_path, channels(scale=[2.0, -1.0, 1.0], offset_s=-0.004))
    record = records.runs[0]
    rows = np.isfinite(record.channels["body_rate"][:, 0])
    np.testing.assert_allclose(record.channels["body_rate"][rows, 1], -1e-3 * COLUMNS["b"], rtol=1e-15)
    np.testing.assert_allclose(record.time[rows], COLUMNS["t"] - 0.004, atol=1e-15)
    assert len(record.time) == 80
    assert records.channels["body_rate"].converted == (
        "mrad/s to rad/s, times 0.001",
        "scaled by 2, -1, 1",
        "times shifted by -0.004 s",
    )


def test_an_attitude_turns_with_its_axes(tmp_path):
    """The body's axes in N are where the sensor's were, whatever they are called."""
    rng = np.random.default_rng(8)
    quat_NS = rng.normal(size=(40, 4))
    quat_NS /= np.linalg.norm(quat_NS, axis=1)[:, None]
    more = dict(zip("wxyz", quat_NS.T, strict=True))
    sources = SOURCES | {"attitude": {"fields": list("wxyz"), "axes": ["-y", "x", "z"]}}
    record = imported(tmp_path, {"channels": sources}, COLUMNS | more).runs[0]
    body_y_S, body_y_B = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(turned(record.channels["attitude"], body_y_B), turned(quat_NS, body_y_S), atol=1e-14)


@pytest.mark.parametrize(
    ("unit", "target", "factor"),
    [
        ("deg/s", "rad/s", np.pi / 180),
        ("°/s", "rad/s", np.pi / 180),
        ("dps", "rad/s", np.pi / 180),
        ("rpm", "rad/s", np.pi / 30),
        ("turn/s", "rad/s", 2 * np.pi),
        ("mNm", "N·m", 1e-3),
        ("N m", "N·m", 1.0),
        ("N·m·s", "N·m·s", 1.0),
        ("kg m²/s", "N·m·s", 1.0),
        ("g_0", "m/s²", 9.80665),
        ("m/s^2", "m/s²", 1.0),
        ("us", "s", 1e-6),
        ("percent", "", 0.01),
    ],
)
def test_units(unit, target, factor):
    assert factor_to(unit, target) == pytest.approx(factor, rel=1e-15)


def test_every_unit_of_a_signal_is_known():
    assert {factor_to(signal.unit, signal.unit) for signal in SIGNALS.values() if signal.unit} == {1.0}


# Clocks.


def test_the_first_sample_of_all_channels_is_zero_or_the_clock_is_kept(tmp_path):
    shifted = COLUMNS | {"t": COLUMNS["t"] + 1234.5}
    assert imported(tmp_path, {}, shifted).runs[0].time[0] == 0.0
    kept = imported(tmp_path, {"clock": {"field": "t", "unit": "s", "origin": "clock"}}, shifted)
    np.testing.assert_array_equal(kept.runs[0].time, shifted["t"])


def test_a_clock_without_a_unit_is_refused(tmp_path):
    with pytest.raises(tb.InputError, match="body_rate: the unit of the time in t is not known: give it, such as us"):
        imported(tmp_path, {"clock": {"field": "t"}})
    with pytest.raises(tb.InputError, match="a table has no clock of its own: name its column of time"):
        imported(tmp_path, {"clock": {}})


def test_ticks_beyond_any_clock_are_refused(tmp_path):
    with pytest.raises(tb.InputError, match="beyond the year 2262: the clock has another unit"):
        imported(tmp_path, {"clock": {"field": "t", "unit": "s"}}, COLUMNS | {"t": 10**12 * np.arange(40)})


def test_messages_that_were_logged_twice_count_once(tmp_path):
    columns = {name: np.repeat(values, 2) for name, values in COLUMNS.items()}
    records = imported(tmp_path, {}, columns)
    assert "body_rate: 40 samples that repeat the one before them left out" in records.dropped
    np.testing.assert_array_equal(records.runs[0].time, COLUMNS["t"])


def test_a_single_late_message_is_left_out(tmp_path):
    columns = {name: np.repeat(values, 10) for name, values in COLUMNS.items()}
    columns["t"] = 0.01 * np.arange(400)
    columns["t"][200] = 1.0
    records = imported(tmp_path, {}, columns)
    assert records.dropped == tuple(
        f"{name}: 1 samples that are not later than the one before them left out" for name in SOURCES
    )
    assert len(records.runs[0].time) == 399


@pytest.mark.parametrize(
    ("time", "says"),
    [
        (np.repeat(0.02 * np.arange(20), 2), "at sample 2 it repeats 0 s; take another clock"),
        (np.r_[0.01 * np.arange(20), 0.01 * np.arange(20)], "at sample 21 it goes back from 0.19 s"),
    ],
)
def test_a_clock_that_does_not_increase_is_refused(tmp_path, time, says):
    with pytest.raises(tb.InputError, match=says):
        imported(tmp_path, {}, COLUMNS | {"t": time})


def test_infinite_values_are_not_sampled(tmp_path):
    columns = {name: values.copy() for name, values in COLUMNS.items()}
    columns["a"][5] = np.inf
    records = imported(tmp_path, {}, columns)
    assert records.dropped == (
        "body_rate: 1 infinite values taken as not sampled",
        "body_rate: 1 samples lack some of their values: kept, with cells that are empty",
    )
    assert np.isnan(records.runs[0].channels["body_rate"][5, 0])


# Runs.


def test_a_run_for_each_time_that_a_flag_is_set(tmp_path):
    flag = np.zeros(40)
    flag[3:15] = flag[20:22] = flag[25:] = 1.0
    records = imported(tmp_path, {"runs": {"kind": "flag", "field": "on"}}, COLUMNS | {"on": flag})
    assert [record.details.name for record in records] == ["a_1", "a_3"]
    np.testing.assert_array_equal(records["a_1"].time, COLUMNS["t"][3:15])
    np.testing.assert_array_equal(records["a_3"].time, COLUMNS["t"][25:])
    assert records.dropped == ("a_2: 2 samples of the body rate, at least 10 are needed: left out",)


def test_a_flag_holds_from_its_sample_to_the_next(tmp_path):
    log = logs.write_ulog(tmp_path / "a.ulg", 4000)
    runs = {"kind": "flag", "topic": "thrusters", "field": "armed"}
    record = tb.import_log(log, {**logs.ULOG_MAP, "runs": runs, "name": "armed"}).runs[0]
    assert record.details.name == "armed"
    assert record.time[0] == pytest.approx(5.0001, abs=1e-9)  # torques and flag come 0.1 ms after the gyro
    assert record.time[-1] == pytest.approx(10.0, abs=1e-9)


def test_a_flag_that_is_never_set_is_refused(tmp_path):
    with pytest.raises(tb.InputError, match="a is never above 100: no run begins"):
        imported(tmp_path, {"runs": {"kind": "flag", "field": "a", "above": 100.0}})


def test_runs_end_where_the_gyro_pauses(tmp_path):
    columns = COLUMNS | {"t": np.r_[COLUMNS["t"][:15], COLUMNS["t"][15:] + 5.0]}
    records = imported(tmp_path, {"runs": {"kind": "gaps", "longer_than_s": 1.0}, "name": "run"}, columns)
    assert [(record.details.name, len(record.time)) for record in records] == [("run_1", 15), ("run_2", 25)]


def test_a_pause_within_a_run_is_said(tmp_path):
    columns = COLUMNS | {"t": np.r_[COLUMNS["t"][:15], COLUMNS["t"][15:] + 5.0]}
    records = imported(tmp_path, {"name": "run"}, columns)
    (pause,) = records.pauses
    assert pause.startswith("run: the body rate pauses for 5.0")
    assert '[runs] kind = "gaps"' in pause
    assert f"missing: {pause}" in str(records)
    assert imported(tmp_path, {"runs": {"kind": "gaps", "longer_than_s": 1.0}}, columns).pauses == ()


def test_a_gyro_that_is_slow_does_not_pause(tmp_path):
    columns = COLUMNS | {"t": COLUMNS["t"] * 200.0}
    assert imported(tmp_path, {}, columns).pauses == ()


def test_runs_at_given_times(tmp_path):
    records = imported(tmp_path, {"runs": {"kind": "times", "spans_s": [[0.0, 0.1], [0.195, 0.355]]}})
    assert [tuple(record.time[[0, -1]]) for record in records] == [(0.0, 0.1), (0.2, COLUMNS["t"][35])]


def test_a_cut_that_gives_no_run_is_refused(tmp_path):
    with pytest.raises(
        tb.InputError, match=r"no run holds 10 samples of the body rate.*the longest holds 3: .*\[runs\]"
    ):
        imported(tmp_path, {"runs": {"kind": "times", "spans_s": [[0.0, 0.02], [0.2, 0.22]]}})


def test_numbers_that_are_in_another_unit_than_stated_are_left_to_the_gate(tmp_path):
    """Only beside a platform can a rate be too fast: a diagnosis refuses what its actuators do not predict."""
    (record,) = imported(tmp_path, channels(unit="rad/s"))
    assert np.nanmax(np.abs(record.channels["body_rate"])) > SETTINGS.plausible_body_rate


def test_a_record_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(convert, "MOST_CELLS", 300)
    imported(tmp_path, {})
    with pytest.raises(tb.InputError, match="its topics have 80 times in all, too many for a record of 6 columns"):
        imported(tmp_path, channels(offset_s=0.001))


def test_what_the_map_says_of_the_runs_stands_in_the_records(tmp_path):
    records = imported(tmp_path, {"gyro_noise_rad_s": 0.002, "source": "simulated"})
    details = records.runs[0].details
    assert (details.gyro_noise, details.source) == (0.002, "simulated")
    assert [stamp.path for stamp in records.runs[0].files] == [str(tmp_path / "a.csv"), "map.toml"]


def test_the_guides_map_imports_a_log(tmp_path):
    page = (DOCS / "how-to" / "import-logs.md").read_text(encoding="utf-8")
    (tmp_path / "map.toml").write_text(page.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    records = tb.import_log(logs.write_ulog(tmp_path / "flight.ulg", 4000), tmp_path / "map.toml")
    assert [record.details.name for record in records] == ["bench"]
    assert list(records.channels) == ["body_rate", "applied_torque"]


@pytest.mark.parametrize("path", published(DOCS), ids=lambda path: path.name)
def test_the_published_keys_are_current(path):
    """If this fails: python -m testbed.logs.published."""
    assert path.read_text(encoding="utf-8") == published(DOCS)[path]


def test_samples_that_are_missing_within_a_run_are_said(tmp_path):
    """Forty samples at 10 Hz, of which two are lost together; then one of two clocks that sends when it likes."""
    kept = np.r_[0:15, 17:40]
    columns = {name: values[kept] for name, values in COLUMNS.items()}
    step = COLUMNS["t"][1] - COLUMNS["t"][0]
    lost = f"lacks some 2 of 40 samples: it has none once for {3 * step:.4g} s from {14 * step:.4g} s on"
    records = imported(tmp_path, {"name": "run"}, columns)
    assert records.pauses == tuple(f"run: {channel} {lost}" for channel in records["run"].channels)
    unsteady = columns | {"t": np.cumsum(np.where(np.arange(38) % 5, 1.0, 4.0) * step)}
    assert imported(tmp_path, {"name": "run"}, unsteady).pauses == ()


def test_axes_that_are_named_twice_are_refused(tmp_path):
    with pytest.raises(tb.InputError, match=r"axes: is z, z, which names an axis twice"):
        imported(tmp_path, {"axes": ["z", "z"]})


def test_quaternions_have_unit_length_or_are_not_sampled(tmp_path):
    quaternion = np.zeros((40, 4))
    quaternion[:, 0], quaternion[0] = 2.0, 0.0
    columns = COLUMNS | dict(zip("ghij", quaternion.T, strict=True))
    attitude = {"attitude": {"fields": list("ghij"), "unit": "1"}}
    records = imported(tmp_path, {"channels": SOURCES | attitude}, columns)
    converted = " ".join(records.channels["attitude"].converted)
    assert "1 quaternions of length 0 taken as not sampled" in converted
    assert "quaternions of length 2 to 2 scaled to unit length" in converted
    values = records.runs[0].channels["attitude"]
    assert np.isnan(values[0]).all()
    np.testing.assert_array_equal(values[1:], np.tile([1.0, 0.0, 0.0, 0.0], (39, 1)))


def test_quaternions_of_a_table_are_of_unit_length_or_none():
    time, rate = 0.1 * np.arange(20), np.random.default_rng(0).standard_normal((20, 3))
    turned = np.tile([0.6, 0.8, 0.0, 0.0], (20, 1))
    turned[3] = 0.0
    columns = dict(zip(("body_rate_x_rad_s", "body_rate_y_rad_s", "body_rate_z_rad_s"), rate.T, strict=True))
    columns |= {f"applied_torque_{axis}_N_m": rate[:, 0] for axis in "xyz"}
    for length, fault in ((1.0, None), (1.01, None), (2.0, "2 in row 1"), (1e200, "inf in row 1")):
        attitude = dict(zip((f"attitude_{axis}" for axis in "wxyz"), length * turned.T, strict=True))
        frame = pd.DataFrame({"time_s": time, **columns, **attitude})
        if fault is None:
            assert tb.records_from({"run": frame}).runs
            continue
        with pytest.raises(tb.InputError, match=f"attitude has quaternions that are not of unit length: {fault}"):
            tb.records_from({"run": frame})


def test_a_row_of_units_that_contradicts_the_map_is_said(tmp_path):
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{0.1 * n},1,2,3,4,5,6" for n in range(20))
    path.write_text(f"t,a,b,c,d,e,f\n[s],[rad/s],[rad/s],[mrad/s],[N*m],[N*m],[N*m]\n{rows}\n", encoding="utf-8")
    records = tb.import_log(path, {"schema": 1, "clock": {"field": "t", "unit": "s"}, "channels": SOURCES})
    assert [each for each in records.dropped if "by the map" in each] == [
        "body_rate: a is in rad/s by the log, in mrad/s by the map, which is taken",
        "body_rate: b is in rad/s by the log, in mrad/s by the map, which is taken",
    ]
