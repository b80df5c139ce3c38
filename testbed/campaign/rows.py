"""A campaign's runs as rows of its data set."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from testbed.arrays import Theta, Vector3
from testbed.assembly.control import flight_clock
from testbed.campaign.columns import FAILURE, offset_columns
from testbed.campaign.flights import DispersedFlight, fly_seeds
from testbed.campaign.plan import Block, CampaignPlan
from testbed.dynamics.environment import Pivoted
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.experiment.experiment import Estimation
from testbed.experiment.running_estimators import MeasuredFlight, estimate_flights
from testbed.simulation.summary import FlightSummary

Row: TypeAlias = dict[str, Any]
"""One run by column name; a column is absent where the run has no such value."""

_MEMORY, _BYTES_A_TICK = 3e8, 2.5e3
"""What the flights of a block may take together, and what one takes for a control period: its log and its record. So 50
flights of a minute go side by side, and all of a block of shorter ones."""


def block_rows(plan: CampaignPlan, block: Block, threads: int = 1) -> list[Row]:
    """Fly and estimate the runs of a block: the unit of work that a worker gets.

    Args:
        plan: of the campaign.
        block: which runs.
        threads: that step the platforms.
    """
    most, rows = _side_by_side(plan), list[Row]()
    for first in range(0, len(block.seeds), most):
        seeds = block.seeds[first : first + most]
        rows += _rows(plan, fly_seeds(plan.scenario, plan.maneuver, seeds, threads, plan.platforms))
    return [{"run": block.first + index} | row for index, row in enumerate(rows)]


def _side_by_side(plan: CampaignPlan) -> int:
    """Return how many flights of a block fit into the memory of a worker, at least one."""
    ticks = flight_clock(plan.scenario, plan.maneuver.duration).ticks
    return max(1, int(_MEMORY / (_BYTES_A_TICK * ticks)))


def _rows(plan: CampaignPlan, flights: Sequence[DispersedFlight]) -> list[Row]:
    """Return the rows of flights side by side; those that were completed are estimated together."""
    measured = [
        MeasuredFlight(flight.scenario, flight.truth, flight.flown.record)
        for flight in flights
        if flight.truth is not None and flight.flown is not None and not flight.message
    ]
    estimations = iter(estimate_flights(measured, plan.platforms.nominal, plan.maneuver, checked=False))
    return [_flown(flight) | ({} if flight.message else _estimates(next(estimations))) for flight in flights]


def _flown(flight: DispersedFlight) -> Row:
    row: Row = {"seed": flight.seed, "outcome": "failed" if flight.message else "completed", "message": flight.message}
    if flight.truth is not None:
        row |= _parameters("true", theta_of(flight.truth.inertia))
        if isinstance(flight.truth.environment, Pivoted):
            row |= _offset("true", flight.truth.environment.offset_B)
    if flight.flown is not None:
        row |= _flight(flight.flown.summary) | {"first_contact_s": flight.flown.first_contact}
    return row


def _estimates(estimation: Estimation) -> Row:
    row: Row = {}
    for name, estimate in estimation.by_name.items():
        row |= _parameters(name, estimate.theta) | _parameters(f"{name}_std", estimate.std)
        if estimation.pivot is not None:
            row |= _offset(name, estimation.pivot.offset_B + estimate.offset_error)
            row |= _offset(f"{name}_std", estimate.offset_std)
    if estimation.bound_std is not None:
        row |= _parameters("bound_std", estimation.bound_std)
    if estimation.offset_bound_std is not None:
        row |= _offset("bound_std", estimation.offset_bound_std)
    return row | {f"{name}{FAILURE}": message for name, message in estimation.failures.items()}


def _parameters(prefix: str, theta: Theta) -> Row:
    return {f"{prefix}_{name}_kg_m2": float(value) for name, value in zip(PARAMETER_NAMES, theta, strict=True)}


def _offset(prefix: str, offset: Vector3) -> Row:
    return {name: float(value) for name, value in zip(offset_columns(prefix), offset, strict=True)}


def _flight(summary: FlightSummary) -> Row:
    tracking = {
        f"tracking_rms_{axis}_rad_s": float(value) for axis, value in zip("xyz", summary.tracking_rms, strict=True)
    }
    return tracking | {
        "saturated_s": summary.saturated,
        "min_singularity_measure": summary.min_singularity_measure,
        "momentum_drift_relative": summary.momentum_drift,
    }
