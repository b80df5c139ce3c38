"""`testbed adopt` and `testbed export`: a model of one's own comes in, the estimated platform goes out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import testbed as tb
import testbed.cli.adopt
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.dynamics.inertia import inertia_of
from testbed.plant.geometry import composite_inertia

ROOT = Path(__file__).resolve().parents[2]
MODEL = ROOT / "models" / "smallsat.xml"


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


def test_a_model_becomes_a_scenario_that_passes_the_check(here, capsys):
    assert run("adopt", MODEL) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "mu_keel wheel turns about an axis of symmetry, and has a motor" in printed
    assert "panel_drive locked turns what has its centre of mass 0.12 m off the axis" in printed
    assert "Otherwise: --wheel NAME, --rotor NAME (of a gyro), --ignore NAME (locked as drawn)" in printed
    assert "Moved by the same torques for 10 s, its body rate is within" in printed
    assert run("check", "smallsat.toml") == 0
    assert [path.name for path in here.iterdir()] == ["smallsat.toml"]


@pytest.mark.usefixtures("here")
def test_what_was_taken_wrongly_is_corrected(capsys):
    assert run("adopt", MODEL, "--out", "mine.toml", "--wheel", "shutter", "--ignore", "panel_drive") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "shutter_hinge wheel as wheel says" in printed
    assert "panel_drive locked as ignore says" in printed
    assert "shutter_hinge: its centre of mass is 0.03 m off its axis; it is flown as balanced" in printed
    assert "differs: from the model by more than rounding: see what is not flown, or ignore a joint" in printed
    assert tb.read_scenario("mine.toml").name == "mine"


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(("difference", "said"), [(1e-6, True), (1e-13, False)])
def test_where_nothing_is_left_out_the_files_digits_differ(capsys, monkeypatch, difference, said):
    """Somebody's table with axes of six digits was said to differ by what is not flown, and nothing was listed."""
    whole = replace(tb.adopt(Path(MODEL)), notes=(), difference=difference)
    monkeypatch.setattr(testbed.cli.adopt, "adopt", lambda *_, **__: whole)
    assert run("adopt", MODEL) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert ("as nothing is left out, by the few digits that its file gives of axes and inertias" in printed) is said


@pytest.mark.usefixtures("here")
def test_a_scenario_takes_the_name_that_its_file_allows():
    assert run("adopt", MODEL, "--out", "my.sat 2.toml") == 0
    assert tb.read_scenario("my.sat 2.toml").name == "my_sat_2"


def test_nothing_is_replaced_and_nothing_is_left_behind(here, capsys):
    (here / "smallsat.toml").write_text("mine", encoding="utf-8")
    assert run("adopt", MODEL) == 2
    assert "smallsat.toml: exists; choose another file with --out" in " ".join(capsys.readouterr().err.split())
    assert (here / "smallsat.toml").read_text(encoding="utf-8") == "mine"
    assert run("adopt", MODEL, "--out", "other.toml", "--ignore", "mu_bow") == 2
    assert "give no torque about [1, 0, 0] in body axes" in " ".join(capsys.readouterr().err.split())
    assert [path.name for path in here.iterdir()] == ["smallsat.toml"]


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    place, scenario = tmp_path_factory.mktemp("folders"), tb.read_scenario("basic")
    flown = tb.fly(scenario, seed=1)
    estimate = tb.estimate(scenario, tb.Records((flown.record,)))
    return {"result.json": flown.save(place / "run"), "estimates.json": estimate.save(place / "estimate")}


def theta(folder, name, estimator):
    found = json.loads((folder / name).read_text(encoding="utf-8"))
    return found["estimates" if name == "result.json" else "combined"][estimator]["theta_kg_m2"]


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("name", ["result.json", "estimates.json"])
def test_the_estimated_platform_is_exported_for_mujoco(folders, name):
    folder = folders[name]
    assert run("export", folder, "--mjcf", "out.xml", "--urdf", "out.urdf", "--quiet") == 0
    for path in ("out.xml", "out.urdf"):
        model = mujoco.MjModel.from_xml_path(path)
        expected = inertia_of(np.array(theta(folder, name, "output_error")))
        np.testing.assert_allclose(composite_inertia(model), expected, atol=1e-9)


@pytest.mark.usefixtures("here")
def test_another_estimate_is_exported_by_name(folders, capsys):
    folder = folders["result.json"]
    assert run("export", folder, "--urdf", "out.urdf", "--estimator", "iv") == 0
    expected = inertia_of(np.array(theta(folder, "result.json", "iv")))
    np.testing.assert_allclose(composite_inertia(mujoco.MjModel.from_xml_path("out.urdf")), expected, atol=1e-9)
    assert run("export", folder, "--urdf", "b.urdf", "--estimator", "kalman") == 2
    assert "has no estimate by kalman; there are ls, iv" in " ".join(capsys.readouterr().err.split())


def test_a_diagnosis_exports_the_inertia_that_was_estimated_with_its_effects(folders, here):
    """Its own file, as docs/reference/formats/diagnosis.md has it; a diagnosis takes longer."""
    known = inertia_of(np.array(theta(folders["result.json"], "result.json", "output_error")))
    (here / "found").mkdir()
    found = {"inertia": {"after": {"theta_kg_m2": theta(folders["result.json"], "result.json", "output_error")}}}
    (here / "found" / "diagnosis.json").write_text(json.dumps(found), encoding="utf-8")
    (here / "found" / "scenario.toml").write_bytes((folders["result.json"] / "scenario.toml").read_bytes())
    assert run("export", "found", "--mjcf", "out.xml") == 0
    np.testing.assert_allclose(composite_inertia(mujoco.MjModel.from_xml_path("out.xml")), known, atol=1e-9)


def test_what_cannot_be_exported_is_refused_with_what_to_give(folders, here, capsys):
    def refused(*arguments: object) -> str:
        assert run("export", *arguments) == 2
        return " ".join(capsys.readouterr().err.split())

    folder = folders["result.json"]
    assert "nothing to export: give a file for MJCF, for URDF, or for both" in refused(folder)
    assert "name the folder of a run, estimate or diagnosis" in refused(here, "--mjcf", "out.xml")
    (here / "there.xml").write_text("mine", encoding="utf-8")
    assert "--mjcf there.xml: exists; choose another file" in refused(folder, "--mjcf", "there.xml")
    (here / "broken").mkdir()
    (here / "broken" / "result.json").write_text("{}", encoding="utf-8")
    assert "is not as testbed wrote it" in refused("broken", "--mjcf", "out.xml")
    assert not (here / "out.xml").exists()
