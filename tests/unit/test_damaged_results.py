"""Results of runs that were changed on the way: what is read of them is checked before anything is made of it."""

from __future__ import annotations

import json
import shutil

import pytest

import testbed as tb

STD = ("estimates", "ls", "std_kg_m2")
THETA = ("estimates", "output_error", "theta_kg_m2")
DAMAGES = {
    "not a number": (THETA, [float("nan")] * 6, r"estimates\.output_error\.theta_kg_m2\.0: input should be a finite"),
    "one number less": (THETA, [0.02] * 5, r"estimates\.output_error\.theta_kg_m2: list should have at least 6 items"),
    "text": (THETA, ["0.02"] * 6, r"estimates\.output_error\.theta_kg_m2\.0: input should be a valid number"),
    "no truth": (("truth",), None, r"truth: input should be a valid dictionary"),
    "no estimate": (("estimates", "ls"), None, r"estimates\.ls: input should be a valid dictionary"),
    "a key less": (STD, ..., "std_kg_m2 is missing"),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tb.fly(tb.read_scenario("basic"), seed=1).save(tmp_path_factory.mktemp("results") / "run")


def damaged(folder, place, keys, value):
    """Return a copy of a run's folder with another value in its result, or without the key."""
    copy = shutil.copytree(folder, place / "damaged")
    content = json.loads((copy / "result.json").read_text(encoding="utf-8"))
    part = content
    for key in keys[:-1]:
        part = part[key]
    if value is ...:
        del part[keys[-1]]
    else:
        part[keys[-1]] = value
    (copy / "result.json").write_text(json.dumps(content), encoding="utf-8")
    return copy


@pytest.mark.parametrize("name", DAMAGES)
def test_no_damaged_result_is_compared(folder, tmp_path, name):
    keys, value, words = DAMAGES[name]
    with pytest.raises(tb.InputError, match=rf"result\.json: is not as testbed wrote it \({words}"):
        tb.compare([folder, damaged(folder, tmp_path, keys, value)])


def test_results_of_other_versions_are_compared(folder, tmp_path):
    """With a key more, and without one that is not compared."""
    other = damaged(folder, tmp_path, ("tracking",), ...)
    path = other / "result.json"
    path.write_text(json.dumps(json.loads(path.read_text(encoding="utf-8")) | {"weather": "fair"}), encoding="utf-8")
    assert "2 runs compared" in str(tb.compare([folder, other]))


@pytest.mark.parametrize("values", [[float("nan")] * 6, [0.02] * 5, [[0.02]] * 6])
def test_no_inertia_but_six_numbers_is_exported(folder, tmp_path, values):
    with pytest.raises(tb.InputError, match="are no 6 numbers"):
        tb.export(damaged(folder, tmp_path, THETA, values), mjcf=tmp_path / "platform.xml")
    assert not (tmp_path / "platform.xml").exists()


def test_a_folder_that_is_not_there_is_said_to_be_missing(folder, tmp_path):
    missing = tmp_path / "missing"
    with pytest.raises(tb.InputError, match="missing: there is no such folder"):
        tb.compare([folder, missing])
    with pytest.raises(tb.InputError, match="missing: there is no such folder"):
        tb.export(missing, mjcf=tmp_path / "platform.xml")
    with pytest.raises(tb.InputError, match=r"result\.json: is no folder"):
        tb.compare([folder, folder / "result.json"])
