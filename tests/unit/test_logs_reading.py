"""Logs in every format, whole, cut and damaged: what is whole is read, what is not is said."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

import testbed as tb
from support import logs
from testbed.logs import streams, ulog

ROWS = 400
WRITERS = {
    "a.ulg": (logs.write_ulog, logs.ULOG_MAP),
    "json.mcap": (logs.write_json_mcap, logs.JSON_MAP),
    "ros2.mcap": (logs.write_ros_mcap, logs.ROS_MAP),
    "protobuf.mcap": (logs.write_protobuf_mcap, logs.PROTOBUF_MAP),
    "ros1.bag": (logs.write_bag, logs.ROS_MAP),
    "ros2": (logs.write_bag, logs.ROS_MAP),
}


def sampled(record, name: str):
    rows = np.isfinite(record.channels[name]).all(axis=1)
    return record.time[rows], record.channels[name][rows]


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_numbers_that_were_written(tmp_path, name):
    write, keys = WRITERS[name]
    records = tb.import_log(write(tmp_path / name), keys)
    time, rates = sampled(records.runs[0], "body_rate")
    np.testing.assert_allclose(time, np.arange(ROWS) / logs.RATE, atol=1e-12)
    written = logs.gyro(ROWS).astype(np.float32) if name == "a.ulg" else logs.gyro(ROWS)
    np.testing.assert_array_equal(rates, written)
    torque_time, torques = sampled(records.runs[0], "applied_torque")
    slow = name != "protobuf.mcap"
    np.testing.assert_array_equal(torques, logs.torque() if slow else 0.01 * logs.motion(ROWS, logs.RATE, 1.0))
    assert len(torque_time) == ROWS // (4 if slow else 1)
    assert records.dropped == ()


@pytest.mark.parametrize("name", WRITERS)
def test_topics_keep_their_own_times(tmp_path, name):
    """Rows are all times of all topics; nothing is interpolated onto the others'."""
    write, keys = WRITERS[name]
    record = tb.import_log(write(tmp_path / name), keys).runs[0]
    fast, slow = (set(sampled(record, channel)[0]) for channel in ("body_rate", "applied_torque"))
    assert set(record.time) == fast | slow
    assert len(record.time) == (500 if name == "a.ulg" else 400)


def test_ticks_are_subtracted_before_they_become_floating_point(tmp_path):
    """Since 1970 a double resolves 0.2 us; the log's ticks are 1 ns."""
    path = tmp_path / "a.csv"
    ticks = 1_760_000_000_000_000_001 + 5_000_003 * np.arange(50, dtype=np.int64)
    rows = [f"{tick},1,2,3,4,5,6" for tick in ticks]
    path.write_text("\n".join(["t,a,b,c,d,e,f", *rows]))
    keys = {
        "schema": 1,
        "clock": {"field": "t", "unit": "ns"},
        "channels": {
            "body_rate": {"fields": ["a", "b", "c"], "unit": "rad/s"},
            "applied_torque": {"fields": ["d", "e", "f"], "unit": "N*m"},
        },
    }
    np.testing.assert_array_equal(tb.import_log(path, keys).runs[0].time, 5_000_003 * np.arange(50) / 1e9)


def test_instances_of_a_ulog_topic_are_apart(tmp_path):
    path = logs.write_ulog(tmp_path / "a.ulg")
    keys = json.loads(json.dumps(logs.ULOG_MAP))
    keys["channels"]["body_rate"] = {"topic": "sensor_gyro[1]", "fields": ["x", "y", "z"], "unit": "rad/s"}
    records = tb.import_log(path, keys)
    np.testing.assert_array_equal(sampled(records.runs[0], "body_rate")[1], logs.gyro().astype(np.float32))
    assert records.unused == ("vehicle_angular_velocity",)


@pytest.mark.parametrize("name", ["a.ulg", "json.mcap", "ros2.mcap", "protobuf.mcap"])
@pytest.mark.parametrize("share", [0.45, 0.9])
def test_of_a_cut_log_what_is_whole_is_read_and_said(tmp_path, name, share):
    write, keys = WRITERS[name]
    path = write(tmp_path / name, 4000, **({} if name == "a.ulg" else {"chunk": 20_000}))
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    records = tb.import_log(path, keys)
    assert any("cut" in each for each in records.dropped)
    time, rates = sampled(records.runs[0], "body_rate")
    written = logs.gyro(4000).astype(np.float32) if name == "a.ulg" else logs.gyro(4000)
    assert 400 < len(time) < 4000
    np.testing.assert_array_equal(rates, written[: len(time)])


