"""Coverage of the inertia's 95 % intervals where actuators or gyro are not exactly as believed.

Each flight of a campaign draws its own actuators and gyro; the estimators believe the nominal ones, and are given the
spread that the flights are drawn with. Beside the coverage of the whole interval stands that of the gyro's noise alone.
Nothing here is fitted: a coverage could come out anywhere. Also: the nearest inertia of a body, for a flat plate, whose
inertia lies on the border of what a body can have, and for the platform itself.

Run with `python -m benchmarks.uncertainty [FLIGHTS] [SEED]`.
"""

from __future__ import annotations

import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from support.synthetic_telemetry import NOMINAL_THETA, TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.arrays import Array, Theta
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.campaign.plan import BLOCK_RUNS, run_seed
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.estimation.body import is_body, nearest_body
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.uncertainty import EXACT, USUAL, Uncertainty
from testbed.experiment.flying import Sortie, fly_sorties
from testbed.experiment.planning import plan_maneuver
from testbed.experiment.running_estimators import MeasuredFlight, estimate_flight
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario
from testbed.scenario.uncertainty import Uncertainty as Stated

CORES = 2
FLIGHTS, SEED = 500, 41
NORMAL_95 = 1.96
CASES = {
    "all as believed": EXACT,
    "each rotor 0.2 % off": Uncertainty(rotor_momentum=0.002),
    "each rotor 1 % off": Uncertainty(rotor_momentum=0.01),
    "gyro bias of 2e-3 rad/s": Uncertainty(gyro_bias=0.002),
    "encoder zeros 1 mrad off": Uncertainty(gimbal_zero=0.001),
    "gimbal axes 1 mrad off": Uncertainty(gimbal_misalignment=0.001),
    "all of it, as is usual": USUAL,
}
"""What is drawn anew for each flight."""
PLATE_THETA = np.array([0.020, 0.025, 0.045, 0.0, 0.0, 0.001])


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """Shares of flights whose 95 % interval holds the truth, by estimator, each of shape (6,)."""

    whole: dict[str, Array]
    noise: dict[str, Array]


def main() -> None:
    """Print the coverage of every case."""
    flights = int(sys.argv[1]) if len(sys.argv) > 1 else FLIGHTS
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else SEED
    began = time.perf_counter()
    scenario = read_scenario(shipped_scenario("zero_g"))
    scenario = _with(scenario, "estimation", initial_momentum="estimated")
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    print(
        f"zero_g.toml, {flights} closed-loop flights a case, campaign seed {seed}; 95 % intervals that hold the truth:"
    )
    print(f"{'':26}{'estimator':14}{'whole interval, least to most':34}{'noise alone, least to most'}")
    for name in CASES:
        found = coverage_of(name, scenario, maneuver, flights, seed)
        for estimator in found.whole:
            whole, noise = (_span(each[estimator]) for each in (found.whole, found.noise))
            print(f"{name:26}{estimator:14}{whole:34}{noise}", flush=True)
    _print_bodies(flights, seed)
    print(f"{time.perf_counter() - began:.0f} s")


def coverage_of(name: str, scenario: Scenario, maneuver: Maneuver, flights: int, seed: int) -> Coverage:
    """Fly a case and return how often the intervals hold the truth."""
    seeds = [run_seed(seed, run) for run in range(flights)]
    blocks = [seeds[first : first + BLOCK_RUNS] for first in range(0, flights, BLOCK_RUNS)]
    with ProcessPoolExecutor(CORES, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(_hits, name, scenario, maneuver, block) for block in blocks]
        hits = [each for future in futures for each in future.result()]
    estimators = hits[0].keys()
    whole, noise = ({key: np.mean([each[key][part] for each in hits], axis=0) for key in estimators} for part in (0, 1))
    return Coverage(whole=whole, noise=noise)


