"""`testbed diagnose`: its answer in the terminal and in diagnosis.json, its exit codes, and what Ctrl-C leaves."""

from __future__ import annotations

import json
import shutil
import signal
from dataclasses import replace

import numpy as np
import pytest

import testbed.cli.diagnose
import testbed.library.prepared_records
from support.diagnosed_records import SCENARIO, records
from support.few_effects import know_only
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.diagnosis.method import diagnosed
from testbed.effects.gyro_latency import GyroLatency
from testbed.records.record import Record, RunDetails
from testbed.records.writing import write_record
from testbed.scenario.reader import read_scenario

DELAY = 0.02
STEP_KEYS = {
    "effect",
    "component",
    "parameters",
    "probability",
    "j_theta_kg_m2",
    "j_std_kg_m2",
    "indistinguishable_from",
    "doubts",
    "gap_before",
    "gap_after",
    "heldout_gap_before",
    "heldout_gap_after",
    "misfit",
}
"""Of a step in diagnosis.json."""
KEYS = {"schema", "complete", "verdict", "steps", "gap", "where", "probabilities", "untestable", "model", "scenario"}
"""Of diagnosis.json; there may be more."""


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """Three runs whose gyro is late."""
    folder = tmp_path_factory.mktemp("late")
    for record in records(3, hooks=[GyroLatency().hooks("gyro")], values=[np.array([DELAY])]):
        write_record(record, folder / f"{record.details.name}.csv")
    return folder


@pytest.fixture
def few_effects(monkeypatch):
    """A library that is tried in a second; the whole one is tried elsewhere."""
    know_only(monkeypatch, "gyro_latency", "viscous_drag", "gyro_bias")


@pytest.mark.usefixtures("few_effects")
def test_a_late_gyro_is_named_and_everything_is_written(late, tmp_path, capsys):
    out = tmp_path / "out"
    assert run("diagnose", SCENARIO, "--data", late, "--out", out) == 0
    printed = capsys.readouterr().out
    assert "Missing in the nominal model: gyro_latency (gyro)" in printed
    assert "held out: run3" in printed
    answer = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert answer.keys() >= KEYS
    assert answer["verdict"] == "named"
    assert answer["complete"] is True
    (step,) = [step for step in answer["steps"] if step["effect"] != "inertia"]
    assert step.keys() == STEP_KEYS
    delay = step["parameters"]["delay_s"]
    assert abs(delay["value"] - DELAY) < 4.0 * delay["std"]  # by chance once in 16,000; the seed is fixed
    assert delay["unit"] == "s"
    assert answer["gap"]["heldout_after"] < 1.3 < answer["gap"]["heldout_before"]
    misfit = answer["misfit"]
    assert misfit["before"]["sigma"] > 3.0 * misfit["before"]["noise_limit_sigma"]
    assert misfit["after"]["sigma"] < misfit["after"]["noise_limit_sigma"]
    assert min(misfit["explained"], misfit["heldout_explained"]) > 0.9
    before_after = step["misfit"]  # the only step, before and after it the noise is estimated anew
    assert before_after["before"]["sigma"] == pytest.approx(misfit["before"]["sigma"], rel=0.1)
    assert before_after["after"]["sigma"] < before_after["after"]["noise_limit_sigma"]
    assert "% explained) on the fitted runs" in printed
    assert answer["where"][0]["depends_on"].startswith("body_acceleration")
    assert read_scenario(out / answer["scenario"]).gyro.latency_s == pytest.approx(delay["value"])
    assert (out / answer["model"]).is_file()
    page = (out / "report.html").read_text(encoding="utf-8")
    for expected in (
        "gyro_latency",
        "Misfit after each step",
        "Effects, ranked",
        "Nothing added",
        "With 1 added",
        "Run by run",
    ):
        assert expected in page
    assert "the 3 runs differ by no more than chance makes them" in printed
    (agreed,) = answer["run_by_run"]
    assert agreed["p_value"] > 0.01
    own = {name: estimate["delay_s"] for name, estimate in agreed["runs"].items()}
    assert own.keys() == {"run1", "run2", "run3"}
    assert all(abs(each["value"] - DELAY) < 4.0 * each["std"] for each in own.values())
    assert (out / "recording.rrd").stat().st_size > 0


