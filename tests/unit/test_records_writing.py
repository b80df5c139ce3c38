"""Writing runs: whole files, under the right names, that read back as they were."""

import numpy as np
import pytest

from testbed.errors import InputError
from testbed.records.reading import read_data_set, read_record
from testbed.records.record import Record, RunDetails
from testbed.records.writing import write_record
from testbed.signals import SIGNALS


def full_record(name="run", **details):
    """A record with every signal of the table, telemetry sampled in every fifth row only."""
    rng = np.random.default_rng(5)
    channels = {signal.name: rng.normal(size=(60, signal.width)) for signal in SIGNALS.values()}
    channels["attitude"] /= np.linalg.norm(channels["attitude"], axis=1, keepdims=True)
    for signal in SIGNALS.values():
        channels[signal.name][np.arange(60) % 5 != 0] *= np.nan if signal.telemetry else 1.0
    return Record(
        time=np.arange(60) / 80,
        channels=channels,
        details=RunDetails(name=name, **details),
        extra_columns={"count": np.arange(60), "remark": np.array(["a,b", None] * 30, dtype=object)},
    )


def assert_same(first, second):
    np.testing.assert_array_equal(first.time, second.time)
    assert list(first.channels) == list(second.channels)
    for name, values in first.channels.items():
        np.testing.assert_array_equal(values, second.channels[name])
    assert first.extra_columns.keys() == second.extra_columns.keys()
    for name, values in first.extra_columns.items():
        np.testing.assert_array_equal(values, second.extra_columns[name])
    assert first.details == second.details


@pytest.mark.parametrize("suffix", ["parquet", "csv"])
def test_every_signal_comes_back(tmp_path, suffix):
    record = full_record(source="simulated", gyro_noise=0.025, usable_to=0.6, role="heldout")
    path = write_record(record, tmp_path / f"run.{suffix}")
    assert path == tmp_path / f"run.{suffix}"
    assert_same(read_record(path), record)


def test_a_folder_takes_the_runs_name(tmp_path):
    for name in ("parabola 2", "v1.2"):
        write_record(full_record(name), tmp_path / "new" / "data.set")
    folder = tmp_path / "new" / "data.set"
    assert sorted(path.name for path in folder.iterdir()) == ["parabola 2.parquet", "v1.2.parquet"]
    assert [record.details.name for record in read_data_set(folder)] == ["parabola 2", "v1.2"]


def test_details_lie_beside_the_table_and_go_when_there_is_nothing_to_say(tmp_path):
    write_record(full_record("flight"), tmp_path / "record.parquet")
    assert (tmp_path / "record.toml").read_text() == 'name = "flight"\n'
    write_record(full_record("record"), tmp_path / "record.parquet")
    assert [path.name for path in tmp_path.iterdir()] == ["record.parquet"]


def test_what_was_not_sampled_is_an_empty_csv_field(tmp_path):
    header, first, second = write_record(full_record(), tmp_path / "run.csv").read_text().splitlines()[:3]
    column = header.replace('"', "").split(",").index("body_rate_x_rad_s")
    assert first.split(",")[column] != ""
    assert second.split(",")[column] == ""


@pytest.mark.parametrize("name", ["a/b", "..", ".hidden"])
def test_a_name_that_is_no_file_name_is_refused_for_a_folder_only(tmp_path, name):
    with pytest.raises(InputError, match="cannot be a file name; give a file, not a folder"):
        write_record(full_record(name), tmp_path)
    assert read_record(write_record(full_record(name), tmp_path / "run.csv")).details.name == name


def test_a_failed_write_leaves_the_former_run_and_nothing_else(tmp_path):
    former = full_record(role="fit")
    write_record(former, tmp_path / "run.parquet")
    broken = full_record(role="heldout")
    broken.extra_columns["count"] = np.arange(3)
    with pytest.raises(ValueError, match="length"):
        write_record(broken, tmp_path / "run.parquet")
    assert_same(read_record(tmp_path / "run.parquet"), former)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.parquet", "run.toml"]


def test_a_write_that_fails_half_way_leaves_nothing(tmp_path):
    (tmp_path / "run.toml").mkdir()
    with pytest.raises(InputError, match=r"run\.parquet: cannot be written"):
        write_record(full_record(role="fit"), tmp_path / "run.parquet")
    assert [path.name for path in tmp_path.iterdir()] == ["run.toml"]


def test_a_folder_that_cannot_be_written_to_is_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match=r"file/run\.parquet: cannot be written"):
        write_record(full_record(), tmp_path / "file")
