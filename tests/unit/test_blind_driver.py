"""How the blind set is driven: shares of strata, what is kept, what stays locked."""

from __future__ import annotations

import subprocess
from dataclasses import asdict

import numpy as np
import pytest

from benchmarks.blind import ALL, counts_of, locked, timed_make
from benchmarks.blind_diagnosis import CRASHED, REFUSED, SECONDS, diagnose_case
from benchmarks.blind_sindy import SCRIPT, write_terms
from benchmarks.environments import BUILD
from concealing.blind_set import Counts
from concealing.order import Order
from concealing.sealing import SEAL
from support.diagnosed_records import SCENARIO, records
from testbed.records.writing import write_record


@pytest.mark.parametrize("cases", [1, 12, 24, 80])
def test_a_part_has_every_stratum_in_its_share(cases):
    part, whole = asdict(counts_of(cases)), asdict(Counts())
    assert sum(part.values()) == cases
    assert all(abs(part[name] - count * cases / ALL) < 1.0 for name, count in whole.items())


def test_the_whole_is_what_was_ordered():
    assert counts_of(ALL) == Counts()


def test_a_refusal_is_kept_as_an_answer_and_not_tried_again(tmp_path):
    empty = tmp_path / "data"
    empty.mkdir()
    folder = diagnose_case(SCENARIO, empty, tmp_path / "diagnosis")
    assert str(empty) in (folder / REFUSED).read_text(encoding="utf-8")
    (folder / REFUSED).write_text("kept", encoding="utf-8")
    diagnose_case(SCENARIO, empty, folder)
    assert (folder / REFUSED).read_text(encoding="utf-8") == "kept"


def test_answers_are_locked_while_cases_are_diagnosed(tmp_path):
    answers = tmp_path / "answers"
    with locked(answers, 0o000):
        assert answers.stat().st_mode & 0o777 == 0
    assert answers.stat().st_mode & 0o777 == 0o700  # and given back to be scored


def test_a_case_whose_making_was_cut_short_is_made_again_the_same_and_a_whole_one_is_kept(tmp_path):
    order = Order(index=30, stratum="sigma_overstated", effect=None, multiple=None)
    data, answers = tmp_path / "data", tmp_path / "answers"
    timed_make(order, 7, data, answers)
    made = {path: path.read_bytes() for path in (data / "case_0031").iterdir()}
    assert float((answers / "case_0031" / SECONDS).read_text(encoding="utf-8")) > 0.0
    (data / "case_0031" / SEAL).unlink()
    (data / "case_0031" / "run_2.csv").write_text("cut", encoding="utf-8")
    timed_make(order, 7, data, answers)
    assert {path: path.read_bytes() for path in (data / "case_0031").iterdir()} == made
    (answers / "case_0031" / SECONDS).write_text("1.5", encoding="utf-8")
    timed_make(order, 7, data, answers)
    assert (answers / "case_0031" / SECONDS).read_text(encoding="utf-8") == "1.5"


def test_a_crash_is_tried_again(tmp_path):
    (tmp_path / "data").mkdir()
    folder = tmp_path / "diagnosis"
    folder.mkdir()
    (folder / CRASHED).write_text("as before", encoding="utf-8")
    diagnose_case(SCENARIO, tmp_path / "data", folder)
    assert (folder / REFUSED).exists()  # an empty folder is refused


@pytest.fixture(scope="module")
def terms(tmp_path_factory):
    """What SINDy is given of three runs without an effect."""
    folder = tmp_path_factory.mktemp("terms")
    for index, record in enumerate(records(3, seconds=2.0)):
        write_record(record, folder / "data" / f"run_{index + 1}.csv")
    write_terms(folder / "data", folder / "case_0001.npz")
    return folder


def test_sindy_is_given_the_fit_runs_in_rad_s(terms):
    with np.load(terms / "case_0001.npz") as case:
        runs = [case[f"residual_{index}"] for index in range(2)]
        assert "residual_2" not in case.files  # held out
        assert {run.shape for run in runs} == {(33, 3)}
        assert np.std(np.concatenate(runs)) == pytest.approx(0.001658, rel=0.2)
        assert case["columns_0"].shape == (33, 3, len(case["terms"]))
        assert {"viscous_drag:platform", "rotor_speed:cmg1", "gyro_latency:gyro"} <= set(case["terms"].tolist())


@pytest.mark.skipif(not (BUILD / "sindy-venv" / ".requirement").exists(), reason="SINDy's environment was not made")
def test_sindy_names_the_torque_that_is_there(terms, tmp_path):
    with np.load(terms / "case_0001.npz") as case:
        arrays = dict(case)
    drag = arrays["terms"] == "viscous_drag:platform"
    for index in range(2):
        arrays[f"residual_{index}"] = arrays[f"columns_{index}"][..., drag] @ [4e-4, 1e-4, 0.0]
    np.savez(tmp_path / "case_0002.npz", **arrays)
    python = BUILD / "sindy-venv" / "bin" / "python"
    done = subprocess.run([str(python), str(SCRIPT), str(tmp_path)], check=True, capture_output=True, text=True)
    assert done.stdout.split() == ["case_0002", "viscous_drag:platform"]
