"""What a campaign flies: one maneuver, and the seed of every run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from testbed.assembly.engine import engine_of
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.scenario import Scenario

BLOCK_RUNS = 25
"""Runs in a block: flown side by side, written together, and the most that an interruption costs per worker."""
COMPILED_BLOCK_RUNS = 50
"""The same of platforms stepped by the compiled equations. There the controller, which is NumPy's work for all flights
at once, takes a good part of the time: flights of `scenarios/basic.toml` take 17.9 ms each 25 at a time, 13.1 with 50
and 11.1 with 100, when small campaigns would no longer occupy all cores."""


@dataclass(frozen=True, kw_only=True)
class CampaignPlan:
    """Everything that decides a campaign's results.

    Attributes:
        scenario: what is flown.
        maneuver: the same in every run.
        seed: from which every run's own seed is derived.
        runs: how many.
    """

    scenario: Scenario
    maneuver: Maneuver
    seed: int
    runs: int


@dataclass(frozen=True, kw_only=True)
class Block:
    """Runs that are flown together.

    Attributes:
        index: of the block.
        first: index of its first run.
        seeds: of its runs.
    """

    index: int
    first: int
    seeds: tuple[int, ...]


def run_seed(campaign_seed: int, run: int) -> int:
    """Return the seed of a run; with it `testbed run` flies the same flight alone.

    Args:
        campaign_seed: of the campaign.
        run: index of the run, from 0.
    """
    sequence = np.random.SeedSequence(campaign_seed, spawn_key=(run,))
    return int(sequence.generate_state(1, np.uint64)[0] >> np.uint64(1))  # fits a signed 64-bit column


def block_runs(plan: CampaignPlan) -> int:
    """Return how many runs a block has."""
    return BLOCK_RUNS if engine_of(plan.scenario, many=True) == "mujoco" else COMPILED_BLOCK_RUNS


def blocks_of(plan: CampaignPlan) -> Iterator[Block]:
    """Cut a campaign into blocks; the cut depends on the number of runs and on what steps the platforms alone."""
    length = block_runs(plan)
    for index, first in enumerate(range(0, plan.runs, length)):
        runs = range(first, min(first + length, plan.runs))
        yield Block(index=index, first=first, seeds=tuple(run_seed(plan.seed, run) for run in runs))
