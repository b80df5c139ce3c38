"""The library as a program uses it: the examples of its documentation, its objects, and what it loads."""

from __future__ import annotations

import doctest
import json
import subprocess
import sys
from dataclasses import replace
from importlib import import_module

import numpy as np
import pandas as pd
import pytest

import testbed as tb
from support.processes import ROOT
from testbed.dynamics.inertia import PARAMETER_NAMES

MODULES = ("campaigns", "comparisons", "diagnoses", "estimates", "imports", "plans", "records", "runs", "scenarios")


@pytest.fixture(scope="module")
def scenario():
    return tb.read_scenario("basic", {"gyro.noise_rad_s": 1e-3})


@pytest.fixture(scope="module")
def runs(scenario):
    return [tb.fly(scenario, seed=seed) for seed in (1, 2)]


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_the_documentation_run(name):
    tried = doctest.testmod(import_module(f"testbed.library.{name}"), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert tried.attempted > 0
    assert tried.failed == 0


def test_every_name_is_there_and_documented():
    for name in tb.__all__:
        assert getattr(tb, name).__doc__, name
    with pytest.raises(AttributeError, match="nothing_such"):
        tb.nothing_such  # noqa: B018


def test_importing_it_loads_no_engine():
    code = (
        "import sys, testbed\n"
        "assert testbed.__version__\n"
        "loaded = {'numpy', 'scipy', 'mujoco', 'casadi', 'rerun', 'pydantic', 'pandas'} & set(sys.modules)\n"
        "assert not loaded, loaded\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


def test_an_override_is_flown_and_stored(scenario, runs, tmp_path):
    assert scenario.gyro.noise_rad_s == 1e-3
    folder = runs[0].save(tmp_path / "run")
    stored = tb.read_scenario(folder / "scenario.toml")
    assert stored == scenario
    assert json.loads((folder / "result.json").read_text())["seed"] == 1


def test_a_scenario_that_was_changed_in_python_is_stored_as_it_was_flown(scenario, tmp_path):
    changed = scenario.model_copy(update={"seed": 7})
    folder = tb.fly(changed).save(tmp_path / "run")
    assert tb.read_scenario(folder / "scenario.toml").seed == 7


def test_an_override_that_no_key_has_is_refused():
    with pytest.raises(tb.InputError, match=r"gyro\.noise: unknown key; did you mean noise_rad_s"):
        tb.read_scenario("basic", {"gyro.noise": 1.0})
    with pytest.raises(tb.InputError, match="seed is no table"):
        tb.read_scenario("basic", {"seed.of": 1})
    with pytest.raises(tb.InputError, match="nor a shipped scenario of that name; these are adopted"):
        tb.read_scenario("no_such")


def test_a_run_and_its_numbers(runs):
    run = runs[0]
    frame = run.to_pandas()
    assert list(frame.index) == list(PARAMETER_NAMES)
    np.testing.assert_array_equal(frame["output_error"], run.estimates["output_error"].theta)
    np.testing.assert_array_equal(frame["true"], run.truth)
    assert (frame["bound_std"] == run.bound).all()
    assert repr(run).startswith("Run of basic, seed 1. ")
    assert repr(run.record).startswith("basic: 401 rows over 5 s, body_rate, gimbal_angle")
    assert repr(run.estimates["output_error"]).startswith("Estimate: J11 = ")
    assert repr(run.scenario).startswith("Scenario basic: ")
    assert "<iframe" in run._repr_html_()


def test_what_a_notebook_stores_of_an_object_is_small(runs):
    shown = runs[0]._repr_html_()
    assert "Residuals" in shown
    assert "Its charts are in report.html" in shown
    assert len(shown) < 50_000


def test_a_viewer_without_its_package_says_what_to_install(runs, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun_notebook", None)
    with pytest.raises(tb.InputError, match=r"pip install 'testbed\[notebook\]'"):
        runs[0].viewer()


def test_runs_of_one_name_are_saved_in_a_file_each(runs, tmp_path):
    first, second = (run.record for run in runs[:2])
    other = replace(first, details=replace(first.details, name=f"{first.details.name}-2"))
    saved = tb.Records((first, other, second, first)).save(tmp_path / "data")
    assert {path.stem for path in saved.glob("*.parquet")} == {"basic", "basic-2", "basic-3", "basic-4"}
    assert (tb.read_records(saved)["basic-3"].time == second.time).all()


def test_an_estimate_uses_every_flight_of_one_name(runs):
    records = tb.Records(tuple(run.record for run in runs[:2]))
    assert [record.details.name for record in records] == ["basic", "basic-2"]
    estimate = tb.estimate(runs[0].scenario, records)
    assert list(estimate.by_record) == ["basic", "basic-2"]


def test_a_maneuver_of_another_platform_is_refused_with_what_it_moves():
    planned = tb.design(tb.read_scenario("gimbal_d_optimal", {"maneuver.starts": 1}))
    with pytest.raises(tb.InputError, match="moves 6 gimbals, the platform has 4: design it for this scenario"):
        tb.fly(tb.read_scenario("pyramid4"), planned)
    with pytest.raises(tb.InputError, match="moves 6 gimbals"):
        tb.monte_carlo(tb.read_scenario("pyramid4"), planned, runs=2)


def test_a_maneuver_that_tilts_a_bearing_too_far_is_refused_by_whoever_flies_it():
    rates = [[0.0, 0.0, 0.0], *([[0.05, 0.0, 0.0]] * 6), [0.0, 0.0, 0.0], *([[-0.05, 0.0, 0.0]] * 6), [0.0, 0.0, 0.0]]
    wide = tb.read_scenario("air_bearing", {"environment.tilt_limit_rad": 1.2, "maneuver.body_rate_rad_s": rates})
    planned = tb.design(wide)
    with pytest.raises(tb.InputError, match="the maneuver tilts the platform by"):
        tb.fly(tb.read_scenario("air_bearing"), planned)


def test_one_file_cannot_be_mjcf_and_urdf(runs, tmp_path):
    folder = runs[0].save(tmp_path / "run")
    with pytest.raises(tb.InputError, match="is asked for as MJCF and as URDF"):
        tb.export(folder, mjcf=tmp_path / "a.xml", urdf=tmp_path / "a.xml")
    assert not (tmp_path / "a.xml").exists()


@pytest.mark.parametrize("sent", [0, 5, None])
def test_an_attitude_of_zeros_is_none(sent):
    """Filters send zeros before they converge; None: they never do."""
    scenario = tb.read_scenario("air_bearing")
    run = tb.fly(scenario, seed=1)
    record, own = run.record, run.estimates["output_error"]
    attitude = record.channels["true_attitude"].copy()
    attitude[:sent] = 0.0
    given = tb.Records((replace(record, channels={**record.channels, "attitude": attitude}),))
    estimate = tb.estimate(scenario, given).combined["output_error"]
    assert (np.abs(estimate.theta - own.theta) < 3.0 * np.sqrt(np.diag(own.covariance))).all()


@pytest.mark.parametrize("name", ["frame without time", "list", "columns without a name", "nothing"])
def test_what_is_no_table_is_refused_with_what_to_give(runs, name):
    frame = tb.frame_of(runs[0].record)
    given, words = {
        "frame without time": (frame.drop(columns="time_s"), "time_s"),
        "list": ([frame], "such as {'flight 1': table}"),
        "columns without a name": ({"body_rate_x_rad_s": frame["body_rate_x_rad_s"]}, "such as {'flight 1': table}"),
        "nothing": ({}, "there is no run"),
    }[name]
    with pytest.raises(tb.InputError, match=words):
        tb.records_from(given)


def test_a_frame_is_no_records(scenario, runs):
    for use in (tb.estimate, tb.diagnose):
        with pytest.raises(tb.InputError, match="records_from"):
            use(scenario, tb.frame_of(runs[0].record))


def test_a_frame_becomes_records_and_an_estimate(scenario, runs):
    frame = tb.frame_of(runs[0].record)
    assert isinstance(frame, pd.DataFrame)
    measured = frame[[column for column in frame if not column.startswith("true_")]]
    records = tb.records_from({"a": measured, "b": tb.frame_of(runs[1].record)}, gyro_noise_rad_s=1e-3)
    estimate = tb.estimate(scenario, records)
    error = estimate.combined["output_error"].theta - runs[0].truth
    assert np.abs(error / estimate.combined["output_error"].std).max() < 4.5
    posterior = estimate.to_arviz(draws=2000, seed=1)
    drawn = posterior.posterior["output_error"]
    assert list(drawn.coords["parameter"].values) == list(PARAMETER_NAMES)
    assert drawn.std(("chain", "draw")).values == pytest.approx(estimate.combined["output_error"].std, rel=0.1)


def test_what_is_no_record_is_refused_with_the_place():
    with pytest.raises(tb.InputError, match="no channel says what turned the platform"):
        tb.records_from({"time_s": np.arange(20.0), **{f"body_rate_{axis}_rad_s": np.zeros(20) for axis in "xyz"}})
    with pytest.raises(tb.InputError, match="differ in length"):
        tb.records_from(
            {
                "time_s": np.arange(20.0),
                **{f"body_rate_{axis}_rad_s": np.zeros(20) for axis in "xyz"},
                **{f"applied_torque_{axis}_N_m": np.zeros(19) for axis in "xyz"},
            }
        )


def test_a_campaign_in_memory_is_the_one_in_a_folder(scenario, tmp_path):
    one = tb.monte_carlo(scenario, runs=3, seed=5, workers=1)
    other = tb.monte_carlo(scenario, runs=3, seed=5, workers=1, folder=tmp_path / "campaign")
    assert one.table.equals(other.table)
    assert list(one.to_xarray().run.values) == [0, 1, 2]
    assert (tmp_path / "campaign" / "report.html").is_file()
    assert one.result["estimates"] == json.loads((tmp_path / "campaign" / "montecarlo.json").read_text())["estimates"]


def test_runs_are_compared_and_campaigns_apart(scenario, runs, tmp_path):
    folders = [run.save(tmp_path / f"run{run.experiment.seed}") for run in runs]
    comparison = tb.compare(folders)
    frame = comparison.to_pandas()
    assert frame.loc[("output_error", "estimate", "run2"), "J11"] == runs[1].estimates["output_error"].theta[0]
    assert (comparison.save(tmp_path / "comparison") / "report.html").is_file()
    campaign = tmp_path / "campaign"
    tb.monte_carlo(scenario, runs=2, workers=1, folder=campaign)
    with pytest.raises(tb.InputError, match="runs and campaigns cannot be compared"):
        tb.compare([folders[0], campaign])
    with pytest.raises(tb.InputError, match=r"holds neither result\.json nor montecarlo\.json"):
        tb.compare([folders[0], tmp_path])