def _hits(name: str, scenario: Scenario, maneuver: Maneuver, seeds: list[int]) -> list[dict[str, tuple[Array, Array]]]:
    """Return of each flight which intervals hold the truth: the whole ones, and those by noise alone."""
    believed, nominal = _believing(scenario, CASES[name]), nominal_platform(scenario)
    drawn = [_drawn(believed, CASES[name], seed) for seed in seeds]
    sorties = [
        Sortie(scenario=each, truth=true_platform(each), seed=seed) for each, seed in zip(drawn, seeds, strict=True)
    ]
    found = []
    for sortie, flown in zip(sorties, fly_sorties(scenario, sorties, nominal, maneuver), strict=True):
        measured = MeasuredFlight(believed, sortie.truth, flown.record)
        estimates = estimate_flight(measured, nominal, maneuver, checked=False).by_name
        true = theta_of(sortie.truth.inertia)
        found.append(
            {
                key: (_holds(each.theta, each.std, true), _holds(each.theta, each.noise_std, true))
                for key, each in estimates.items()
            }
        )
    return found


def _believing(scenario: Scenario, std: Uncertainty) -> Scenario:
    """Return the scenario whose estimators know how uncertain actuators and gyro are."""
    stated = Stated(
        rotor_momentum_relative=std.rotor_momentum,
        gimbal_zero_rad=std.gimbal_zero,
        gimbal_axis_misalignment_rad=std.gimbal_misalignment,
        gyro_bias_rad_s=std.gyro_bias,
        gyro_scale_factor=std.gyro_scale,
        gyro_misalignment_rad=std.gyro_misalignment,
    )
    return _with(scenario, "estimation", uncertainty=stated)


def _drawn(scenario: Scenario, std: Uncertainty, seed: int) -> Scenario:
    """Return the scenario with the actuators and the gyro of one flight."""
    rng = np.random.default_rng([seed % 2**32, 7])
    momentum, zero, axes = rng.standard_normal(6), rng.standard_normal(6), rng.standard_normal((6, 2))
    bias, scale, turns, oblique = rng.standard_normal((4, 3))
    # An angle of each axis towards each other one: a turn about the third axis, and what makes the two oblique.
    turns, oblique = std.gyro_misalignment * turns / np.sqrt(2.0), std.gyro_misalignment * oblique / np.sqrt(2.0)
    scenario = _with(scenario, "tachometer", scale_factor_error=tuple(std.rotor_momentum * momentum))
    scenario = _with(scenario, "encoder", zero_rad=tuple(std.gimbal_zero * zero))
    if std.gimbal_misalignment:
        turned = tuple(map(tuple, std.gimbal_misalignment * axes))
        scenario = _with(scenario, "truth", gimbal_axis_misalignment_rad=turned)
    return _with(
        scenario,
        "gyro",
        bias_rad_s=tuple(std.gyro_bias * bias),
        scale_factor_error=tuple(std.gyro_scale * scale),
        misalignment_rad=tuple(turns),
        cross_axis_rad=tuple(oblique),
    )


def _with(scenario: Scenario, section: str, **changes: object) -> Scenario:
    return scenario.model_copy(update={section: getattr(scenario, section).model_copy(update=changes)})


def _holds(theta: Theta, std: Theta, true: Theta) -> Array:
    return np.abs(theta - true) < NORMAL_95 * std


def _print_bodies(flights: int, seed: int) -> None:
    """Print the coverage of the nearest body's inertia, ± what the unconstrained estimate states."""
    times = sample_times(16.0)
    for name, true in (("a flat plate", PLATE_THETA), ("the platform", TRUE_THETA)):
        exact = exact_telemetry(replace(nominal_flight(), theta=true), times, times, 0.025)
        settings = EstimationSettings(nominal_theta=true * NOMINAL_THETA[0] / TRUE_THETA[0])
        hits, moved = [], 0
        for index in range(flights):
            noise = 0.025 * np.random.default_rng([seed, index]).standard_normal(exact.body_rate.shape)
            estimate = ESTIMATORS["output_error"](replace(exact, body_rate=exact.body_rate + noise), settings)
            moved += not is_body(estimate.theta)
            hits.append(_holds(nearest_body(estimate.theta, estimate.covariance), estimate.std, true))
        shares = ", ".join(
            f"{parameter} {share:.1%}" for parameter, share in zip(PARAMETER_NAMES, np.mean(hits, axis=0), strict=True)
        )
        print(f"nearest body of {name}: moved in {moved / flights:.0%} of {flights}; held by 95 % intervals: {shares}")


def _span(shares: Array) -> str:
    return f"{shares.min():.1%} to {shares.max():.1%}, mean {shares.mean():.1%}"


if __name__ == "__main__":
    main()