def test_a_log_that_is_cut_before_its_first_message_says_so(tmp_path):
    path = logs.write_json_mcap(tmp_path / "a.mcap", 4000, chunk=10**8)
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(tb.InputError, match=r"what the map names\n  the file has no end: the log"):
        tb.import_log(path, logs.JSON_MAP)
    channels = logs.JSON_MAP["channels"]
    without = {name: {key: each for key, each in own.items() if key != "topic"} for name, own in channels.items()}
    with pytest.raises(tb.InputError, match="it holds no messages"):
        tb.import_log(path, logs.JSON_MAP | {"channels": without})


def test_a_topic_without_a_message_is_not_said_to_be_missing(tmp_path):
    path = logs.write_json_mcap(tmp_path / "a.mcap", silent="/thrusters")
    keys = json.loads(json.dumps(logs.JSON_MAP))
    keys["channels"]["applied_torque"]["topic"] = "/thrusters"
    with pytest.raises(tb.InputError, match="topic /thrusters: holds no message with a number"):
        tb.import_log(path, keys)


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_a_damaged_chunk_is_left_out_and_said(tmp_path, compression):
    path = logs.write_json_mcap(tmp_path / "a.mcap", 2000, compression)
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 0xFF
    path.write_bytes(content)
    records = tb.import_log(path, logs.JSON_MAP)
    assert [each for each in records.dropped if "a chunk is damaged" in each]
    assert 1000 < len(records.runs[0].time) < 2000


def test_messages_that_cannot_be_decoded_are_counted(tmp_path):
    from mcap.writer import Writer

    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/imu", "json", 0)
        for row in range(50):
            good = json.dumps({"w": [row, 2.0, None if row == 7 else 3], "m": [0, 1, "high" if row == 8 else 2]})
            writer.add_message(channel, 10**7 * row, b'{"w": [' if row == 5 else good.encode(), 10**7 * row)
        writer.finish()
    keys = {
        "schema": 1,
        "channels": {
            "body_rate": {"topic": "/imu", "fields": ["w[0]", "w[1]", "w[2]"], "unit": "deg/s"},
            "applied_torque": {"topic": "/imu", "fields": ["m[0]", "m[1]", "m[2]"], "unit": "mN*m"},
        },
    }
    records = tb.import_log(path, keys)
    lacking = "1 samples lack some of their values: kept, with cells that are empty"
    assert records.dropped == (
        "1 messages of /imu could not be decoded: they were left out",
        f"body_rate: {lacking}",
        f"applied_torque: {lacking}",
    )
    assert len(records.runs[0].time) == 49
    assert np.isnan(records.runs[0].channels["body_rate"]).sum() == 1
    assert np.isnan(records.runs[0].channels["applied_torque"]).sum() == 1


def test_what_a_ulogs_logger_lost_is_said(tmp_path):
    log = logs.ULogWriter(tmp_path / "a.ulg", {"g": "uint64_t timestamp;float[6] v"})
    log.add(0, "g")
    for row in range(40):
        log.data(0, struct.pack("<Q6f", 5000 * row, *range(6)))
    log.dropout(120)
    log.close()
    channels = {
        "body_rate": {"topic": "g", "fields": ["v[0]", "v[1]", "v[2]"], "unit": "rad/s"},
        "applied_torque": {"topic": "g", "fields": ["v[3]", "v[4]", "v[5]"], "unit": "N*m"},
    }
    records = tb.import_log(tmp_path / "a.ulg", {"schema": 1, "channels": channels})
    assert records.dropped == ("the logger lost messages 1 times, 0.12 s in all",)


@pytest.mark.parametrize("name", ["ros1.bag", "ros2"])
def test_a_cut_bag_is_refused_with_its_name(tmp_path, name):
    path = logs.write_bag(tmp_path / name)
    file = path if path.is_file() else next(path.glob("*.db3"))
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 10])
    with pytest.raises(tb.InputError, match=str(path)):
        tb.import_log(path, logs.ROS_MAP)


