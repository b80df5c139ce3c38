"""What a run of a campaign gives depends on its seed alone: not on who flew beside it, nor on threads or workers."""

from __future__ import annotations

import json

import numpy as np
import pytest

from support.campaigns import plan_of, small_scenario
from testbed.campaign.columns import parameter_columns
from testbed.campaign.local import LocalExecutor
from testbed.campaign.plan import Block, blocks_of
from testbed.campaign.rows import block_rows
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of

RUNS = 25


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return small_scenario(tmp_path_factory.mktemp("scenario"))


@pytest.fixture(scope="module")
def plan(path):
    return plan_of(path, RUNS)


@pytest.fixture(scope="module")
def together(plan):
    (block,) = blocks_of(plan)
    return block_rows(plan, block)


def cut(plan, runs):
    """The campaign in blocks of so many runs."""
    (whole,) = blocks_of(plan)
    return [
        Block(index=index, first=first, seeds=whole.seeds[first : first + runs])
        for index, first in enumerate(range(0, RUNS, runs))
    ]


def test_the_runs_differ(together):
    assert len({row["true_J11_kg_m2"] for row in together}) == RUNS
    assert len({row["output_error_J11_kg_m2"] for row in together}) == RUNS


@pytest.mark.parametrize(("runs", "threads"), [(1, 1), (7, 2), (25, 2)])
def test_blocks_and_threads_change_no_bit(plan, together, runs, threads):
    apart = [row for block in cut(plan, runs) for row in block_rows(plan, block, threads)]
    assert apart == together


def test_workers_change_no_bit(plan, together):
    done = list(LocalExecutor(workers=2).finished(plan, cut(plan, 7), pytest.fail))
    rows = [row for block in sorted(done, key=lambda block: block.block.index) for row in block.rows]
    assert rows == together


def alone(path, row, folder, *options):
    """Return the result of one run of the campaign, flown by the command."""
    arguments = ["run", path, "--dispersed", "--seed", row["seed"], "--out", folder / "alone", *options]
    assert exit_code_of(lambda: app([str(argument) for argument in arguments])) == 0
    return json.loads((folder / "alone" / "result.json").read_text(encoding="utf-8"))


def test_a_run_flown_alone_by_the_same_engine_is_the_campaigns(path, together, tmp_path):
    row = together[17]
    result = alone(path, row, tmp_path, "--set", "simulation.engine=compiled")
    assert result["truth"]["theta_kg_m2"] == [row[column] for column in parameter_columns("true")]
    for name in ("ls", "output_error"):
        assert result["estimates"][name]["theta_kg_m2"] == [row[column] for column in parameter_columns(name)]
    bound = [row[column] for column in parameter_columns("bound_std")]
    assert np.array_equal(result["bound_std_kg_m2"], bound)


def test_a_run_flown_alone_in_mujoco_is_the_campaigns_but_for_what_the_step_errs_by(path, together, tmp_path):
    row = together[17]
    result = alone(path, row, tmp_path)
    assert result["truth"]["theta_kg_m2"] == [row[column] for column in parameter_columns("true")]
    for name in ("ls", "output_error"):
        ours, std = (np.array([row[column] for column in parameter_columns(each)]) for each in (name, f"{name}_std"))
        assert np.abs((np.array(result["estimates"][name]["theta_kg_m2"]) - ours) / std).max() < 1e-3
