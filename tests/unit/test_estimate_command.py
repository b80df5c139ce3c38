"""`testbed estimate` on records that do not fit: an honest message for each, and the good ones are not lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.records.reading import read_record

ROOT = Path(__file__).resolve().parents[2]
SCENARIO = ROOT / "scenarios" / "momentum_bias.toml"
RATES = ["body_rate_x_rad_s", "body_rate_y_rad_s", "body_rate_z_rad_s"]
ANGLES = [f"gimbal_angle_{unit}_rad" for unit in range(1, 7)]


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Gyro and encoders of a flight, at the telemetry's times."""
    place = tmp_path_factory.mktemp("flown") / "run"
    assert run("run", SCENARIO, "--out", place) == 0
    record = read_record(place / "record.parquet")
    rows = np.isfinite(record.channels["gimbal_angle"]).all(axis=1)
    return record.time[rows], record.channels["body_rate"][rows], record.channels["gimbal_angle"][rows]


def write(folder: Path, name: str, time, rate, angle) -> None:
    folder.mkdir(exist_ok=True)
    header = ",".join(["time_s", *RATES, *ANGLES])
    np.savetxt(folder / f"{name}.csv", np.column_stack([time, rate, angle]), delimiter=",", header=header, comments="")


def test_a_good_record_gives_an_estimate(flown, tmp_path, capsys):
    write(tmp_path / "data", "good", *flown)
    assert run("estimate", SCENARIO, "--data", tmp_path / "data") == 0
    assert "output error" in capsys.readouterr().out


def test_a_gyro_that_reads_zero_determines_nothing(flown, tmp_path, capsys):
    time, rate, angle = flown
    write(tmp_path / "data", "dead", time, 0.0 * rate, angle)
    assert run("estimate", SCENARIO, "--data", tmp_path / "data") == 2
    assert "cannot be determined" in capsys.readouterr().err


def test_a_flipped_gyro_is_the_inertia_of_no_body(flown, tmp_path, capsys):
    time, rate, angle = flown
    write(tmp_path / "data", "flipped", time, -rate, angle)
    run("estimate", SCENARIO, "--data", tmp_path / "data")
    printed = capsys.readouterr()
    assert "no body: check the signs" in printed.out + printed.err


def test_milliseconds_are_not_taken_for_seconds(flown, tmp_path, capsys):
    time, rate, angle = flown
    write(tmp_path / "data", "slow", 1e3 * time, rate, angle)
    assert run("estimate", SCENARIO, "--data", tmp_path / "data") == 2
    assert "divide it by 1e3" in capsys.readouterr().err


def test_a_bad_record_does_not_lose_the_good_one(flown, tmp_path, capsys):
    time, rate, angle = flown
    write(tmp_path / "data", "good", *flown)
    write(tmp_path / "data", "dead", time, 0.0 * rate, angle)
    assert run("estimate", SCENARIO, "--data", tmp_path / "data", "--out", tmp_path / "out") == 0
    printed = capsys.readouterr().out
    assert "left out" in printed
    assert "good: inertia" in printed
    assert (tmp_path / "out" / "report.html").is_file()


def test_a_file_in_place_of_the_folder_is_said_to_be_one(flown, tmp_path, capsys):
    write(tmp_path / "data", "good", *flown)
    assert run("estimate", SCENARIO, "--data", tmp_path / "data" / "good.csv") == 2
    assert "is a file" in capsys.readouterr().err
