"""Reading runs: what is taken as it is, and what is refused, with file, column, row and remedy in the message."""

import os
from hashlib import sha256

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from testbed.errors import InputError
from testbed.records.reading import extra_columns_notice, read_data_set, read_record

ROWS = 12
AXES = "xyz"


def good_columns():
    """A run of a platform under applied torque, the smallest that can be used."""
    time = np.arange(ROWS) / 16
    columns = {"time_s": time}
    columns |= {f"body_rate_{axis}_rad_s": 0.1 * np.sin(time + k) for k, axis in enumerate(AXES)}
    return columns | {f"applied_torque_{axis}_N_m": 0.01 * np.cos(time + k) for k, axis in enumerate(AXES)}


HEADER = ",".join(good_columns()).encode()


def write_csv(path, columns):
    rows = zip(*columns.values(), strict=True)
    cell = lambda value: value if isinstance(value, str) else repr(float(value))  # noqa: E731
    path.write_text("\n".join([",".join(columns), *(",".join(map(cell, row)) for row in rows)]) + "\n")
    return path


def write_parquet(path, columns):
    pa.parquet.write_table(pa.table(columns), path)
    return path


@pytest.fixture(params=["csv", "parquet"])
def write(request, tmp_path):
    """Write columns as a run, in either form."""
    writer = {"csv": write_csv, "parquet": write_parquet}[request.param]
    return lambda columns: writer(tmp_path / f"run.{request.param}", columns)


def changed(column, row, value):
    columns = good_columns()
    columns[column][row] = value
    return columns


def refusal(path):
    with pytest.raises(InputError) as caught:
        read_record(path)
    message = str(caught.value)
    assert str(path) in message
    return message


def test_a_good_run_is_read_as_it_is(write):
    columns = good_columns()
    record = read_record(write(columns))
    np.testing.assert_array_equal(record.time, columns["time_s"])
    assert set(record.channels) == {"body_rate", "applied_torque"}
    expected = np.column_stack([columns[f"body_rate_{axis}_rad_s"] for axis in AXES])
    np.testing.assert_array_equal(record.channels["body_rate"], expected)
    assert record.channels["body_rate"].dtype == np.float64
    assert record.details.name == "run"
    assert extra_columns_notice(record) is None


def test_columns_are_found_by_name_not_by_place(write):
    backwards = dict(reversed(good_columns().items()))
    np.testing.assert_array_equal(
        read_record(write(backwards)).channels["body_rate"], read_record(write(good_columns())).channels["body_rate"]
    )


@pytest.mark.parametrize("name", ["gimbal_angle_{}_rad", "cluster_momentum_{}_N_m_s"])
def test_one_momentum_source_is_enough(write, name):
    columns = {key: values for key, values in good_columns().items() if "torque" not in key}
    components = "123456" if "gimbal" in name else AXES
    record = read_record(write(columns | {name.format(c): np.ones(ROWS) for c in components}))
    assert len(record.channels) == 2


def test_unknown_columns_are_kept_and_named(write):
    record = read_record(write(good_columns() | {"motor_command_1": np.linspace(0, 1, ROWS), "remark": ["ok"] * ROWS}))
    np.testing.assert_array_equal(record.extra_columns["motor_command_1"], np.linspace(0, 1, ROWS))
    assert record.extra_columns["remark"].tolist() == ["ok"] * ROWS
    assert extra_columns_notice(record) == "run: kept, but not used: motor_command_1, remark"


def test_empty_csv_fields_and_nan_are_not_sampled(tmp_path):
    columns = good_columns()
    torque = [str(value) for value in columns["applied_torque_x_N_m"]]
    torque[3:7] = ["", "NaN", " ", "nan"]
    record = read_record(write_csv(tmp_path / "run.csv", columns | {"applied_torque_x_N_m": torque}))
    assert np.flatnonzero(np.isnan(record.channels["applied_torque"][:, 0])).tolist() == [3, 4, 5, 6]


def test_parquet_nulls_are_not_sampled(tmp_path):
    columns = good_columns()
    torque = columns["applied_torque_x_N_m"].tolist()
    torque[3] = None
    record = read_record(write_parquet(tmp_path / "run.parquet", columns | {"applied_torque_x_N_m": torque}))
    assert np.flatnonzero(np.isnan(record.channels["applied_torque"][:, 0])).tolist() == [3]