def test_a_bag_of_another_name_is_refused(tmp_path):
    logs.write_bag(tmp_path / "a.bag").rename(tmp_path / "log")
    with pytest.raises(tb.InputError, match=r"ends in \.bag or \.db3, by which it is read: rename it"):
        tb.import_log(tmp_path / "log", logs.ROS_MAP)


def test_one_database_of_a_bag_is_read_alone(tmp_path):
    path = next(logs.write_bag(tmp_path / "bag").glob("*.db3"))
    assert len(tb.import_log(path, logs.ROS_MAP).runs[0].time) == ROWS


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "is empty"),
        (bytes(100), r"its name says ROS 1 bag, but its content does not begin as one: .*copy it again"),
        (b"ULog\x01\x12\x35", "cannot be read as ULog"),
        (b"ULog\x01\x12\x35\x01" + bytes(100), "does not hold what the map names"),
        (b"\x89MCAP0\r\n" + bytes(100), "does not hold what the map names"),
        # An attachment whose name is said to have 4 GB.
        (b"\x89MCAP0\r\n\x09" + struct.pack("<Q", 100) + bytes(16) + b"\xff" * 4 + bytes(80), "does not hold"),
        (b"#ROSBAG V2.0\n" + bytes(100), "cannot be read as a ROS bag"),
        (b"SQLite format 3\0" + bytes(100), "cannot be read as a ROS bag"),
        (b"PAR1" + bytes(100), "cannot be read as Parquet"),
    ],
)
def test_what_is_no_log_is_refused(tmp_path, content, says):
    path = tmp_path / ("a.db3" if b"SQL" in content else "a.bag")
    path.write_bytes(content)
    with pytest.raises(tb.InputError, match=says):
        tb.import_log(path, logs.ULOG_MAP)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("x.ulg", r"x\.ulg: its name says ULog, but its content does not begin as one: .*copy it again"),
        ("x.MCAP", "its name says MCAP, but"),
        ("x.bag", "its name says ROS 1 bag, but"),
        ("x.db3", "its name says ROS 2 bag, but"),
        ("x.parquet", "its name says Parquet, but"),
        ("x.csv", "is in none of the formats that are read: ULog, MCAP"),
        ("x", "is in none of the formats that are read: ULog, MCAP"),
    ],
)
def test_random_bytes_are_refused_by_what_their_name_says(tmp_path, name, says):
    path = tmp_path / name
    path.write_bytes(np.random.default_rng(1).bytes(3000))
    with pytest.raises(tb.InputError, match=says):
        tb.import_log(path, logs.ULOG_MAP)
    with pytest.raises(tb.InputError, match=says):
        tb.guess_map(path)


def test_a_log_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(tb.InputError, match="give the path of a log: ULog, MCAP, ROS bag, CSV or Parquet"):
        tb.import_log(tmp_path / "none.ulg", logs.ULOG_MAP)
    with pytest.raises(tb.InputError, match=r"is a folder without metadata\.yaml, so no bag of ROS 2"):
        tb.import_log(tmp_path, logs.ROS_MAP)


def test_more_than_fits_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(streams, "MOST_VALUES", 1000)
    for name, (write, keys) in WRITERS.items():
        with pytest.raises(tb.InputError, match="holds more than the 1,000 values"):
            tb.import_log(write(tmp_path / name), keys)
    monkeypatch.setattr(ulog, "LARGEST", 1000)
    with pytest.raises(tb.InputError, match="GB large"):
        tb.import_log(tmp_path / "a.ulg", logs.ULOG_MAP)


# Tables.

COLUMNS = ["t", "gx", "gy", "gz", "mx", "my", "mz"]
TABLE_MAP = {
    "schema": 1,
    "clock": {"field": "t", "unit": "ms"},
    "channels": {
        "body_rate": {"fields": ["gx", "gy", "gz"], "unit": "deg/s"},
        "applied_torque": {"fields": ["mx", "my", "mz"], "unit": "N*m"},
    },
}


def rows(count: int = 30) -> list[list[str]]:
    return [[str(5 * row), f"{0.5 * row}", "1", "-2.5", "0.1", "0.2", "0.3"] for row in range(count)]


def text(separator: str = ",", names: list[str] = COLUMNS, table: list[list[str]] | None = None) -> str:
    return "\n".join(separator.join(cells) for cells in [names, *(rows() if table is None else table)]) + "\n"


