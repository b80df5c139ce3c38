"""The whole reproduction in one run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from testbed.arrays import Vector3
from testbed.assembly.platform import shown_model
from testbed.campaign.flights import fly_seeds
from testbed.campaign.local import LocalExecutor
from testbed.experiment.experiment import Experiment
from testbed.plant.plant import Model
from testbed.records.record import Record
from testbed.reproduction.alignments import SCENARIO as ALIGNMENTS_SCENARIO
from testbed.reproduction.alignments import Alignments, alignments
from testbed.reproduction.claims import FULL_RUNS
from testbed.reproduction.orbit import SCENARIO as ORBIT_SCENARIO
from testbed.reproduction.orbit import orbit
from testbed.reproduction.parts import NOWHERE, Parts
from testbed.reproduction.progress import Progress, silent
from testbed.reproduction.scenarios import paper_scenario
from testbed.reproduction.table1 import Table1, table1
from testbed.reproduction.table2 import SCENARIOS as TABLE2_SCENARIOS
from testbed.reproduction.table2 import ManeuverStatistics, table2
from testbed.reproduction.whiteness import Whiteness, whiteness
from testbed.reproduction.workers import Job, done_by_workers
from testbed.reproduction.zero_g import SCENARIO as ZERO_G_SCENARIO
from testbed.reproduction.zero_g import Table3, table3
from testbed.reproduction.zero_g_claims import FULL_CAMPAIGNS
from testbed.scenario.scenario import Scenario

SCENARIOS = (*TABLE2_SCENARIOS, ZERO_G_SCENARIO, ALIGNMENTS_SCENARIO, ORBIT_SCENARIO)
"""Everything that is flown comes from these."""


@dataclass(frozen=True, kw_only=True)
class Extent:
    """How much is flown.

    Attributes:
        runs: of each maneuver of Table 2.
        zero_g_campaigns: repetitions of the zero-g campaign.
        alignment_platforms: flown with null motion and without.
        whiteness_flights: whose residuals are averaged.
        quick_designs: whether Table 1's designs have one start each.
        time_limit: that all of it may take on two cores, s.
        seed: of everything.
        workers: processes.
    """

    runs: int
    zero_g_campaigns: int
    alignment_platforms: int
    whiteness_flights: int
    quick_designs: bool
    time_limit: float
    seed: int
    workers: int


def full_extent(*, seed: int, workers: int, runs: int | None = None) -> Extent:
    """Return the whole reproduction; runs of Table 2's maneuvers where another number than 1,000 is wanted."""
    return Extent(
        runs=FULL_RUNS if runs is None else runs,
        zero_g_campaigns=FULL_CAMPAIGNS,
        alignment_platforms=100,
        whiteness_flights=25,
        quick_designs=False,
        time_limit=720.0,
        seed=seed,
        workers=workers,
    )


def quick_extent(*, seed: int, workers: int, runs: int | None = None) -> Extent:
    """Return a reproduction with a tenth of the flights."""
    return Extent(
        runs=100 if runs is None else runs,
        zero_g_campaigns=20,
        alignment_platforms=20,
        whiteness_flights=10,
        quick_designs=True,
        time_limit=180.0,
        seed=seed,
        workers=workers,
    )


@dataclass(frozen=True, kw_only=True)
class Flown:
    """What depends on the seed.

    Attributes:
        table2: one per maneuver.
        whiteness: of the residual, on the D-opt maneuver.
        table3: the zero-g campaign, figures 5 and 6.
        alignments: of the actuators.
    """

    table2: tuple[ManeuverStatistics, ...]
    whiteness: Whiteness
    table3: Table3
    alignments: Alignments


@dataclass(frozen=True, kw_only=True)
class Reproduction(Flown):
    """Everything that the reproduction gives.

    Attributes:
        extent: how much was flown.
        table1: designs.
        longest_flight: whole record of the flight of figure 5, with what only the simulation knows.
        zero_g_model: the platform of that campaign, with all that there is to look at.
        orbit: the longer maneuver.
        acceleration_limit: of the paper's platform, per body axis, rad/s². Source: paper eqs. (25), (31).
        seconds: that all of it took, all starts together.
    """

    extent: Extent
    table1: Table1
    longest_flight: Record
    zero_g_model: Model
    orbit: Experiment
    acceleration_limit: Vector3
    seconds: float


def reproduce(extent: Extent, progress: Progress = silent, parts: Parts = NOWHERE) -> Reproduction:
    """Make the paper's tables and figures, and this project's beside them.

    Args:
        extent: how much to fly.
        progress: called with every part.
        parts: that are finished.

    Raises:
        InputError: a worker process died, or memory ran out.
    """
    flown = flown_of(extent, progress, parts)
    jobs = (
        Job(
            name="table1",
            part="Table 1, designs",
            items=1,
            call=partial(table1, quick=extent.quick_designs),
            arguments=(),
        ),
        Job(name=None, part="Orbit", items=1, call=orbit, arguments=(extent.seed,)),  # half a minute
    )
    designs, orbiting = done_by_workers(jobs, extent.workers, progress, parts)
    flight, model = _longest_flight(flown.table3)
    return Reproduction(
        **vars(flown),
        extent=extent,
        table1=designs,
        longest_flight=flight,
        zero_g_model=model,
        orbit=orbiting,
        acceleration_limit=_acceleration_limit(_paper()),
        seconds=_seconds(parts),
    )


def flown_of(extent: Extent, progress: Progress = silent, parts: Parts = NOWHERE) -> Flown:
    """Fly all that depends on the seed; as `reproduce`."""
    seed, workers = extent.seed, extent.workers
    maneuvers = table2(extent.runs, seed, LocalExecutor(workers=workers), progress, parts)
    d_optimal = next(maneuver.maneuver for maneuver in maneuvers if maneuver.name == "paper_d_optimal")
    job = Job(
        name=f"whiteness-seed{seed}",
        part="Whiteness",
        items=1,
        call=whiteness,
        arguments=(_paper(), d_optimal, extent.whiteness_flights, seed),
    )
    (white,) = done_by_workers([job], 1, progress, parts)
    return Flown(
        table2=maneuvers,
        whiteness=white,
        table3=table3(extent.zero_g_campaigns, seed, progress, workers, parts),
        alignments=alignments(extent.alignment_platforms, seed, progress, workers, parts),
    )


def _paper() -> Scenario:
    return paper_scenario("paper_d_optimal")


def _seconds(parts: Parts) -> float:
    """Return how long the whole took; once it was finished, that stays, whatever is added to its folder later."""
    seconds: float | None = parts.result("seconds")
    if seconds is None:
        seconds = parts.elapsed
        parts.keep("seconds", seconds)
    return seconds


def _acceleration_limit(scenario: Scenario) -> Vector3:
    inertia = np.diag(np.array(scenario.platform.inertia_kg_m2))
    return np.asarray(np.array(scenario.limits.cluster_torque_N_m) / inertia)  # eq. (25)


def _longest_flight(campaign: Table3) -> tuple[Record, Model]:
    """Fly the flight of figure 5 again: what a campaign keeps of its flights is telemetry alone."""
    scenario = paper_scenario(ZERO_G_SCENARIO)
    longest = max(campaign.flights, key=lambda flight: flight.usable)
    (flight,) = fly_seeds(scenario, campaign.maneuver, [longest.seed])
    assert flight.flown is not None
    return flight.flown.record, shown_model(scenario)
