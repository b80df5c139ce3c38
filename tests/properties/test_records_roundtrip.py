"""Whatever a record holds comes back from its file; whatever a file holds is a record or a clear refusal."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from testbed.errors import InputError
from testbed.records.checks import LARGEST_ACTUATION, SLOWEST_PERIOD
from testbed.records.reading import read_record
from testbed.records.record import Record, RunDetails
from testbed.records.writing import write_record
from testbed.signals import MOST_UNITS, SIGNALS

NUMBERS = st.floats(allow_nan=True, allow_infinity=False, width=64)
ACTUATION = st.just(np.nan) | st.floats(-LARGEST_ACTUATION, LARGEST_ACTUATION)
OPTIONAL_CHANNELS = sorted(set(SIGNALS) - {"body_rate", "applied_torque"})

ACTUATORS = ("gimbal_angle", "wheel_speed", "cluster_momentum", "applied_torque", "motor_thrust", "rotor_speed")


def values(width, rows, elements):
    """Any numbers, with at least one in every column."""
    table = arrays.arrays(np.float64, (rows, width), elements=elements)
    return table.filter(lambda array: not np.isnan(array).all(axis=0).any())


@st.composite
def quaternions(draw, rows):
    """Of unit length, or not sampled."""
    table = draw(arrays.arrays(np.float64, (rows, 4), elements=st.floats(-1.0, 1.0)))
    length = np.linalg.norm(table, axis=1, keepdims=True)
    table = np.where(length > 1e-3, table / np.maximum(length, 1e-3), [1.0, 0.0, 0.0, 0.0])
    table[draw(arrays.arrays(np.bool_, rows, elements=st.booleans()))] = np.nan
    table[draw(st.integers(0, rows - 1))] = [1.0, 0.0, 0.0, 0.0]
    return table


@st.composite
def details(draw):
    times = draw(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=2, unique=True).map(sorted))
    return RunDetails(
        name=draw(st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=20)),
        source=draw(st.sampled_from(["measured", "simulated"])),
        gyro_noise=draw(st.none() | st.just(0.0) | st.floats(1e-12, 1e3)),
        usable_from=draw(st.none() | st.just(times[0])),
        usable_to=draw(st.none() | st.just(times[1])),
        role=draw(st.sampled_from([None, "fit", "heldout"])),
    )


@st.composite
def records(draw):
    rows = draw(st.integers(10, 20))
    # Gaps of any length may occur, but a record is not slower than a reader takes for seconds.
    steps = draw(arrays.arrays(np.float64, rows, elements=st.floats(1e-3, SLOWEST_PERIOD)))
    steps[draw(st.integers(0, rows - 1))] *= draw(st.floats(1.0, 1e3))
    channels = {"body_rate": draw(arrays.arrays(np.float64, (rows, 3), elements=st.floats(-20, 20)))}
    units = draw(st.sampled_from([1, 3, 4, 6, 8, MOST_UNITS]))  # of every kind as many
    for name in ("applied_torque", *draw(st.lists(st.sampled_from(OPTIONAL_CHANNELS), unique=True, max_size=2))):
        elements = ACTUATION if name in ACTUATORS else NUMBERS
        any_numbers = values(SIGNALS[name].sized(units).width, rows, elements)
        channels[name] = draw(quaternions(rows) if name.endswith("attitude") else any_numbers)
    return Record(
        time=np.cumsum(steps),
        channels=channels,
        details=draw(details()),
        extra_columns={"extra": draw(arrays.arrays(np.float64, rows, elements=NUMBERS))},
    )


def there_and_back(record, suffix):
    with tempfile.TemporaryDirectory() as folder:
        return read_record(write_record(record, Path(folder) / f"run{suffix}"))


def bits(array):
    return np.ascontiguousarray(array).view(np.uint64)


@settings(max_examples=60, deadline=None)
@given(records())
def test_parquet_keeps_every_bit(record):
    """NaN payloads and the sign of zero included."""
    read = there_and_back(record, ".parquet")
    np.testing.assert_array_equal(bits(read.time), bits(record.time))
    np.testing.assert_array_equal(bits(read.extra_columns["extra"]), bits(record.extra_columns["extra"]))
    assert read.channels.keys() == record.channels.keys()
    for name, written in record.channels.items():
        np.testing.assert_array_equal(bits(read.channels[name]), bits(written))
    assert read.details == record.details


@settings(max_examples=60, deadline=None)
@given(records())
def test_csv_keeps_every_number(record):
    read = there_and_back(record, ".csv")
    np.testing.assert_array_equal(read.time, record.time)
    assert read.channels.keys() == record.channels.keys()
    for name, written in record.channels.items():
        np.testing.assert_array_equal(read.channels[name], written)
    assert read.details == record.details


GOOD_FILES = {}
for _suffix in (".csv", ".parquet"):
    with tempfile.TemporaryDirectory() as _folder:
        _rate = np.random.default_rng(1).normal(size=(12, 3))
        _run = Record(
            time=np.arange(12) / 16,
            channels={"body_rate": _rate, "applied_torque": _rate},
            details=RunDetails(name="run"),
        )
        GOOD_FILES[_suffix] = write_record(_run, Path(_folder) / f"run{_suffix}").read_bytes()


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_a_damaged_file_is_a_record_or_a_refusal_that_names_it(suffix, data):
    """Cut, overwritten or patched anywhere: never another exception, never a record that breaks its promises."""
    good = GOOD_FILES[suffix]
    start = data.draw(st.integers(0, len(good)))
    end = data.draw(st.integers(start, min(len(good), start + 40)))
    patch = data.draw(
        st.binary(max_size=40) | st.sampled_from([b",", b"\n", b'"', b"nan", b"inf", b"-", b"\x00", b";"])
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"run{suffix}"
        path.write_bytes(good[:start] + patch + good[end:])
        outcome = read_or_refusal(path)
    if isinstance(outcome, InputError):
        assert str(path) in str(outcome)
    else:
        assert np.isfinite(outcome.time).all()
        assert (np.diff(outcome.time) > 0).all()
        assert {len(rows) for rows in outcome.channels.values()} == {outcome.time.size}


def read_or_refusal(path):
    try:
        return read_record(path)
    except InputError as error:
        return error
