"""The paper's second piece of future work: null motion that makes the actuators' alignments observable.

The same platforms, each built out of alignment in its own way, fly the same body rates twice: with the null motion that
was designed for their alignments, and by pseudo-inverse steering without any.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import NamedTuple

import numpy as np
from scipy.stats import binom

from testbed.arrays import Array
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.estimation.alignment_observability import NAMES, UNITS
from testbed.experiment.aligning import align_flight, null_space_lines
from testbed.experiment.flying import Sortie, fly_sorties
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.design import Design
from testbed.maneuver.maneuver import Maneuver
from testbed.reproduction.crew import Job, done_by_crew
from testbed.reproduction.progress import Progress, silent
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

SCENARIO = "alignments"
AXIS_SPREAD = 0.012
"""rad, 0.7 deg: standard deviation of each turn of a gimbal axis, and of each encoder's zero."""
SCALE_SPREAD = 0.01
"""Standard deviation of each tachometer's scale, which its rotor's speed servo goes by."""
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
        design: of the maneuver.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    runs: int
    null_motion: SteeringStatistics
    pseudo_inverse: SteeringStatistics
    design: Design

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
        low, high = binom.ppf([tail, 1.0 - tail], self.runs, 0.95) / self.runs
        return float(low), float(high)


class Flight(NamedTuple):
    """What one flight gave; errors and stds are NaN where it gave nothing."""

    error: Array
    std: Array
    saturated: float
    gimbal_rate: float
    rate_difference: float
    null_space: tuple[str, ...]


def alignments(runs: int, seed: int, progress: Progress = silent, workers: int = 1) -> Alignments:
    """Fly and estimate scenarios/alignments.toml many times, each time a platform built differently.

    Args:
        runs: platforms.
        seed: of what is built and of all sensor noise.
        progress: told of the flights.
        workers: processes.
    """
    scenario = read_scenario(shipped_scenario(SCENARIO))
    design = plan_maneuver(scenario, nominal_platform(scenario)).design
    assert design is not None  # the scenario asks for one
    seeds = np.random.SeedSequence(seed).generate_state(runs)
    blocks = [block.tolist() for block in np.array_split(seeds, ceil(runs / _BLOCK))]
    jobs = [
        Job(part="Alignments", items=2 * len(block), call=fly_block, arguments=(scenario, design.maneuver, block))
        for block in blocks
    ]
    null_motion, pseudo_inverse = zip(
        *(pair for block in done_by_crew(jobs, workers, progress) for pair in block), strict=True
    )
    return Alignments(
        names=NAMES,
        units=UNITS,
        runs=runs,
        null_motion=_statistics("null motion as designed", null_motion),
        pseudo_inverse=_statistics("pseudo-inverse, the same body rates", pseudo_inverse),
        design=design,
    )


def fly_block(scenario: Scenario, maneuver: Maneuver, seeds: Sequence[int]) -> list[tuple[Flight, Flight]]:
    """Fly platforms side by side, with null motion and then without; a pair for each seed.

    Args:
        scenario: nominal platform and sensors.
        maneuver: the designed one.
        seeds: of the flights.
    """
    without = replace(maneuver, gimbal_angle=None)
    return list(
        zip(
            _flights(scenario, maneuver, seeds),
            _flights(pseudo_inverse_scenario(scenario), without, seeds),
            strict=True,
        )
    )


def pseudo_inverse_scenario(scenario: Scenario) -> Scenario:
    """Return the same scenario steered without null motion: no gimbal angles are preferred to others."""
    steering = scenario.controller.steering.model_copy(
        update={"preferred_gimbal_angle_rad": "zero", "null_motion_gain_1_s": 0.0}
    )
    controller = scenario.controller.model_copy(update={"steering": steering})
    return scenario.model_copy(update={"controller": controller})


def as_built(scenario: Scenario, seed: int) -> Scenario:
    """Return a scenario whose flown units are out of alignment as a seed draws it.

    A rotor's servo goes by its tachometer, so that a tachometer that reads too much leaves it too slow.
    """
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0,)))
    axes, zeros = AXIS_SPREAD * rng.standard_normal((6, 2)), AXIS_SPREAD * rng.standard_normal(6)
    scales = SCALE_SPREAD * rng.standard_normal(6)
    momenta = scenario.cluster.rotor_momentum_N_m_s / (1.0 + scales)
    truth = {"gimbal_axis_misalignment_rad": axes.tolist(), "rotor_momentum_N_m_s": tuple(momenta.tolist())}
    return scenario.model_copy(
        update={
            "truth": scenario.truth.model_copy(update=truth),
            "encoder": scenario.encoder.model_copy(update={"zero_rad": tuple(zeros.tolist())}),
            "tachometer": scenario.tachometer.model_copy(update={"scale_factor_error": tuple(scales.tolist())}),
        }
    )


def _flights(scenario: Scenario, maneuver: Maneuver, seeds: Sequence[int]) -> list[Flight]:
    nominal = nominal_platform(scenario)
    built = [as_built(scenario, seed) for seed in seeds]
    sorties = [
        Sortie(scenario=each, truth=true_platform(each), seed=seed) for each, seed in zip(built, seeds, strict=True)
    ]
    flown = fly_sorties(scenario, sorties, nominal, maneuver)
    flights = []
    for sortie, run in zip(sorties, flown, strict=True):
        aligning = align_flight(sortie.scenario, nominal, sortie.truth, run.record)
        estimate, nothing = aligning.estimate, np.full(len(NAMES), np.nan)
        flights.append(
            Flight(
                error=nothing if estimate is None else estimate.parameters - aligning.true_parameters,
                std=nothing if estimate is None else estimate.std,
                saturated=run.summary.saturated,
                gimbal_rate=run.summary.limit_use["gimbal_rate"],
                rate_difference=float(run.summary.tracking_rms.max()),
                null_space=() if estimate is None else tuple(null_space_lines(estimate.observability)),
            )
        )
    return flights


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
