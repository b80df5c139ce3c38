"""Whatever a record holds comes back from the MCAP file that it was written to, by the map beside it, bit for bit."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import testbed as tb
from support import logs
from testbed.logs.export import write_mcap
from testbed.logs.streams import doubles
from testbed.records.record import Record, RunDetails
from tests.properties.test_records_roundtrip import records


@settings(max_examples=40, deadline=None)
@given(records())
def test_mcap_keeps_every_number(record):
    """The body rate is sampled in every row: a row without any sample says nothing and is not written."""
    with tempfile.TemporaryDirectory() as folder:
        path = write_mcap(record, Path(folder) / "run.mcap")
        read = tb.import_log(path, path.with_suffix(".map.toml"))
    assert all(each.endswith("kept, with cells that are empty") for each in read.dropped)
    assert read.unused == ("/extra",)
    written, again = record, read.runs[0]
    np.testing.assert_array_equal(again.time.view(np.uint64), written.time.view(np.uint64))
    assert again.channels.keys() == written.channels.keys()
    for name, values in written.channels.items():
        np.testing.assert_array_equal(again.channels[name], values)
        np.testing.assert_array_equal(np.signbit(again.channels[name]), np.signbit(values) & ~np.isnan(values))
    assert again.details.source == written.details.source
    assert again.details.gyro_noise == written.details.gyro_noise


@pytest.fixture(scope="module")
def good_files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("good")
    return {
        "a.ulg": (logs.write_ulog(folder / "a.ulg", 60).read_bytes(), logs.ULOG_MAP),
        "a.mcap": (logs.write_json_mcap(folder / "a.mcap", 60, "NONE", 1000).read_bytes(), logs.JSON_MAP),
        "r.mcap": (logs.write_ros_mcap(folder / "r.mcap", 60).read_bytes(), logs.ROS_MAP),
        "b.bag": (logs.write_bag(folder / "b.bag", 60).read_bytes(), logs.ROS_MAP),
    }


@pytest.mark.parametrize("name", ["a.ulg", "a.mcap", "r.mcap", "b.bag"])
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_a_damaged_log_gives_records_or_a_refusal_that_names_it(good_files, name, data):
    """Cut, overwritten or patched anywhere: never another exception, never a record that breaks its promises."""
    good, keys = good_files[name]
    start = data.draw(st.integers(0, len(good)))
    end = data.draw(st.integers(start, min(len(good), start + 40)) | st.just(len(good)))
    content = good[:start] + data.draw(st.binary(max_size=40)) + good[end:]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        outcome = records_or_refusal(path, keys)
    if isinstance(outcome, tb.InputError):
        assert name.partition(".")[0] in str(outcome)
        return
    for record in outcome:
        assert (np.diff(record.time) > 0).all()
        assert {len(rows) for rows in record.channels.values()} == {record.time.size}


def records_or_refusal(path, keys):
    try:
        return tb.import_log(path, keys)
    except tb.InputError as error:
        return error


def test_columns_that_no_signal_bears_are_written_too(tmp_path):
    time = np.arange(12) / 8
    extra = {"mode": np.array(["on", None] * 6, dtype=object), "count": np.arange(12), "heat": np.full(12, np.inf)}
    channels = {"body_rate": np.ones((12, 3)), "applied_torque": np.ones((12, 3))}
    record = Record(time=time, channels=channels, details=RunDetails(name="a"), extra_columns=extra)
    tb.Records((record,)).save(tmp_path, format="mcap")
    from mcap.reader import make_reader

    with (tmp_path / "a.mcap").open("rb") as file:
        messages = [message.data for _, _, message in make_reader(file).iter_messages("/extra")]
    assert messages[0] == b'{"time_s": 0.0, "mode": "on", "count": 0, "heat": null}'
    assert messages[1] == b'{"time_s": 0.125, "mode": null, "count": 1, "heat": null}'


def test_a_signalling_nan_is_a_sample_that_is_missing():
    """Of a ULog with a few bytes put in between, one number of single precision was one; casting it is a warning."""
    single = np.array([0x7F800001, 0x3F800000], dtype=np.uint32).view(np.float32)
    with pytest.warns(RuntimeWarning, match="cast"):
        single.astype(np.float64)
    np.testing.assert_array_equal(doubles(single), [np.nan, 1.0])
