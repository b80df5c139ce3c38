"""Runs of a campaign flown by both engines, and how far apart they come out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Vectors3
from testbed.assembly.engine import with_engine
from testbed.campaign.flights import fly_seeds
from testbed.campaign.plan import CampaignPlan, run_seed
from testbed.errors import InputError
from testbed.plant.plant import Engine


@dataclass(frozen=True, kw_only=True)
class EngineCheck:
    """The first runs of a campaign by MuJoCo and by the compiled equations of motion.

    Attributes:
        runs: how many were flown by both.
        largest_difference: of the true body rate at the control ticks, about any axis, rad/s.
        run: in which it is.
    """

    runs: int
    largest_difference: float
    run: int


def check_engines(plan: CampaignPlan, runs: int) -> EngineCheck:
    """Fly the first runs of a campaign by both engines.

    Args:
        plan: of the campaign.
        runs: how many; no more than the campaign has.

    Raises:
        InputError: the compiled equations do not cover the platform, or no run flies to its end.
    """
    seeds = [run_seed(plan.seed, run) for run in range(runs)]
    theirs, ours = (_body_rates(plan, seeds, engine) for engine in ("mujoco", "compiled"))
    apart = {
        run: float(np.abs(one - other).max())
        for run, (one, other) in enumerate(zip(theirs, ours, strict=True))
        if one is not None and other is not None
    }
    if not apart:
        raise InputError(f"{plan.scenario.name}: none of its first {len(seeds)} runs can be compared; all failed")
    run = max(apart, key=lambda each: apart[each])
    return EngineCheck(runs=len(apart), largest_difference=apart[run], run=run)


def _body_rates(plan: CampaignPlan, seeds: list[int], engine: Engine) -> list[Vectors3 | None]:
    """Return the true body rates of runs, shape (N, 3), rad/s; None of one that failed."""
    flights = fly_seeds(with_engine(plan.scenario, engine), plan.maneuver, seeds)
    return [
        None if flight.message or flight.flown is None else flight.flown.record.channels["true_body_rate"]
        for flight in flights
    ]
