"""Bias, scatter and coverage of every estimator beside the Cramér-Rao bound, over many seeds.

Run with `python -m benchmarks.estimators [SEEDS]`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from support.closed_loop_telemetry import closed_loop_flights, measured_telemetry, true_telemetry
from support.synthetic_telemetry import (
    NOMINAL_THETA,
    TRUE_THETA,
    exact_telemetry,
    noisy,
    nominal_flight,
    sample_times,
)
from testbed.arrays import Array, Covariance, Theta, Vector3
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.slow_bias import SlowBias
from testbed.estimation.telemetry import Telemetry
from testbed.sensors.noise import random_walk

SAMPLE_RATE = 16.0
SIMULATION_NOISE = 0.025
FLIGHT_NOISE = 0.001658
ENCODER_NOISE = 1e-4
BIAS_WALK = 0.01
"""rad/s/√s: from sample to sample the bias gains one and a half times the flight noise."""
RELEASE_MOMENTUM_B = np.array([0.003, -0.004, 0.006])
NORMAL_95 = 1.96
InitialMomentum: TypeAlias = Literal["estimated", "zero"]


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """A motion flown many times, each with its own noise.

    Attributes:
        name: what is printed.
        settings: of the estimators.
        telemetry: of a seed.
        bound_std: standard deviations of the motion's Cramér-Rao bound, shape (6,), kg·m².
    """

    name: str
    settings: EstimationSettings
    telemetry: Callable[[int], Telemetry]
    bound_std: Theta


@dataclass(frozen=True, kw_only=True)
class Score:
    """What one estimator answered over S seeds.

    Attributes:
        error: θ̂ - θ, shape (S, 6), kg·m².
        std: what it said of itself, shape (S, 6), kg·m².
        bound_std: shape (6,), kg·m².
        seconds: mean time of an estimate.
    """

    error: Array
    std: Array
    bound_std: Theta
    seconds: float

    @property
    def bias(self) -> Theta:
        """Mean error in standard errors of the mean."""
        return np.sqrt(len(self.error)) * self.error.mean(axis=0) / self.error.std(axis=0, ddof=1)

    @property
    def scatter(self) -> Theta:
        """Standard deviation over the bound's."""
        return self.error.std(axis=0, ddof=1) / self.bound_std

    @property
    def coverage(self) -> Theta:
        """Share of the 95 % bands that hold the truth."""
        return (np.abs(self.error) <= NORMAL_95 * self.std).mean(axis=0)


def scores(experiment: Experiment, seeds: int) -> dict[str, Score]:
    """Return every estimator's score over seeds 0, 1, ..."""
    runs = [experiment.telemetry(seed) for seed in range(seeds)]
    return {name: _score(experiment, runs, name) for name in ESTIMATORS}


def _score(experiment: Experiment, runs: list[Telemetry], name: str) -> Score:
    start = time.perf_counter()
    estimates = [ESTIMATORS[name](run, experiment.settings) for run in runs]
    return Score(
        error=np.array([estimate.theta for estimate in estimates]) - TRUE_THETA,
        std=np.array([estimate.std for estimate in estimates]),
        bound_std=experiment.bound_std,
        seconds=(time.perf_counter() - start) / len(runs),
    )


def open_loop(
    gyro_noise: float, momentum_B: Vector3, initial_momentum: InitialMomentum = "estimated", walk: float = 0.0
) -> Experiment:
    """Return the nominal motion flown exactly, the instrument simulated; with a gyro whose bias walks, rad/s/√s."""
    flight = nominal_flight(momentum_B)
    times = sample_times(SAMPLE_RATE)
    exact = replace(
        exact_telemetry(flight, times, times, gyro_noise),
        initial_momentum=initial_momentum,
        slow_bias=SlowBias(instability=0.0, random_walk=walk) if walk else None,
    )
    return Experiment(
        name=f"open loop, {gyro_noise} rad/s, |H| {np.linalg.norm(momentum_B):.4f} N·m·s, momentum {initial_momentum}"
        + (f", bias walks {walk} rad/s/√s" if walk else ""),
        settings=EstimationSettings(nominal_theta=NOMINAL_THETA),
        telemetry=lambda seed: _walking(noisy(exact, seed, ENCODER_NOISE), walk, seed),
        bound_std=_std(cramer_rao_bound(exact, TRUE_THETA, momentum_B)),
    )


def _walking(telemetry: Telemetry, walk: float, seed: int) -> Telemetry:
    """Return telemetry whose gyro's bias walks from nothing at the first sample, in rad/s/√s."""
    bias = random_walk(walk, 1.0 / SAMPLE_RATE, telemetry.body_rate.shape, np.random.default_rng((seed, 1)))
    return replace(telemetry, body_rate=telemetry.body_rate + bias)


def closed_loop(gyro_noise: float, seeds: int) -> Experiment:
    """Return the nominal motion tracked with feedback from the noisy gyro, the instrument from the reference."""
    flight = nominal_flight()
    flights = closed_loop_flights(flight, np.random.default_rng(1), seeds, gyro_noise, ENCODER_NOISE)
    true_motions = [true_telemetry(flights, flight, index, gyro_noise) for index in range(min(seeds, 20))]
    bounds = [cramer_rao_bound(motion, TRUE_THETA, np.zeros(3)) for motion in true_motions]
    return Experiment(
        name=f"closed loop, {gyro_noise} rad/s",
        settings=EstimationSettings(
            nominal_theta=NOMINAL_THETA, instrument="reference", reference_rate=flight.body_rate
        ),
        telemetry=lambda seed: measured_telemetry(flights, flight, seed, gyro_noise),
        bound_std=_std(np.mean(bounds, axis=0)),
    )


def _std(covariance: Covariance) -> Theta:
    return np.sqrt(np.diag(covariance))


def report(experiment: Experiment, seeds: int) -> str:
    """Return the scores as text, one block per estimator."""
    lines = [experiment.name, f"  {'bound, 1e-3 kg·m²':34s}" + _row(1e3 * experiment.bound_std, "8.3f")]
    for name, score in scores(experiment, seeds).items():
        lines += [
            f"  {name:13s}{'mean error, standard errors':>21s}" + _row(score.bias, "8.2f"),
            f"  {'':13s}{'std / bound':>21s}" + _row(score.scatter, "8.3f"),
            f"  {'':13s}{'95 % band covers':>21s}"
            + _row(100 * score.coverage, "8.1f")
            + f"   {1e3 * score.seconds:.0f} ms",
        ]
    return "\n".join(lines)


def _row(numbers: Theta, style: str) -> str:
    return "".join(format(number, style) for number in numbers)


def main(seeds: int = 1000) -> None:
    """Print the scores of the experiments of the acceptance figures."""
    at_rest = np.zeros(3)
    for experiment in (
        open_loop(SIMULATION_NOISE, at_rest),
        open_loop(SIMULATION_NOISE, at_rest, "zero"),
        open_loop(SIMULATION_NOISE, RELEASE_MOMENTUM_B),
        closed_loop(SIMULATION_NOISE, seeds),
        open_loop(FLIGHT_NOISE, at_rest),
        open_loop(FLIGHT_NOISE, RELEASE_MOMENTUM_B, walk=BIAS_WALK),
    ):
        print(report(experiment, seeds), flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
