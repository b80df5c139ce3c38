"""`testbed diagnose --resume`: an interrupted diagnosis goes on, and ends as if nothing had happened."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

import testbed.diagnosis.descent
import testbed.diagnosis.screening
import testbed.library.prepared_records
import testbed.outputs.diagnosis_parts
from support.diagnosed_records import SCENARIO, records
from support.few_effects import know_only
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.diagnosis.keeping import array_from_content, array_to_content, hash_of
from testbed.diagnosis.settings import DiagnosisSettings
from testbed.effects.gyro_latency import GyroLatency
from testbed.outputs.diagnosis_parts import PARTS
from testbed.records.writing import write_record

INTERRUPTED_AT = 5
"""Call of the refits: after the first effect was added, in the middle of the second screening."""
DELAY = 0.02


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


@pytest.fixture(scope="module", autouse=True)
def few_effects():
    """A library that is tried in seconds."""
    with pytest.MonkeyPatch.context() as patch:
        know_only(patch, "gyro_latency", "viscous_drag", "gyro_bias", "body_torque")
        yield


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Three runs whose gyro is late."""
    folder = tmp_path_factory.mktemp("late")
    for record in records(3, seconds=2.0, hooks=[GyroLatency().hooks("gyro")], values=[np.array([DELAY])]):
        write_record(record, folder / f"{record.details.name}.csv")
    return folder


def diagnose(data, out, *options):
    return run("diagnose", SCENARIO, "--data", data, "--out", out, *options)


@pytest.fixture(scope="module")
def steps():
    """Counts the trials of all searches for parameters."""
    taken = []
    with pytest.MonkeyPatch.context() as patch:
        trial = testbed.diagnosis.descent._better
        patch.setattr(testbed.diagnosis.descent, "_better", lambda *given: taken.append(0) or trial(*given))
        yield taken


@pytest.fixture(scope="module")
def whole(data, tmp_path_factory, steps):
    """The folder of a diagnosis that nothing interrupted, and the steps of its searches."""
    out = tmp_path_factory.mktemp("whole") / "out"
    assert diagnose(data, out) == 0
    return out, len(steps)


@pytest.fixture(scope="module")
def interrupted_once(data, tmp_path_factory):
    """The folder of one that was interrupted in the middle of a screening."""
    out, calls = tmp_path_factory.mktemp("interrupted") / "out", []
    with pytest.MonkeyPatch.context() as patch:
        refitted = testbed.diagnosis.screening._refitted

        def until_ctrl_c(*given):
            calls.append(0)
            if len(calls) == INTERRUPTED_AT:
                raise KeyboardInterrupt
            return refitted(*given)

        patch.setattr(testbed.diagnosis.screening, "_refitted", until_ctrl_c)
        assert diagnose(data, out) == 130
    return out


@pytest.fixture
def interrupted(interrupted_once, tmp_path):
    return shutil.copytree(interrupted_once, tmp_path / "out")


def answer(folder):
    return json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))


def test_it_ends_as_if_it_had_never_been_interrupted(data, whole, interrupted, steps, capsys):
    assert answer(interrupted)["complete"] is False
    assert (interrupted / PARTS).is_file()
    before = len(steps)
    assert diagnose(data, interrupted, "--resume") == 0
    assert "goes on with" in capsys.readouterr().out
    uninterrupted, taken = whole
    assert answer(interrupted) == answer(uninterrupted)
    assert sorted(each.name for each in interrupted.iterdir()) == sorted(each.name for each in uninterrupted.iterdir())
    extended = [folder / "extended" / "scenario.toml" for folder in (interrupted, uninterrupted)]
    assert extended[0].read_bytes() == extended[1].read_bytes()
    assert len(steps) - before < 0.6 * taken  # of the searches, only those that were not done


def test_lines_that_are_torn_or_damaged_are_worked_out_again(data, whole, interrupted, capsys):
    lines = (interrupted / PARTS).read_bytes().splitlines(keepends=True)
    lines[3] = lines[3].replace(b"0", b"1", 1)
    (interrupted / PARTS).write_bytes(b"".join(lines[:-1]) + lines[-1][:-20])
    assert diagnose(data, interrupted, "--resume") == 0
    assert "2 of its lines are damaged" in capsys.readouterr().out.replace("\n", " ")
    assert answer(interrupted) == answer(whole[0])


