"""Estimates of the gimbal-space design flown in MuJoCo's closed loop, over many seeds: bias, scatter, coverage.

Run with `python -m benchmarks.monte_carlo [SCENARIO] [SEEDS]`.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.flight import SCENARIOS
from testbed.arrays import Array, Theta
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.experiment.estimating import estimate_flight
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario

CORES = 2
NORMAL_95 = 1.96


class Flown(NamedTuple):
    """What one seed gave.

    Attributes:
        thetas: estimates by estimator, kg·m².
        stds: what they claim, kg·m².
        bound_std: of the motion as flown, kg·m².
        saturated: s.
    """

    thetas: dict[str, Theta]
    stds: dict[str, Theta]
    bound_std: Theta
    saturated: float


def main() -> None:
    """Fly all seeds and print the score of every estimator."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else SCENARIOS / "gimbal_d_optimal.toml"
    seeds = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
    scenario = read_scenario(path)
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    with ProcessPoolExecutor(CORES) as pool:
        flown = list(pool.map(partial(fly_seed, scenario, maneuver), range(seeds), chunksize=10))
    print(f"{scenario.name}: {seeds} closed-loop flights in MuJoCo; columns {', '.join(PARAMETER_NAMES)}")
    print_scores(flown, theta_of(true_platform(scenario).inertia))


def fly_seed(scenario: Scenario, maneuver: Maneuver, seed: int) -> Flown:
    """Fly one seed and run every estimator on it."""
    nominal, truth = nominal_platform(scenario), true_platform(scenario)
    run = fly_maneuver(scenario, nominal, truth, maneuver, seed)
    estimation = estimate_flight(scenario, nominal, truth, maneuver, run.record)
    assert estimation.bound_std is not None
    return Flown(
        thetas={name: estimate.theta for name, estimate in estimation.by_name.items()},
        stds={name: estimate.std for name, estimate in estimation.by_name.items()},
        bound_std=estimation.bound_std,
        saturated=run.summary.saturated,
    )


def print_scores(flown: list[Flown], true_theta: Theta) -> None:
    """Print bias in standard errors, scatter over the bound, and coverage of the 95 % bands."""
    bound = np.sqrt(np.mean([run.bound_std**2 for run in flown], axis=0))
    saturated = np.array([run.saturated for run in flown])
    print(f"  bound std, 1e-3 kg m2   {_row(1e3 * bound, 4)}")
    print(f"  saturated: mean {saturated.mean():.4f} s, in {np.mean(saturated > 0.05):.1%} of flights over 0.05 s")
    for name in flown[0].thetas:
        errors = np.array([run.thetas[name] for run in flown]) - true_theta
        claimed = np.array([run.stds[name] for run in flown])
        scatter = errors.std(axis=0, ddof=1)
        print(f"{name}")
        print(f"  mean error, 1e-3 kg m2  {_row(1e3 * errors.mean(axis=0), 4)}")
        print(f"  ... in standard errors  {_row(errors.mean(axis=0) / scatter * np.sqrt(len(flown)), 2)}")
        print(f"  scatter, 1e-3 kg m2     {_row(1e3 * scatter, 4)}")
        print(f"  scatter / bound         {_row(scatter / bound, 3)}")
        print(f"  95 % bands cover        {_row(np.mean(np.abs(errors) <= NORMAL_95 * claimed, axis=0), 3)}")


def _row(values: Array, digits: int) -> str:
    return "  ".join(f"{value:8.{digits}f}" for value in values)


if __name__ == "__main__":
    main()
