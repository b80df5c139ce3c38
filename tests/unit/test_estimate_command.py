"""`testbed estimate` on records that do not fit: an honest message for each, and the good ones are not lost."""

from __future__ import annotations

import json
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


@pytest.mark.parametrize(
    ("rate_factor", "angle_factor", "message"),
    [
        (-1.0, 1.0, "turn the signs of the gyro"),
        (np.degrees(1.0), 1.0, "as if it were in deg/s: multiply it by 0.01745329252"),
        (1.0, np.degrees(1.0), "the gimbals' angles were in deg (multiply them by 0.01745329252)"),
    ],
)
def test_records_in_other_units_are_refused_before_any_number(
    flown, tmp_path, capsys, rate_factor, angle_factor, message
):
    time, rate, angle = flown
    write(tmp_path / "data", "wrong", time, rate_factor * rate, angle_factor * angle)
    assert run("estimate", SCENARIO, "--data", tmp_path / "data", "--out", tmp_path / "out") == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert "inertia" not in printed.out
    assert not (tmp_path / "out").exists()


def test_rotor_speeds_in_rpm_are_refused(flown, tmp_path, capsys):
    time, rate, angle = flown
    (tmp_path / "data").mkdir()
    speeds = [f"rotor_speed_{unit}_rad_s" for unit in range(1, 7)]
    header = ",".join(["time_s", *RATES, *ANGLES, *speeds])
    rpm = np.full((len(time), 6), 471.4 * 30.0 / np.pi)
    table = np.column_stack([time, rate, angle, rpm])
    np.savetxt(tmp_path / "data" / "rpm.csv", table, delimiter=",", header=header, comments="")
    assert run("estimate", SCENARIO, "--data", tmp_path / "data") == 2
    assert "times the scenario's inertia" in capsys.readouterr().err


def test_a_spike_is_left_out_and_reported_and_costs_no_precision(flown, tmp_path, capsys):
    time, rate, angle = flown
    spoiled = rate.copy()
    spoiled[40, 1] += 5.0
    write(tmp_path / "clean", "run", *flown)
    write(tmp_path / "spiked", "run", time, spoiled, angle)
    stds = {}
    for name in ("clean", "spiked"):
        assert run("estimate", SCENARIO, "--data", tmp_path / name, "--out", tmp_path / f"{name}-out") == 0
        content = json.loads((tmp_path / f"{name}-out" / "estimates.json").read_text(encoding="utf-8"))
        stds[name] = np.array(content["records"]["run"]["estimates"]["output_error"]["std_kg_m2"])
        assert content["records"]["run"]["outliers"] == (name == "spiked")
    assert "1 gyro sample stands alone, far from the neighbours: left out" in capsys.readouterr().out
    np.testing.assert_allclose(stds["spiked"], stds["clean"], rtol=0.1)


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


def test_a_long_record_is_estimated_from_in_parts_and_combined(flown, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("testbed.identification.identify.MOST_AT_ONCE", 60)
    write(tmp_path / "data", "long", *flown)
    assert run("estimate", SCENARIO, "--data", tmp_path / "data", "--out", tmp_path / "out") == 0
    estimates = json.loads((tmp_path / "out" / "estimates.json").read_text(encoding="utf-8"))
    assert set(estimates["records"]) == {"long part 1", "long part 2"}
    said = capsys.readouterr().out
    assert "2 parts of one record combined" in said
    assert "was estimated from 2 parts of one record" in said


def test_on_an_air_bearing_records_give_one_centre_of_mass_with_an_interval(tmp_path, capsys):
    """Two flights of the table, and what all records together say in the terminal and in estimates.json."""
    quick = ["--set", "simulation.duration_s=12.0", "--set", "estimation.estimators=['output_error']"]
    (tmp_path / "data").mkdir()
    for seed in (1, 2):
        place = tmp_path / f"run{seed}"
        assert run("run", "air_bearing", *quick, "--set", f"seed={seed}", "--out", place) == 0
        (place / "record.parquet").rename(tmp_path / "data" / f"r{seed}.parquet")
        details = (place / "record.toml").read_text(encoding="utf-8")
        details = details.replace('name = "air_bearing"', f'name = "flight {seed}"')
        (tmp_path / "data" / f"r{seed}.toml").write_text(details, encoding="utf-8")
    capsys.readouterr()
    assert run("estimate", "air_bearing", *quick, "--data", tmp_path / "data", "--out", tmp_path / "out") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "2 records combined: Centre of mass, from the pivot, estimated jointly:" in printed
    assert "With 95 % it lies within" in printed
    result = json.loads((tmp_path / "out" / "estimates.json").read_text(encoding="utf-8"))
    together = result["combined"]["output_error"]
    std = np.array(together["center_of_mass_offset_std_m"])
    alone = [each["estimates"]["output_error"]["center_of_mass_offset_std_m"] for each in result["records"].values()]
    assert (std < np.array(alone)).all()
    assert (np.abs(together["center_of_mass_offset_m"] - np.array([2.4e-5, -1.7e-5, -1.3e-4])) < 4.0 * std).all()
    assert result["combined_checks"]["runs_agreement"]["output_error"]["freedom"] == 9
