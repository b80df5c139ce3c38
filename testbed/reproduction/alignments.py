"""The paper's second piece of future work: null motion that makes the actuators' alignments observable.

The same platforms, each built out of alignment in its own way, fly the same body rates twice: with the null motion that
was designed for their alignments, and by pseudo-inverse steering without any.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
import scipy

from testbed.arrays import Array
from testbed.estimation.alignment_observability import parameter_names, parameter_units
from testbed.reproduction.alignment_flights import Flight, fly_block
from testbed.reproduction.parts import NOWHERE, Parts, kept_maneuver
from testbed.reproduction.progress import Progress, silent
from testbed.reproduction.scenarios import paper_scenario
from testbed.reproduction.workers import Job, done_by_workers

SCENARIO = "alignments"
BAND = 1.96
"""Standard deviations on either side that hold 95 % of a normal distribution."""
_BLOCK = 10
_CHANCE = 1e-3
"""Of any coverage being called too low or too high where none is."""


@dataclass(frozen=True, kw_only=True)
class SteeringStatistics:
    """What the flights of one kind of steering gave; parameters in the order of `Alignments.names`.

    Attributes:
        steering: in words.
        failed: flights without an estimate of all parameters.
        scatter: standard deviation of estimate minus truth, shape (30,).
        claimed: root mean square of the claimed standard deviations, shape (30,).
        mean_error: shape (30,).
        coverage: share of the flights whose 95 % interval holds the truth, shape (30,).
        saturated: mean time at a limit, s.
        gimbal_rate: largest share of the gimbal rate's limit.
        rate_difference: largest difference of the true body rate from the reference, root mean square, rad/s.
        null_space: what the first flight's record leaves open, a line each.
    """

    steering: str
    failed: int
    scatter: Array
    claimed: Array
    mean_error: Array
    coverage: Array
    saturated: float
    gimbal_rate: float
    rate_difference: float
    null_space: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Alignments:
    """Inertia and alignments estimated from many flights, with null motion and without.

    Attributes:
        names: of the 30 parameters.
        units: of each.
        runs: platforms, each flown once with either steering.
        null_motion: as designed.
        pseudo_inverse: the same body rates by Moore-Penrose steering.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    runs: int
    null_motion: SteeringStatistics
    pseudo_inverse: SteeringStatistics

    @property
    def scatter_ratio(self) -> Array:
        """How many times smaller the scatter with null motion is, shape (30,)."""
        return np.asarray(self.pseudo_inverse.scatter / self.null_motion.scatter)

    @property
    def median_ratio(self) -> float:
        """Median of `scatter_ratio` over all parameters that the maneuver was designed for."""
        return float(np.median(self.scatter_ratio))

    @property
    def coverage_range(self) -> tuple[float, float]:
        """What the coverages of honest 95 % intervals all keep within but once in a thousand times."""
        tail = _CHANCE / (2.0 * len(self.names))
        low, high = scipy.stats.binom.ppf([tail, 1.0 - tail], self.runs, 0.95) / self.runs
        return float(low), float(high)


def alignments(
    runs: int, seed: int, progress: Progress = silent, workers: int = 1, parts: Parts = NOWHERE
) -> Alignments:
    """Fly and estimate scenarios/alignments.toml many times, each time a platform built differently.

    Args:
        runs: platforms.
        seed: of what is built and of all sensor noise.
        progress: called with the flights.
        workers: processes.
        parts: that are finished.
    """
    scenario = paper_scenario(SCENARIO)
    maneuver = kept_maneuver(scenario, parts)
    seeds = np.random.SeedSequence(seed).generate_state(runs)
    blocks = [block.tolist() for block in np.array_split(seeds, ceil(runs / _BLOCK))]
    jobs = [
        Job(
            name=f"alignments-seed{seed}-{index:05d}",
            part="Alignments",
            items=2 * len(block),
            call=fly_block,
            arguments=(scenario, maneuver, block),
        )
        for index, block in enumerate(blocks)
    ]
    null_motion, pseudo_inverse = zip(
        *(pair for block in done_by_workers(jobs, workers, progress, parts) for pair in block), strict=True
    )
    return Alignments(
        names=parameter_names(scenario.gyros.units),
        units=parameter_units(scenario.gyros.units),
        runs=runs,
        null_motion=_statistics("null motion as designed", null_motion),
        pseudo_inverse=_statistics("pseudo-inverse, the same body rates", pseudo_inverse),
    )


def _statistics(steering: str, flights: Sequence[Flight]) -> SteeringStatistics:
    errors, stds = np.array([flight.error for flight in flights]), np.array([flight.std for flight in flights])
    whole = np.isfinite(stds).all(axis=1)
    errors, stds = errors[whole], stds[whole]
    return SteeringStatistics(
        steering=steering,
        failed=int((~whole).sum()),
        scatter=errors.std(axis=0, ddof=1),
        claimed=np.sqrt(np.mean(stds**2, axis=0)),
        mean_error=errors.mean(axis=0),
        coverage=np.mean(np.abs(errors) <= BAND * stds, axis=0),
        saturated=float(np.mean([flight.saturated for flight in flights])),
        gimbal_rate=max(flight.gimbal_rate for flight in flights),
        rate_difference=max(flight.rate_difference for flight in flights),
        null_space=flights[0].null_space,
    )
