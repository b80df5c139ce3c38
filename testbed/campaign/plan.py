"""What a campaign flies: one maneuver, and the seed of every run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from testbed.assembly.engine import engine_of
from testbed.assembly.platform import PlatformModel, nominal_platform, true_platform
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.scenario import Scenario

BLOCK_RUNS = 25
"""Runs in a block: flown side by side, written together, and the most that an interruption costs per worker."""
COMPILED_BLOCK_RUNS = 50
"""The same of platforms stepped by the compiled equations: controller and estimators are NumPy's work for all flights
at once, and the more of them the less each takes. With blocks of 50 in the place of 100, a campaign of 2,000 runs takes
1.04 of the time, and one of 100 runs 0.7, as both of two cores have a block."""


class Platforms(NamedTuple):
    """The platforms of a campaign.

    Attributes:
        nominal: what controller, designer and estimators believe.
        truth: what flies; None where each flight has its own.
    """

    nominal: PlatformModel
    truth: PlatformModel | None


def platforms_of(scenario: Scenario) -> Platforms:
    """Compile the platforms that all flights of a scenario share.

    Raises:
        InputError: as `assembly.platform.nominal_platform`.
    """
    spread = scenario.dispersion
    each_its_own = spread is not None and (any(spread.inertia_kg_m2) or spread.rotor_momentum_relative > 0.0)
    return Platforms(nominal_platform(scenario), None if each_its_own else true_platform(scenario))


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

    @cached_property
    def platforms(self) -> Platforms:
        """Compiled once by each worker."""
        return platforms_of(self.scenario)


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


def command_alone(plan: CampaignPlan, scenario: str, seed: int) -> str:
    """Return the command that flies a run alone, by the engine of its campaign.

    Args:
        plan: of the campaign.
        scenario: its file, as the command line has it.
        seed: of the run.
    """
    engine = engine_of(plan.scenario, many=True)
    by = "" if engine == engine_of(plan.scenario, many=False) else f" --set simulation.engine={engine}"
    return f"testbed run {scenario} --dispersed --seed {seed}{by}"


def block_runs(plan: CampaignPlan) -> int:
    """Return how many runs a block has."""
    return BLOCK_RUNS if engine_of(plan.scenario, many=True) == "mujoco" else COMPILED_BLOCK_RUNS


def blocks_of(plan: CampaignPlan) -> Iterator[Block]:
    """Cut a campaign into blocks; the cut depends on the number of runs and on what steps the platforms alone."""
    length = block_runs(plan)
    for index, first in enumerate(range(0, plan.runs, length)):
        runs = range(first, min(first + length, plan.runs))
        yield Block(index=index, first=first, seeds=tuple(run_seed(plan.seed, run) for run in runs))