def test_look_alikes_end_with_a_flight_that_tells_them_apart(late, tmp_path, capsys, monkeypatch):
    know_only(monkeypatch, "gyro_latency", "gyro_bandwidth")
    out = tmp_path / "out"
    assert run("diagnose", SCENARIO, "--data", late, "--out", out) == 0
    answer = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert answer["verdict"] == "ambiguous"
    (pair,) = answer["next"]["pairs"]
    assert set(pair["pair"]) == {"gyro_latency:gyro", "gyro_bandwidth:gyro"}
    assert pair["sigma_now"] < pair["sigma_after"]
    flown = read_scenario(out / answer["next"]["scenario"])
    assert flown.maneuver.kind == "control_points"
    assert flown.gyro.latency_s == 0.0  # the nominal platform: which of the two it is, only the flight tells
    printed = capsys.readouterr().out
    assert "Next" in printed
    assert "after one flight" in printed
    assert "What to fly next" in (out / "report.html").read_text(encoding="utf-8")


def notices_of(folder):
    return json.loads((folder / "diagnosis.json").read_text())["notices"]


@pytest.mark.usefixtures("few_effects")
def test_a_single_run_gets_no_name_and_the_reason_is_stated(late, tmp_path, capsys):
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.copyfile(late / "run1.csv", alone / "run1.csv")
    assert run("diagnose", SCENARIO, "--data", alone, "--out", tmp_path / "out") == 0
    said = "a single run gets no name"
    assert said in capsys.readouterr().out
    assert any(notice.startswith(said) for notice in notices_of(tmp_path / "out"))
    answer = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert answer["verdict"] == "unexplained"
    assert answer["probabilities"]["gyro_latency:gyro"] > 0.5