def test_spreadsheet_habits_are_understood(tmp_path):
    """A byte order mark, Windows line ends, blanks around numbers, whole numbers."""
    path = write_csv(tmp_path / "run.csv", good_columns() | {"applied_torque_x_N_m": ["1"] * ROWS})
    text = path.read_text().replace("\n", "\r\n").replace("\r\n0.0,", "\r\n 0.0 ,")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    record = read_record(path)
    assert record.time[0] == 0.0
    assert (record.channels["applied_torque"][:, 0] == 1.0).all()


def test_gaps_and_jitter_are_allowed(write):
    columns = good_columns()
    columns["time_s"] = np.cumsum(np.linspace(0.01, 0.3, ROWS))
    assert read_record(write(columns)).time[-1] == columns["time_s"][-1]


def test_single_precision_columns_are_widened(tmp_path):
    columns = {name: values.astype(np.float32) for name, values in good_columns().items()}
    record = read_record(write_parquet(tmp_path / "run.parquet", columns))
    assert record.time.dtype == record.channels["body_rate"].dtype == np.float64


@pytest.mark.parametrize(
    ("column", "row", "value", "message"),
    [
        ("time_s", 4, 0.125, "time_s in row 5 goes back from 0.1875 s: sort the rows"),
        ("time_s", 4, 0.1875, "time_s in row 5 repeats 0.1875 s: sort the rows"),
        ("time_s", 4, np.nan, "time_s in row 5 is not a finite number"),
        ("time_s", 4, np.inf, "time_s in row 5 is not a finite number"),
        ("body_rate_y_rad_s", 2, np.inf, "column body_rate_y_rad_s is infinite in row 3: leave empty"),
        (
            "body_rate_y_rad_s",
            7,
            5.73e4,
            "column body_rate_y_rad_s reaches 5.73e+04 rad/s in row 8: bring it to rad/s",
        ),
        ("body_rate_x_rad_s", slice(3), np.nan, "body_rate has 9 samples, at least 10 are needed"),
        ("applied_torque_z_N_m", 3, -1e300, "column applied_torque_z_N_m reaches 1e+300 in row 4: bring it to SI"),
        ("applied_torque_z_N_m", slice(None), np.nan, "column applied_torque_z_N_m has no value in any row"),
    ],
)
def test_wrong_values_are_refused(write, column, row, value, message):
    assert message in refusal(write(changed(column, row, value)))


@pytest.mark.parametrize("period", [12.5, 62.5, 62500.0])
def test_time_that_is_not_in_seconds_is_refused(write, period):
    """80 Hz and 16 Hz in milliseconds, and 16 Hz in microseconds."""
    assert "divide it by 1e3 (ms)" in refusal(write(good_columns() | {"time_s": period * np.arange(ROWS)}))


def test_fast_rates_are_read_and_left_to_what_there_is_to_compare_them_with(write):
    assert read_record(write(changed("body_rate_x_rad_s", 1, -22.0))).channels["body_rate"][1, 0] == -22.0
    assert "bring it to rad/s" in refusal(write(changed("body_rate_x_rad_s", 1, -10000.1)))


@pytest.mark.parametrize("rows", [0, 1, 9])
def test_too_few_samples_are_refused(write, rows):
    columns = {name: values[:rows] for name, values in good_columns().items()}
    assert f"body_rate has {rows} samples, at least 10 are needed: take a longer part" in refusal(write(columns))


@pytest.mark.parametrize(
    ("left_out", "message"),
    [
        (["time_s"], "column time_s is missing; the columns are body_rate_x_rad_s, body_rate_y_rad_s"),
        (["body_rate_y_rad_s"], "channel body_rate is incomplete: add body_rate_y_rad_s (empty where a rig does not"),
        ([f"body_rate_{axis}_rad_s" for axis in AXES], "channel body_rate is missing: add body_rate_x_rad_s"),
        (
            [f"applied_torque_{axis}_N_m" for axis in AXES],
            "turned the platform: add one of gimbal_angle, wheel_speed, cluster_momentum, applied_torque",
        ),
    ],
)
def test_missing_columns_are_refused(write, left_out, message):
    columns = {name: values for name, values in good_columns().items() if name not in left_out}
    assert message in refusal(write(columns))


def test_a_log_of_another_program_is_referred_to_the_import(write):
    message = refusal(write({"MET_ms": np.arange(ROWS), "GYR_P_dps": np.zeros(ROWS)}))
    assert "none of its columns is a channel of a record: MET_ms, GYR_P_dps" in message
    assert "testbed import LOG --guess" in message
    assert "missing" not in message, "one thing is wrong with it"


