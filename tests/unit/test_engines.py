"""`simulation.engine`: what flies, what is refused, what says so."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from support.campaigns import plan_of, small_scenario
from testbed.assembly.engine import engine_of
from testbed.campaign.columns import parameter_columns
from testbed.campaign.engine_check import check_engines
from testbed.campaign.flights import fly_seeds
from testbed.campaign.manifest import claimed, write_manifest
from testbed.campaign.plan import Block
from testbed.campaign.rows import block_rows
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.errors import InputError
from testbed.scenario.reader import read_scenario

STEP = "step_s = 0.003125"
CABIN = ("[gyro]\n", "[cabin]\nsize_m = [6.0, 2.0, 2.0]\n\n[gyro]\n")
FORMULA = '\n[[truth.torque]]\nformula = "w_x*w_y"\naxis = "z"\ncoefficient = 1e-3\n'


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


def scenario_with(folder, engine, *changes):
    return small_scenario(folder, (STEP, f'{STEP}\nengine = "{engine}"'), *changes)


def test_campaigns_fly_by_the_compiled_equations_and_runs_in_mujoco_where_nothing_is_said(tmp_path):
    scenario = read_scenario(small_scenario(tmp_path))
    assert scenario.simulation.engine == "auto"
    assert [engine_of(scenario, many=many) for many in (False, True)] == ["mujoco", "compiled"]


def test_mujoco_flies_campaigns_too_where_it_is_wanted(tmp_path):
    scenario = read_scenario(scenario_with(tmp_path, "mujoco"))
    assert [engine_of(scenario, many=many) for many in (False, True)] == ["mujoco", "mujoco"]


def test_auto_flies_in_mujoco_what_the_equations_do_not_cover(tmp_path):
    assert engine_of(read_scenario(scenario_with(tmp_path, "auto", CABIN)), many=True) == "mujoco"


def test_torques_by_formulas_fly_in_mujoco_alone(tmp_path):
    path = scenario_with(tmp_path, "compiled")
    path.write_text(path.read_text(encoding="utf-8") + FORMULA, encoding="utf-8")
    with pytest.raises(InputError, match=r"torques by formulas \(truth.torque\)"):
        engine_of(read_scenario(path), many=True)


def test_compiled_refuses_what_it_does_not_cover_and_says_what(tmp_path, capsys):
    path = scenario_with(tmp_path, "compiled", CABIN)
    with pytest.raises(InputError, match=r"contacts: it may touch the walls of a cabin.*write \"auto\" or \"mujoco\""):
        engine_of(read_scenario(path), many=True)
    assert run("check", path) == 2
    assert "cabin" in capsys.readouterr().err
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path / "out") == 2
    assert not (tmp_path / "out").exists()


def test_the_engines_agree_on_every_run_of_a_campaign(tmp_path):
    """At 3.125 ms, a coarse step, and with dispersed platforms, start and gyro."""
    check = check_engines(plan_of(small_scenario(tmp_path), 6), 6)
    assert check.runs == 6
    assert 0.0 < check.largest_difference < 1e-7


def test_a_campaign_has_the_same_estimates_with_either_engine(tmp_path):
    """To a thousandth of their standard deviations, at a step that is not converged to more."""
    block = Block(index=0, first=0, seeds=(1, 2, 3))
    flown = [block_rows(plan_of(scenario_with(tmp_path, engine), 3), block) for engine in ("mujoco", "compiled")]
    for theirs, ours in zip(*flown, strict=True):
        for name in ("ls", "output_error"):
            estimates, others, std = (
                np.array([row[column] for column in parameter_columns(prefix)])
                for row, prefix in ((theirs, name), (ours, name), (theirs, f"{name}_std"))
            )
            assert np.abs((estimates - others) / std).max() < 1e-3


@pytest.mark.parametrize(("runs", "threads"), [(1, 1), (3, 2)])
def test_blocks_and_threads_change_no_bit(tmp_path, runs, threads):
    plan = plan_of(scenario_with(tmp_path, "compiled"), 7)
    seeds = tuple(range(7))
    together = block_rows(plan, Block(index=0, first=0, seeds=seeds))
    cut = [Block(index=first, first=first, seeds=seeds[first : first + runs]) for first in range(0, 7, runs)]
    assert [row for block in cut for row in block_rows(plan, block, threads)] == together


def test_manifest_and_provenance_say_which_engine_flew(tmp_path):
    path = small_scenario(tmp_path)
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path / "out", "--workers", 1, "--check", 1) == 0
    manifest = json.loads((tmp_path / "out" / "campaign.json").read_text(encoding="utf-8"))
    assert manifest["campaign"]["engine"] == "compiled"
    result = json.loads((tmp_path / "out" / "montecarlo.json").read_text(encoding="utf-8"))
    assert result["provenance"]["engine"] == "compiled"
    assert result["engine_check"]["runs"] == 1
    assert result["engine_check"]["largest_difference_rad_s"] < 1e-7


def test_more_runs_than_a_campaign_has_are_not_compared(tmp_path, capsys):
    path = small_scenario(tmp_path)
    assert run("montecarlo", path, "--runs", 2, "--out", tmp_path / "out", "--check", 3) == 2
    assert "check (--check): 3 runs in both engines, but the campaign has 2; give no more" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_campaign_begun_before_there_were_two_engines_goes_on_in_mujoco(tmp_path):
    plan = plan_of(scenario_with(tmp_path, "mujoco"), 2)
    manifest = claimed(tmp_path / "out", plan)
    older = {key: value for key, value in manifest.campaign.items() if key != "engine"}
    assert "engine" not in older["scenario"]["simulation"]
    write_manifest(tmp_path / "out", replace(manifest, campaign=older))
    assert claimed(tmp_path / "out", plan).campaign["engine"] == "mujoco"


def test_a_campaign_is_not_continued_by_the_other_engine(tmp_path, capsys):
    path = scenario_with(tmp_path, "mujoco")
    arguments = ["montecarlo", path, "--out", tmp_path / "out", "--workers", 1]
    assert run(*arguments, "--runs", 2) == 0
    capsys.readouterr()
    assert run(*arguments, "--runs", 3, "--resume", "--set", "simulation.engine=auto") == 2
    said = capsys.readouterr().err
    assert 'engine "mujoco", now "compiled"' in said
    assert "To go on with it: --set simulation.engine=mujoco" in said


def test_momentum_of_a_compiled_flight_is_that_of_its_record(tmp_path):
    plan = plan_of(scenario_with(tmp_path, "compiled"), 2)
    theirs = plan_of(scenario_with(tmp_path, "mujoco"), 2)
    (ours,), (mujoco,) = (fly_seeds(each.scenario, each.maneuver, [3]) for each in (plan, theirs))
    channels = [flight.flown.record.channels["true_total_momentum"] for flight in (ours, mujoco)]
    np.testing.assert_allclose(*channels, rtol=0.0, atol=1e-8)  # MuJoCo drifts by 1e-10 at this step
    assert ours.flown.summary.momentum_drift < 1e-13
