"""What no memory holds, or what would never end, is refused with the number, before any work."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
import tomli_w

from support.campaigns import plan_of, small_scenario
from support.processes import ROOT
from testbed.campaign.rows import _side_by_side
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.maneuver.criteria import information_matrix
from testbed.maneuver.information import filtered_regressor, sampled_filter
from testbed.maneuver.profiles import read_profile


def scenario(name: str) -> dict[str, Any]:
    return tomllib.loads((ROOT / "scenarios" / f"{name}.toml").read_text(encoding="utf-8"))


def refusal(tree, tmp_path, capsys, command="check", *options):
    path = tmp_path / "scenario.toml"
    path.write_text(tomli_w.dumps(tree), encoding="utf-8")
    assert exit_code_of(lambda: app([command, str(path), *options])) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "criterion", "rate", "said"),
    [
        ("orbit", "D", 1e5, "100000.0 Hz over 60.0 s are 6,000,000 samples, for which the optimiser takes 102 GB"),
        ("orbit", "E", 1e3, "60,000 samples, for which the optimiser takes 9 GB; 2 GB are allowed, 13,333 samples"),
        ("gimbal_weighted", "condition", 1e3, "use "),
        ("paper_d_optimal", "D", 1e4, "use "),
    ],
)
def test_a_design_that_fills_the_memory_is_refused(tmp_path, capsys, name, criterion, rate, said):
    tree = scenario(name)
    tree["maneuver"] |= {"sample_rate_hz": rate, "criterion": criterion}
    message = refusal(tree, tmp_path, capsys)
    assert "maneuver.sample_rate_hz" in message
    assert said in message


def test_a_minute_at_a_kilohertz_is_designed_for(tmp_path):
    """The matrices of its prefilter took 53.6 GiB; 60,000 samples take 0.55 GB now."""
    tree = scenario("orbit")
    tree["maneuver"]["sample_rate_hz"] = 1000.0
    path = tmp_path / "scenario.toml"
    path.write_text(tomli_w.dumps(tree), encoding="utf-8")
    assert exit_code_of(lambda: app(["check", str(path)])) == 0
    sampling = sampled_filter(60.0, 1000.0, 2.0)
    motion = np.sin(sampling.fine_time)[:, None] * [1.0, 2.0, 3.0]
    assert filtered_regressor(sampling, motion).shape == (3 * 60_001, 6)
    parameter = ca.MX.sym("parameter")
    matrix = ca.Function("information", [parameter], [information_matrix(sampling, parameter * ca.DM(motion))])
    regressor = filtered_regressor(sampling, motion)
    np.testing.assert_allclose(matrix(1.0).full(), regressor.T @ regressor, rtol=1e-9)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"duration_s": 3600.0, "control_rate_hz": 800.0, "step_s": 0.00125},
            "3600 s at control_rate_hz = 800 are 2,880,000 control periods, which take 25.9 GB; at most 400,000 are",
        ),
        (
            {"duration_s": 3600.0, "step_s": 1e-5},
            "3600 s in steps of 1e-05 s are 360,000,000 steps; at most 200,000,000",
        ),
    ],
)
def test_a_flight_that_fills_the_memory_or_never_ends_is_refused(tmp_path, capsys, changes, said):
    tree = scenario("basic")
    tree["simulation"] |= changes
    message = refusal(tree, tmp_path, capsys)
    assert "simulation.duration_s" in message
    assert said in message


def test_a_table_of_samples_that_takes_an_hour_at_a_high_rate_is_refused_by_check(tmp_path, capsys):
    tree = scenario("basic")
    time = np.linspace(0.0, 3600.0, 50)
    header = "time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s"
    rows = np.column_stack([time, 0.1 * np.sin(time)[:, None] * [1, 2, 3]])
    np.savetxt(tmp_path / "profile.csv", rows, delimiter=",", header=header, comments="")
    tree["maneuver"] = {"kind": "csv", "file": "profile.csv"}
    del tree["simulation"]["duration_s"]
    tree["simulation"]["control_rate_hz"] = 800.0
    assert read_profile(tmp_path / "profile.csv", 6, np.zeros(0)).duration == 3600.0
    assert "the flight: 3600 s at control_rate_hz = 800 are 2,880,000 control periods" in refusal(
        tree, tmp_path, capsys
    )


@pytest.mark.parametrize(("option", "value", "most"), [("--runs", 10**12, 10**6), ("--workers", 10**6, 1024)])
def test_a_campaign_without_end_is_refused(tmp_path, capsys, option, value, most):
    options = {"--runs": "2"} | {option: str(value)}
    words = [word for pair in options.items() for word in pair]
    message = refusal(scenario("basic"), tmp_path, capsys, "montecarlo", *words)
    assert f"'{option}': Input should be less than or equal to {most}" in message


def test_long_flights_are_flown_in_smaller_groups(tmp_path):
    plan = plan_of(small_scenario(tmp_path), 2)
    assert _side_by_side(plan) >= 25  # 80 periods each
    longer = plan.scenario.simulation.model_copy(update={"duration_s": 3000.0})
    flown = plan.scenario.model_copy(update={"simulation": longer})
    assert _side_by_side(replace(plan, scenario=flown)) == 1