def test_other_data_are_refused_with_what_differs(data, interrupted, tmp_path, capsys):
    changed = shutil.copytree(data, tmp_path / "changed")
    text = (changed / "run1.csv").read_text(encoding="utf-8")
    (changed / "run1.csv").write_text(text + text.splitlines()[-1].replace("2,", "2.0625,", 1) + "\n", encoding="utf-8")
    kept = (interrupted / PARTS).read_bytes()
    assert diagnose(changed, interrupted, "--resume") == 2
    message = capsys.readouterr().err
    assert "holds another diagnosis" in message
    assert "files.run1.csv" in message
    assert "files.run2.csv" not in message
    assert (interrupted / PARTS).read_bytes() == kept


def test_another_version_is_refused(data, interrupted, monkeypatch, capsys):
    monkeypatch.setattr(testbed.outputs.diagnosis_parts, "EFFECTS", {"gyro_latency": None})
    assert diagnose(data, interrupted, "--resume") == 2
    assert "effects" in capsys.readouterr().err


def test_other_settings_are_refused_by_name(data, interrupted, whole, monkeypatch, capsys):
    assert answer(whole[0])["provenance"]["setting_null_prior_odds"] == "5.0"
    assert answer(whole[0])["provenance"]["setting_size_decades"] == "1.0"
    monkeypatch.setattr(testbed.library.prepared_records, "SETTINGS", DiagnosisSettings(size_decades=0.7))
    assert diagnose(data, interrupted, "--resume") == 2
    assert 'setting_size_decades "1.0", now "0.7"' in " ".join(capsys.readouterr().err.split())


def test_a_damaged_first_line_is_refused(data, interrupted, capsys):
    (interrupted / PARTS).write_bytes(b"no json\n" + (interrupted / PARTS).read_bytes().partition(b"\n")[2])
    assert diagnose(data, interrupted, "--resume") == 2
    assert "first line, which names the diagnosis, is damaged" in capsys.readouterr().err


def test_a_complete_diagnosis_is_not_gone_on_with(data, whole, capsys):
    assert diagnose(data, whole[0], "--resume") == 2
    assert "holds no interrupted diagnosis" in capsys.readouterr().err
    assert answer(whole[0])["complete"] is True


def test_resume_wants_a_folder(data, capsys):
    assert run("diagnose", SCENARIO, "--data", data, "--resume") == 2
    assert "name its folder with --out" in capsys.readouterr().err


def test_in_an_empty_folder_it_begins_and_says_so(data, whole, tmp_path, capsys):
    """A command that was killed before its first part left that; so does a folder that is spelt wrong."""
    assert diagnose(data, tmp_path / "new", "--resume") == 0
    assert "holds nothing of an interrupted diagnosis" in " ".join(capsys.readouterr().out.split())
    assert answer(tmp_path / "new") == answer(whole[0])


def test_numbers_are_kept_to_the_last_bit():
    values = np.array([[0.1, -0.0, 5e-324], [np.inf, 1e308, np.pi]])
    again = array_from_content(json.loads(json.dumps(array_to_content(values))))
    assert again.tobytes() == values.tobytes()
    assert hash_of(values) == hash_of(again)
    assert hash_of(values) != hash_of(values + 0.0)  # minus zero becomes zero: another bit
    assert hash_of((1, 2)) != hash_of(1, 2)
    with pytest.raises(TypeError):
        hash_of(object())


def test_ctrl_c_in_the_design_of_the_next_flight_keeps_all_that_led_there(data, whole, tmp_path, monkeypatch, capsys):
    def ctrl_c(*_):
        raise KeyboardInterrupt

    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        patch.setattr("testbed.library.diagnoses.proposal_of", ctrl_c)
        assert diagnose(data, out) == 130
    printed = " ".join("".join(capsys.readouterr()).split())
    assert "Interrupted while the next flight was designed; what was worked out is kept" in printed
    assert answer(out)["complete"]
    assert diagnose(data, out, "--resume") == 0
    assert "its design was interrupted" not in "".join(capsys.readouterr())
    assert answer(out)["steps"] == answer(whole[0])["steps"]
    assert sorted(path.name for path in out.iterdir()) == sorted(path.name for path in whole[0].iterdir())