@pytest.mark.usefixtures("few_effects")
def test_without_a_run_held_out_what_is_found_is_said_to_be_verified_on_none(tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    for record in records(2, hooks=[GyroLatency().hooks("gyro")], values=[np.array([DELAY])]):
        fitted = replace(record, details=replace(record.details, role="fit"))
        write_record(fitted, data / f"{record.details.name}.csv")
    assert run("diagnose", SCENARIO, "--data", data, "--out", tmp_path / "out") == 0
    assert any(notice.startswith("no run is held out") for notice in notices_of(tmp_path / "out"))


@pytest.mark.usefixtures("few_effects")
@pytest.mark.parametrize(
    ("sent", "at_ctrl_c"),
    [
        (signal.SIGINT, signal.default_int_handler),
        (signal.SIGTERM, signal.default_int_handler),
        (signal.SIGTERM, signal.SIG_IGN),  # in a script's background
    ],
)
def test_an_interrupted_diagnosis_keeps_what_was_found(late, tmp_path, capsys, monkeypatch, sent, at_ctrl_c):
    before = signal.signal(signal.SIGINT, at_ctrl_c)

    def interrupted(*arguments, **options):
        yield next(iter(diagnosed(*arguments, **options)))
        signal.raise_signal(sent)

    monkeypatch.setattr(testbed.library.prepared_records, "diagnosed", interrupted)
    ended = run("diagnose", SCENARIO, "--data", late, "--out", tmp_path / "out")
    as_json = run("diagnose", SCENARIO, "--data", late, "--out", tmp_path / "json", "--json")
    signal.signal(signal.SIGINT, before)
    assert (ended, as_json) == (130, 130)
    answer = json.loads((tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8"))
    assert answer["complete"] is False
    assert answer["verdict"] is None
    assert "Interrupted: incomplete, without a verdict" in (tmp_path / "out" / "report.html").read_text(
        encoding="utf-8"
    )
    assert answer["gap"]["before"] > 1.3
    printed, complaints = capsys.readouterr()
    assert "Interrupted" in printed
    assert "Verdict    not reached" in printed
    assert complaints.startswith("Interrupted; ")
    assert "--resume" in complaints


@pytest.mark.usefixtures("few_effects")
def test_an_interruption_while_the_results_are_written_keeps_what_was_worked_out(late, tmp_path, capsys, monkeypatch):
    """It said no more than that it was interrupted, behind a printed verdict."""

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(testbed.cli.diagnose, "concluded", interrupted)
        assert run("diagnose", SCENARIO, "--data", late, "--out", tmp_path / "out") == 130
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["parts.jsonl"]
    said = " ".join("".join(capsys.readouterr()).split())
    assert "Interrupted before the folder was written; what was worked out is kept: " in said
    assert "--resume to go on." in said
    assert run("diagnose", SCENARIO, "--data", late, "--out", tmp_path / "out", "--resume") == 0
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8"))["complete"] is True


@pytest.mark.usefixtures("few_effects")
def test_an_interruption_before_anything_was_found_writes_nothing(late, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(testbed.library.prepared_records, "diagnosed", interrupted)
    assert run("diagnose", SCENARIO, "--data", late, "--out", tmp_path / "out") == 130
    assert not (tmp_path / "out").exists()


def test_data_that_cannot_be_used_end_with_a_message_and_no_answer(tmp_path, capsys):
    write_record(records(1, seconds=0.3)[0], tmp_path / "data" / "short.csv")
    assert run("diagnose", SCENARIO, "--data", tmp_path / "data", "--out", tmp_path / "out") == 2
    assert "at least 10 are needed" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_look_alikes_of_a_platform_without_gimbals_end_with_the_reason_why_no_flight_follows(
    tmp_path, capsys, monkeypatch
):
    know_only(monkeypatch, "actuator_lag", "actuator_delay")
    scenario, data, out = quadcopter(tmp_path), tmp_path / "data", tmp_path / "out"
    for number in (1, 2, 3):
        write_record(slow_roll(number, delay=0.02), data / f"roll_{number}.csv")
    assert run("diagnose", scenario, "--data", data, "--out", out) == 0
    answer = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert answer["verdict"] == "ambiguous"
    assert "next" not in answer
    (reason,) = [notice for notice in answer["notices"] if notice.startswith("no next flight")]
    assert "Steps of the torque" in reason
    assert reason in capsys.readouterr().out
    assert "no next flight" in (out / "report.html").read_text(encoding="utf-8")


def quadcopter(folder):
    """Write the quadcopter's scenario without its windows, as the torque of these records is exact, and rolling alone.

    Nothing turns about the other axes: their inertia had been any number, and whether held-out runs bear it was chance.
    """
    text = (SCENARIO.parent / "crazyflie.toml").read_text(encoding="utf-8").split("[diagnosis]")[0]
    text = text.replace("[platform]", '[platform]\naxes = ["x"]\n#')
    path = folder / "quadcopter.toml"
    path.write_text(text, encoding="utf-8")
    return path


def slow_roll(number, *, delay):
    """A body of 1.03e-5 kg m² that rolls at 0.5 Hz under a torque which acts `delay` s late: all but a lag."""
    time = np.arange(0.0, 4.0, 0.01)
    rng = np.random.default_rng(number)
    size, turning = 2e-6, np.pi
    rate = np.zeros((len(time), 3))
    rate[:, 0] = size / 1.03e-5 / turning * np.sin(turning * (time - delay))
    asked = np.outer(size * np.cos(turning * time), [1.0, 0.0, 0.0])
    return Record(
        time=time,
        channels={"body_rate": rate + rng.normal(0.0, 0.008, rate.shape), "applied_torque": asked},
        details=RunDetails(name=f"roll_{number}", gyro_noise=0.008),
    )