@pytest.mark.parametrize(
    ("right", "wrong", "remedy"),
    [
        ("body_rate_x_rad_s", "body_rate_x_deg_s", "multiply it by 0.01745329252 and name it body_rate_x_rad_s"),
        ("body_rate_x_rad_s", "body_rate_x_dps", "multiply it by 0.01745329252 and name it body_rate_x_rad_s"),
        ("body_rate_x_rad_s", "body_rate_x", "does not say its unit: bring it to SI and name it body_rate_x_rad_s"),
        ("time_s", "time_ms", "multiply it by 0.001 and name it time_s"),
        ("applied_torque_x_N_m", "applied_torque_x_mNm", "multiply it by 0.001 and name it applied_torque_x_N_m"),
    ],
)
def test_a_unit_in_a_columns_name_is_refused_with_the_factor(write, right, wrong, remedy):
    columns = {wrong if name == right else name: values for name, values in good_columns().items()}
    message = refusal(write(columns))
    assert f"column {wrong}" in message
    assert remedy in message
    assert "missing" not in message, "the column is there, in another unit"


def test_all_problems_of_a_header_are_named_at_once(write):
    columns = good_columns()
    columns["body_rate_x_deg_s"] = columns.pop("body_rate_x_rad_s")
    del columns["time_s"], columns["applied_torque_y_N_m"]
    message = refusal(write(columns))
    assert "body_rate_x_deg_s" in message
    assert "time_s is missing" in message
    assert "applied_torque is incomplete" in message


def test_a_long_list_of_problems_is_cut(tmp_path):
    columns = {name: ["0.1"] * ROWS for name in good_columns()} | {"time_s": list(good_columns()["time_s"])}
    text = write_csv(tmp_path / "run.csv", columns).read_text().splitlines()
    (tmp_path / "run.csv").write_text("\n".join([text[0], *(line + ",9" for line in text[1:])]))
    message = refusal(tmp_path / "run.csv")
    assert "row 1 has 8 fields, the header 7" in message
    assert message.endswith("... and 2 more")


def test_a_cell_that_is_no_number_is_named(tmp_path):
    columns = good_columns() | {"applied_torque_y_N_m": ["0.1"] * 6 + ["0,1 N"] + ["?"] * 5}
    path = write_parquet(tmp_path / "run.parquet", columns)
    assert "column applied_torque_y_N_m is '0,1 N' in row 7, not a number: correct it" in refusal(path)
    columns["applied_torque_y_N_m"][6] = "1.2.3"
    path = write_csv(tmp_path / "run.csv", columns)
    assert "column applied_torque_y_N_m is '1.2.3' in row 7, not a number" in refusal(path)


def test_a_column_of_another_kind_is_named(tmp_path):
    path = write_parquet(tmp_path / "run.parquet", good_columns() | {"applied_torque_y_N_m": [[0.1]] * ROWS})
    assert "column applied_torque_y_N_m holds list<" in refusal(path)


def test_a_column_of_true_and_false_is_no_column_of_ones_and_zeros(tmp_path):
    path = write_parquet(tmp_path / "run.parquet", good_columns() | {"applied_torque_y_N_m": [True] * ROWS})
    with pytest.raises(InputError, match="applied_torque_y_N_m holds true and false, not numbers"):
        read_record(path)


def test_a_row_of_another_length_is_named(tmp_path):
    path = write_csv(tmp_path / "run.csv", good_columns())
    lines = path.read_text().splitlines()
    lines[3] = "0.125,0.1"
    path.write_text("\n".join(lines))
    assert "row 3 has 2 fields, the header 7" in refusal(path)