def imported(tmp_path: Path, content: str | bytes, keys: dict = TABLE_MAP) -> tb.ImportedRecords:
    path = tmp_path / "a.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return tb.import_log(path, keys)


@pytest.mark.parametrize(
    "content",
    [
        text(),
        text(";"),
        text("\t"),
        text(";").replace(".", ","),
        "# my log\n# of today\n" + text(),
        "# " + text(),
        "\ufeff" + text(),
        "\ufeff# my log\n# of today\n" + text(),
        text(table=[["ms", *["deg/s"] * 3, *["N*m"] * 3], *rows()]),
        text().replace("\n", "\r\n"),
        text(names=[*COLUMNS, "Größe"], table=[[*cells, "°"] for cells in rows()]).encode("latin-1"),
    ],
)
def test_csv_as_programs_and_countries_write_it(tmp_path, content):
    record = imported(tmp_path, content).runs[0]
    np.testing.assert_allclose(record.time, 0.005 * np.arange(30), atol=1e-15)
    np.testing.assert_allclose(record.channels["body_rate"][:, 0], np.radians(0.5 * np.arange(30)), rtol=1e-14)
    np.testing.assert_allclose(record.channels["body_rate"][:, 2], np.radians(-2.5), rtol=1e-14)


def test_dates_are_clocks(tmp_path):
    table = [[f"2026-03-01 12:00:00.{5 * row:03}", *cells[1:]] for row, cells in enumerate(rows())]
    records = imported(tmp_path, text(table=table), TABLE_MAP | {"clock": {"field": "t"}})
    np.testing.assert_allclose(records.runs[0].time, 0.005 * np.arange(30), atol=1e-12)


def test_parquet_with_any_names(tmp_path):
    columns = {name: pa.array([float(cells[place]) for cells in rows()]) for place, name in enumerate(COLUMNS)}
    columns["t"] = pa.array([1_760_000_000_000_000 + 5000 * row for row in range(30)], pa.timestamp("us"))
    pyarrow.parquet.write_table(pa.table(columns | {"note": ["x"] * 30}), tmp_path / "a.parquet")
    records = tb.import_log(tmp_path / "a.parquet", TABLE_MAP | {"clock": {"field": "t"}})
    np.testing.assert_allclose(records.runs[0].time, 0.005 * np.arange(30), atol=1e-12)
    assert records.unused == ("note",)


def test_cells_of_one_component_that_are_empty_are_said(tmp_path):
    table = rows()
    table[3][2] = table[9][2] = table[9][3] = ""
    records = imported(tmp_path, text(table=table))
    assert records.dropped == ("body_rate: 2 samples lack some of their values: kept, with cells that are empty",)
    assert np.isnan(records.runs[0].channels["body_rate"]).any(axis=1).sum() == 2


def test_words_and_ragged_rows_are_left_out_and_said(tmp_path):
    table = rows()
    table[3][1], table[4][0], table[6] = "n/a", "", table[6][:4]
    records = imported(tmp_path, text(table=table))
    assert records.dropped == (
        "1 row has another number of fields than the header (row 7: 4 fields of 7): left out",
        "column gx: 1 cell is no number but 'n/a': taken as not sampled",
        "body_rate: 1 samples without time or value left out",
        "body_rate: 1 samples lack some of their values: kept, with cells that are empty",
        "applied_torque: 1 samples without time or value left out",
    )
    assert len(records.runs[0].time) == 28


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (text(names=["0"] * 7), "does not begin with the names of its columns"),
        (text(names=["t", "gx", "gx", "gz", "mx", "my", "mz"]), "more than one column is called 'gx'"),
        (text(names=["t", "wx", "wy", "wz", "mx", "my", "mz"]), "column gx: is not there; did you mean"),
        ("hello\n1\n", "column gx: is not there"),
        (
            text(table=[[cell if at != 1 else "nan" for at, cell in enumerate(row)] for row in rows()]),
            "gx: has no values",
        ),
        (text(table=[[cell if at != 1 else "" for at, cell in enumerate(row)] for row in rows()]), "gx: has no values"),
        (
            text(table=[[cell if at != 1 else "bad" for at, cell in enumerate(row)] for row in rows()]),
            "gx: has no values",
        ),
    ],
)
def test_a_table_that_is_not_the_maps_is_refused(tmp_path, content, says):
    with pytest.raises(tb.InputError, match=says):
        imported(tmp_path, content)
