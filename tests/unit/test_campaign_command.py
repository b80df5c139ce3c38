"""testbed montecarlo as people use it: interrupted and resumed, with flights that fail, with unusable input."""

from __future__ import annotations

import json
import os
import shutil
import signal
from pathlib import Path

import pytest

from support.campaigns import small_scenario
from support.processes import outcome, started, until
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of

BLOCK_RUNS = 4
RUNS = 3 * BLOCK_RUNS + 2
WAITING = f"""
import pathlib, time
import testbed.campaign.plan, testbed.campaign.worker as worker
testbed.campaign.plan.COMPILED_BLOCK_RUNS = {BLOCK_RUNS}
answers = []
answer = worker.Worker.answer
def second_never_comes(self):
    if answers:
        pathlib.Path("here").touch()
        while True:
            time.sleep(0.05)
    answers.append(answer(self))
    return answers[0]
worker.Worker.answer = second_never_comes
"""


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


def parts(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "runs").iterdir()}


def figures(folder: Path) -> dict:
    content = json.loads((folder / "montecarlo.json").read_text(encoding="utf-8"))
    assert content.pop("seconds") > 0.0
    return content


@pytest.fixture(scope="module", autouse=True)
def small_blocks():
    """Interruptions need blocks, not runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("testbed.campaign.plan.COMPILED_BLOCK_RUNS", BLOCK_RUNS)
        yield


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return small_scenario(tmp_path_factory.mktemp("scenario"))


@pytest.fixture(scope="module")
def straight(path, tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign") / "straight"
    assert run("montecarlo", path, "--runs", RUNS, "--out", folder, "--workers", 2) == 0
    return folder


def test_the_folder_is_complete(path, straight):
    names = {"campaign.json", "scenario.toml", "runs", "montecarlo.json", "provenance.json", "report.html"}
    assert {entry.name for entry in straight.iterdir()} == names
    assert (straight / "scenario.toml").read_bytes() == path.read_bytes()
    content = figures(straight)
    assert content["runs"] == RUNS
    assert content["failed"] == 0
    assert content["simulated_s"] == pytest.approx(RUNS * 1.0)
    assert set(content["estimates"]) == {"ls", "output_error"}
    for name in ("bound_std_kg_m2", "true_theta_kg_m2"):
        assert len(content[name]) == 6
    assert len(content["estimates"]["output_error"]["std_kg_m2"]) == 6


def test_ctrl_c_and_resume_end_as_an_uninterrupted_campaign(path, straight, tmp_path):
    folder = tmp_path / "twice"
    arguments = ("montecarlo", path, "--runs", RUNS, "--out", folder, "--workers", 1)
    with started(*arguments, cwd=tmp_path, before=WAITING, signals_ignored=True) as process:
        until((tmp_path / "here").exists, process)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does it: the workers get it too
        code, printed, complaints = outcome(process)
    assert (code, complaints) == (130, ""), printed
    assert set(parts(folder)) == {"part-00000.parquet"}
    assert f"--out {folder} --resume" in printed
    assert not (folder / "montecarlo.json").exists()
    assert json.loads((folder / "campaign.json").read_text(encoding="utf-8"))["complete"] is False
    assert run(*arguments, "--resume") == 0
    assert parts(folder) == parts(straight)
    assert figures(folder) == figures(straight)


def test_a_campaign_that_was_interrupted_before_its_first_run_goes_on(path, straight, tmp_path, capsys):
    folder = tmp_path / "begun"
    folder.mkdir()
    for name in {"scenario.toml", "maneuver.toml"} & {entry.name for entry in straight.iterdir()}:
        shutil.copy(straight / name, folder)
    arguments = ("montecarlo", path, "--runs", RUNS, "--out", folder, "--workers", 1, "--resume")
    assert run(*arguments) == 0
    assert figures(folder) == figures(straight)
    other = tmp_path / "other"
    other.mkdir()
    (other / "scenario.toml").write_text("# of something else", encoding="utf-8")
    assert run(*arguments[:4], "--out", other, "--resume") == 2
    assert "is not the folder of a campaign" in capsys.readouterr().err


def test_more_runs_extend_a_finished_campaign_as_if_it_had_been_flown_in_one_go(path, straight, tmp_path):
    folder = tmp_path / "extended"
    assert run("montecarlo", path, "--runs", RUNS - BLOCK_RUNS, "--out", folder, "--workers", 1) == 0
    before = (folder / "report.html").read_bytes()
    assert run("montecarlo", path, "--runs", RUNS, "--out", folder, "--workers", 1, "--resume") == 0
    assert parts(folder) == parts(straight)
    assert figures(folder) == figures(straight)
    assert (folder / "report.html").read_bytes() != before
    assert not (folder / "set_aside").exists()


def test_damaged_and_foreign_parts_are_named_and_flown_again(path, straight, tmp_path, capsys):
    folder = tmp_path / "damaged"
    shutil.copytree(straight, folder)
    kept = folder / "runs" / "part-00001.parquet"
    content = bytearray(kept.read_bytes())
    content[len(content) // 2] ^= 1
    kept.write_bytes(content)
    (folder / "runs" / "part-junk.parquet").write_bytes(b"junk")
    shutil.copy(folder / "runs" / "part-00000.parquet", folder / "runs" / "part-99999.parquet")
    assert run("montecarlo", path, "--runs", RUNS, "--out", folder, "--workers", 1, "--resume") == 0
    assert parts(folder) == parts(straight)
    assert figures(folder) == figures(straight)
    aside = {"part-00001.parquet", "part-junk.parquet", "part-99999.parquet"}
    assert {entry.name for entry in (folder / "set_aside").iterdir()} == aside
    printed = capsys.readouterr()
    assert all(name in printed.err for name in aside)
    assert "Traceback" not in printed.err


@pytest.mark.parametrize("content", ["[" * 100_000, "{}", '{"complete": true, "seconds": [], "campaign": 1}', "[1]"])
def test_a_damaged_manifest_is_a_message(path, straight, tmp_path, capsys, content):
    folder = tmp_path / "damaged"
    shutil.copytree(straight, folder)
    (folder / "campaign.json").write_text(content, encoding="utf-8")
    assert run("montecarlo", path, "--runs", RUNS, "--out", folder, "--resume") == 2
    assert "campaign.json cannot be read" in capsys.readouterr().err
    assert parts(folder) == parts(straight)


def test_a_changed_scenario_is_not_resumed(straight, tmp_path, capsys):
    whole = parts(straight)
    changed = small_scenario(tmp_path, ("noise_rad_s = 0.002", "noise_rad_s = 0.003"))
    assert run("montecarlo", changed, "--runs", RUNS, "--out", straight, "--resume") == 2
    printed = capsys.readouterr().err
    assert "scenario.gyro.noise_rad_s 0.002, now 0.003" in printed
    assert "Traceback" not in printed
    assert parts(straight) == whole


def test_a_design_is_not_made_again(tmp_path, capsys):
    design = (
        'kind = "design"\nparametrization = "body_rate"\nconstraint = "hard"\ncriterion = "D"\nduration_s = 1.0\n'
        "control_points = 6\nstarts = 6\nseed = 1\nsample_rate_hz = 16.0\nprefilter_time_constant_s = 0.8\n"
        "envelope_fraction = 0.5"
    )
    path = small_scenario(tmp_path, ('kind = "basic"\nduration_s = 1.0\nscale = 1.0', design))
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path / "out", "--workers", 1) == 0
    first = figures(tmp_path / "out")
    (tmp_path / "out" / "runs" / "part-00000.parquet").unlink()
    (tmp_path / "out" / "montecarlo.json").unlink()
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path / "out", "--workers", 1, "--resume") == 0
    assert figures(tmp_path / "out") == first
    points = tmp_path / "out" / "maneuver.toml"
    points.write_text(points.read_text(encoding="utf-8").replace("= [\n  [0.0", "= [\n  [0.1"), encoding="utf-8")
    capsys.readouterr()
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path / "out", "--resume") == 2
    assert "maneuver_sha256" in capsys.readouterr().err


def test_failed_flights_do_not_stop_the_rest(tmp_path, capsys):
    # About one inertia in two of these belongs to no body.
    wild = "[dispersion]\ninertia_kg_m2 = [5e-3, 5e-3, 5e-3, 5e-3, 5e-3, 5e-3]\n"
    path = small_scenario(tmp_path, dispersion=wild)
    assert run("montecarlo", path, "--runs", 12, "--out", tmp_path / "out", "--workers", 1) == 0
    content = figures(tmp_path / "out")
    assert 0 < content["failed"] < 12
    assert len(content["failures"]) == content["failed"]
    failure = content["failures"][0]
    printed = capsys.readouterr().out
    assert f"testbed run {path} --dispersed --seed {failure['seed']}" in printed
    assert str(failure["seed"]) in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert run("run", path, "--dispersed", "--seed", failure["seed"], "--out", tmp_path / "alone") == 2
    assert failure["message"] in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "refused"),
    [
        (("--runs", 1), "--runs"),
        (("--runs", 2, "--resume"), "--out"),
        (("--runs", 2, "--workers", 0), "--workers"),
        (("--runs", 2, "--scheduler", "tcp://127.0.0.1:1", "--workers", 2), "omit one"),
    ],
)
def test_options_that_cannot_be_used(path, arguments, refused, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("montecarlo", path, *arguments) == 2
    assert refused in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_engines_that_cannot_be_compared_are_refused_before_anything_is_written(capsys, tmp_path):
    assert run("montecarlo", "zero_g_campaign", "--runs", 2, "--check", 1, "--out", tmp_path / "out") == 2
    printed = " ".join(capsys.readouterr().err.split())
    assert "a check (--check) flies runs in MuJoCo and by the compiled equations" in printed
    assert "leave the check out" in printed
    assert list(tmp_path.iterdir()) == []


def test_resuming_what_is_no_campaign(path, tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path, "--resume") == 2
    assert "is not the folder of a campaign" in capsys.readouterr().err
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path / "nowhere", "--resume") == 2
    assert not (tmp_path / "nowhere").exists()
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path) == 2
    assert [entry.name for entry in tmp_path.iterdir()] == ["notes.txt"]


def test_a_campaign_without_one_completed_flight_has_no_table(tmp_path, capsys):
    torque = '\n[[truth.torque]]\nformula = "w_z"\naxis = "z"\ncoefficient = 1e5\n'
    path = small_scenario(tmp_path)
    path.write_text(path.read_text(encoding="utf-8") + torque, encoding="utf-8")
    assert run("montecarlo", path, "--runs", 2, "--workers", 1, "--out", tmp_path / "out") == 0
    printed = capsys.readouterr().out
    assert "0 of 2 completed" in printed
    assert "nan" not in printed


def test_why_no_estimator_gave_an_estimate_is_said(tmp_path, capsys):
    path, out = small_scenario(tmp_path), tmp_path / "out"
    noisy = ("--set", "gyro.noise_rad_s=1000", "--out", out)
    assert run("montecarlo", path, "--runs", 2, "--workers", 1, *noisy) == 0
    unestimated = figures(out)["unestimated"]
    assert unestimated
    assert all(each["runs"] == 2 and "drowns" in each["message"] for each in unestimated)
    assert "of 2 of 2 runs: " in " ".join("".join(capsys.readouterr()).split())
    assert "Runs without an estimate" in (out / "report.html").read_text(encoding="utf-8")