def test_a_repeated_column_is_refused(tmp_path):
    path = write_csv(tmp_path / "run.csv", good_columns())
    path.write_text("\n".join(line + "," + line.split(",")[1] for line in path.read_text().splitlines()))
    assert "column body_rate_x_rad_s appears 2 times" in refusal(path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("run.parquet", b"PAR1 this is not a table", "cannot be read as parquet"),
        ("run.parquet", b"", "cannot be read as parquet"),
        ("run.csv", b"", "cannot be read as csv: its first line is empty"),
        ("run.csv", HEADER + b",remark\n0,0,0,0,0,0,0,23 \xb0C\n", "it is not UTF-8 (byte 0xb0); save it as UTF-8"),
        ("run.csv", HEADER.replace(b",", b";") + b"\n0;1\n", "is separated by semicolons, not by commas: save it"),
        ("run.csv", HEADER.replace(b",", b"\t") + b"\n0\t1\n", "is separated by tabs, not by commas: save it"),
        ("run.xlsx", b"PK", "a record is a file that ends in .csv or .parquet"),
    ],
)
def test_a_file_that_is_no_table_is_refused(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    assert message in refusal(tmp_path / name)


def test_a_missing_file_and_a_folder_in_its_place_are_refused(tmp_path):
    (tmp_path / "folder.csv").mkdir()
    assert "there is no such file" in refusal(tmp_path / "absent.csv")
    assert "cannot be read as csv: Is a directory" in refusal(tmp_path / "folder.csv")


def test_a_data_set_is_read_in_the_order_of_its_names(tmp_path):
    write_csv(tmp_path / "b.csv", good_columns())
    write_parquet(tmp_path / "a.parquet", good_columns())
    write_csv(tmp_path / "c.CSV", good_columns())
    (tmp_path / "a.toml").write_text('name = "zulu"\nrole = "heldout"\n')
    (tmp_path / "ORIGIN.md").write_text("not a run")
    (tmp_path / ".b.csv.part").write_text("not a run")
    (tmp_path / "._b.csv").write_text("not a run")
    names = [(record.details.name, record.details.role) for record in read_data_set(tmp_path)]
    assert names == [("zulu", "heldout"), ("b", None), ("c", None)]


def test_a_folder_without_runs_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"there is no run in this folder: no file ends in \.csv or \.parquet"):
        read_data_set(tmp_path)
    with pytest.raises(InputError, match="there is no such folder"):
        read_data_set(tmp_path / "absent")


def test_two_runs_of_one_name_are_refused(tmp_path):
    write_csv(tmp_path / "a.csv", good_columns())
    write_parquet(tmp_path / "a.parquet", good_columns())
    with pytest.raises(InputError, match="more than one run is called a: keep one file of each run"):
        read_data_set(tmp_path)
    (tmp_path / "a.parquet").rename(tmp_path / "b.parquet")
    (tmp_path / "b.toml").write_text('name = "a"')
    with pytest.raises(InputError, match=r"more than one run is called a: name them differently in their \.toml"):
        read_data_set(tmp_path)


def test_every_unusable_run_of_a_data_set_is_named(tmp_path):
    write_csv(tmp_path / "a.csv", changed("time_s", 4, 0.0))
    write_csv(tmp_path / "b.csv", good_columns())
    (tmp_path / "c.parquet").write_bytes(b"")
    with pytest.raises(InputError, match=r"(?s)a\.csv: time_s in row 5.*c\.parquet: cannot be read"):
        read_data_set(tmp_path)


def test_a_record_of_more_than_fits_is_refused_with_the_number(write, monkeypatch):
    path = write(good_columns())
    monkeypatch.setattr("testbed.records.tables.MOST_VALUES", 7 * (ROWS - 1))
    assert "holds 12 rows or more of 7 columns; at most 11 rows are read of so many (77 values)" in refusal(path)


def test_the_bytes_that_were_read_are_the_ones_that_are_named(write):
    path = write(good_columns() | {"remark": ["±"] * ROWS})
    (stamp,) = read_record(path).files
    assert (stamp.sha256, stamp.size) == (sha256(path.read_bytes()).hexdigest(), path.stat().st_size)


def test_a_fault_beyond_the_first_batch_has_its_own_row(tmp_path, monkeypatch):
    monkeypatch.setattr("testbed.records.tables._BLOCK", 300)
    monkeypatch.setattr("testbed.records.tables._BATCH", 4)
    columns = good_columns() | {"applied_torque_y_N_m": ["0.1"] * 10 + ["?", "0.1"]}
    for path in (write_csv(tmp_path / "a.csv", columns), write_parquet(tmp_path / "b.parquet", columns)):
        assert "column applied_torque_y_N_m is '?' in row 11, not a number" in refusal(path)


def test_a_pipe_in_place_of_a_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "run.csv")
    assert "Is a device or a pipe" in refusal(tmp_path / "run.csv")


def test_blanks_around_the_names_of_columns_are_pointed_at(tmp_path):
    path = tmp_path / "spaced.csv"
    path.write_text("time_s, body_rate_x_rad_s, body_rate_y_rad_s\n0, 1, 2\n", encoding="utf-8")
    with pytest.raises(InputError, match="with a blank, such as ' body_rate_x_rad_s': take the blanks out"):
        read_record(path)
