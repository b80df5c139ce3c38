"""How blind sets of craft with wheels are driven: stages, what is kept and scored so far, and the page."""

from __future__ import annotations

import json
import sys

import pytest

from benchmarks import blind_wheels, platform_sets
from benchmarks.blind_diagnosis import DIAGNOSIS, REFUSED, SECONDS
from concealing.sealing import SEAL, sealed_text, write_sealed

HIDDEN_IN = {"case_0001": None, "case_0002": 4.0, "case_0003": None}


def called(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["blind_wheels", *map(str, arguments)])
    platform_sets.main(blind_wheels.SETS)


@pytest.fixture
def out(tmp_path):
    """A set of three: none and nothing named, one and refused, and one that is not diagnosed yet."""
    folder = tmp_path / "cubesat_wheels"
    for name, times in HIDDEN_IN.items():
        content = {
            "notes": {} if times is None else {"detectable_sizes": times},
            "true_theta_kg_m2": [0.03, 0.03, 0.007, 0.0, 0.0, 0.0],
            "initial_rates_rad_s": [[0.0, 0.0, 0.0]],
        }
        answer = sealed_text(1, "null" if times is None else "single", (), {}, content)
        write_sealed(answer, (), folder / "data" / name, folder / "answers" / name)
        (folder / "answers" / name / SECONDS).write_text("2.0\n", encoding="utf-8")
    said = {"complete": True, "verdict": "none", "steps": []}
    for name, file, text in (("case_0001", DIAGNOSIS, json.dumps(said)), ("case_0002", REFUSED, "no")):
        (folder / "diagnoses" / name).mkdir(parents=True)
        (folder / "diagnoses" / name / file).write_text(text, encoding="utf-8")
        (folder / "diagnoses" / name / SECONDS).write_text("90.0\n", encoding="utf-8")
    return tmp_path


def test_the_card_is_of_what_was_diagnosed_so_far(out, monkeypatch, capsys):
    called(monkeypatch, "card", "--out", out, "--cases", 3, "--seed", 5, "--words", "A pilot.")
    contents = json.loads((out / "blind-wheels.json").read_text(encoding="utf-8"))
    assert list(contents) == ["both", "cubesat_wheels"]  # nothing of the other platform yet
    assert contents["both"]["cases"] == contents["both"]["sealed"] == 2
    assert contents["both"]["making"]["diagnosis_seconds"] == [90.0, 90.0]
    text = (out / "blind-wheels.md").read_text(encoding="utf-8")
    assert "A pilot." in text
    assert "make|run|card --cases 3 --seed 5" in text
    assert "| a name is given | 0.0% | 1 |" in text
    assert "case_0002" in capsys.readouterr().out  # why it counts as a miss


def test_running_diagnoses_what_is_not_diagnosed_yet_and_locks_the_answers(out, monkeypatch):
    seen = []

    def diagnose_all(scenario, data, diagnoses, count, jobs):
        locked = (out / "cubesat_wheels" / "answers").stat().st_mode & 0o777
        seen.append((scenario.name, data.parent.name, diagnoses.name, count, jobs, locked))

    monkeypatch.setattr(platform_sets, "diagnose_all", diagnose_all)
    called(monkeypatch, "run", "--out", out, "--platforms", "cubesat_wheels", "--cases", 9, "--first", 3, "--jobs", 1)
    assert seen == [("cubesat_wheels.toml", "cubesat_wheels", "diagnoses", 3, 1, 0)]
    assert (out / "cubesat_wheels" / "answers").stat().st_mode & 0o777 == 0o700


def test_what_was_made_is_kept(out, monkeypatch):
    before = {path: path.read_bytes() for path in (out / "cubesat_wheels").rglob("*") if path.is_file()}
    assert (out / "cubesat_wheels" / "data" / "case_0001" / SEAL) in before
    called(monkeypatch, "make", "--out", out, "--platforms", "cubesat_wheels", "--cases", 3, "--seed", 5, "--jobs", 1)
    assert {path: path.read_bytes() for path in before} == before


def test_before_the_first_diagnosis_the_page_says_what_will_be_measured(tmp_path, monkeypatch):
    called(monkeypatch, "card", "--out", tmp_path, "--words", "Nothing is scored yet.")
    assert "Nothing is scored yet." in (tmp_path / "blind-wheels.md").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "blind-wheels.json").read_text(encoding="utf-8")) == {}
