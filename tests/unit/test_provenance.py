"""What is stored is what was read at the start; every output names its inputs, command, seed and versions."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import pytest

from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.outputs.provenance import provenance
from testbed.scenario.reader import scenario_file, scenario_of

ROOT = Path(__file__).resolve().parents[2]
BASIC = ROOT / "scenarios" / "basic.toml"


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(BASIC, tmp_path / "mine.toml")
    return tmp_path


@pytest.fixture
def during_the_flight(monkeypatch):
    """Give a function that has something done between the reading of the scenario and the writing of the folder."""
    from testbed.cli import run as command

    flown = command.fly

    def do(action) -> None:
        def fly(*arguments, **keywords):
            action()
            return flown(*arguments, **keywords)

        monkeypatch.setattr(command, "fly", fly)

    return do


def test_a_scenario_that_is_edited_during_a_run_is_stored_as_it_was_flown(here, during_the_flight):
    before = (here / "mine.toml").read_bytes()
    during_the_flight(lambda: (here / "mine.toml").write_text("# edited"))
    assert run("run", "mine.toml", "--out", "out") == 0
    assert (here / "out" / "scenario.toml").read_bytes() == before
    origin = json.loads((here / "out" / "provenance.json").read_text())
    assert origin["scenario_sha256"] == hashlib.sha256(before).hexdigest()
    (scenario,) = origin["inputs"]
    assert scenario == {"path": "mine.toml", "sha256": origin["scenario_sha256"], "size": len(before)}


def test_a_scenario_that_is_deleted_during_a_run_costs_nothing(here, during_the_flight):
    during_the_flight((here / "mine.toml").unlink)
    assert run("run", "mine.toml", "--out", "out") == 0
    assert (here / "out" / "scenario.toml").read_bytes() == BASIC.read_bytes()


def test_estimates_have_a_folder_without_out_and_name_their_records(here, capsys):
    assert run("run", "mine.toml", "--out", "flown") == 0
    assert run("estimate", "mine.toml", "--data", "flown") == 0
    assert "runs/basic-estimate" in capsys.readouterr().out
    folder = here / "runs" / "basic-estimate"
    records = ["flown/record.parquet", "flown/record.toml"]
    for name in ("provenance.json", "estimates.json"):
        content = json.loads((folder / name).read_text())
        content = content.get("provenance", content)
        assert [each["path"] for each in content["inputs"]] == ["mine.toml", *records]
        assert [each["sha256"] for each in content["inputs"]] == [
            sha256(here / each["path"]) for each in content["inputs"]
        ]
        assert {"version_testbed", "version_python"} <= content.keys()


def test_provenance_names_every_file_that_a_scenario_names(tmp_path):
    shutil.copy(ROOT / "models" / "platform.xml", tmp_path / "mine.xml")
    shutil.copy(ROOT / "models" / "cmg.xml", tmp_path / "cmg.xml")
    text = BASIC.read_text(encoding="utf-8").replace("[platform]", '[platform]\nmodel = "mine.xml"\n#', 1)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    file = scenario_file(tmp_path / "mine.toml")
    origin = provenance(scenario_of(file), file, "testbed run mine.toml --seed 3", deciding={"seed": "3"})
    assert [stamp.sha256 for stamp in origin.inputs] == [sha256(tmp_path / "mine.toml"), sha256(tmp_path / "mine.xml")]
    assert origin.content["command"] == "testbed run mine.toml --seed 3"
    assert origin.content["seed"] == origin.reproducible["seed"] == "3"
    assert "command" not in origin.reproducible


def test_a_recording_has_another_name_where_anything_that_decides_it_differs():
    file = scenario_file(BASIC)
    scenario = scenario_of(file)
    first = provenance(scenario, file, "testbed run a", deciding={"seed": "1"})
    assert provenance(scenario, file, "testbed run b", deciding={"seed": "1"}).recording_id == first.recording_id
    assert provenance(scenario, file, "testbed run a", deciding={"seed": "2"}).recording_id != first.recording_id
    other = provenance(scenario, file, "testbed run a", deciding={"seed": "1"}, data=[file.stamp])
    assert other.recording_id != first.recording_id
