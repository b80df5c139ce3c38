"""Closed-loop flights without records or estimates: which step they need, and a process that flies many.

`python -m benchmarks.flight_worker SCENARIO ENGINE STEP SEED...` flies the seeds for every line read (see
`paired.workers`).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import cast

import numpy as np

from testbed.arrays import Vectors3
from testbed.assembly.platform import PlatformModel, nominal_platform, true_plant
from testbed.campaign.plan import BLOCK_RUNS, COMPILED_BLOCK_RUNS
from testbed.experiment.flying import Sortie, prepare_flight
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.plant.plant import Engine
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.simulation.loop import Outcome, fly

CONTROL_PERIOD = 0.0125
STEPS = tuple(CONTROL_PERIOD / parts for parts in (1, 2, 3, 4, 5, 8, 10))
"""Integrator steps that divide the 80 Hz control period, s, the largest first."""
TOLERANCE = 1e-6
"""Of the body rate, rad/s."""
CHECKED_SEEDS = (0, 1)


def body_rate_errors(path: Path, engine: Engine) -> dict[float, float]:
    """Return how far each step's body rate is from that of a tenth of the step, rad/s; infinite where it diverges."""
    scenario = brisk(path)
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    return {step: _error(scenario, maneuver, engine, step) for step in STEPS}


def largest_step(errors: Mapping[float, float]) -> float:
    """Return the largest step that holds the tolerance together with every smaller one, s.

    Args:
        errors: of the body rate by step, rad/s.

    Raises:
        ValueError: even the smallest does not.
    """
    found = None
    for step in sorted(errors):
        if not errors[step] < TOLERANCE:
            break
        found = step
    if found is None:
        raise ValueError(f"no step among {sorted(errors)} s keeps the body rate within {TOLERANCE} rad/s")
    return found


def fly_seeds(
    scenario: Scenario, nominal: PlatformModel, maneuver: Maneuver, engine: Engine, seeds: list[int]
) -> list[Outcome]:
    """Fly the nominal platform once per seed, side by side in blocks as large as those of campaigns."""
    outcomes, block = [], COMPILED_BLOCK_RUNS if engine == "compiled" else BLOCK_RUNS
    for first in range(0, len(seeds), block):
        sorties = [Sortie(scenario=scenario, truth=nominal, seed=seed) for seed in seeds[first : first + block]]
        flight = prepare_flight(scenario, sorties, nominal, maneuver)
        outcomes += fly(true_plant([(scenario, nominal) for _ in sorties], engine=engine), flight)
    return outcomes


def brisk(path: Path) -> Scenario:
    """Return a scenario whose design stops at its first start: as brisk a motion, sooner found."""
    scenario = read_scenario(path)
    return scenario.model_copy(update={"maneuver": scenario.maneuver.model_copy(update={"starts": 1})})


def with_step(scenario: Scenario, step: float) -> Scenario:
    """Return the scenario with another integrator step, s."""
    return scenario.model_copy(update={"simulation": scenario.simulation.model_copy(update={"step_s": step})})


def _error(scenario: Scenario, maneuver: Maneuver, engine: Engine, step: float) -> float:
    coarse, fine = (_body_rates(with_step(scenario, size), maneuver, engine) for size in (step, step / 10))
    if any(len(rate) != len(converged) for rate, converged in zip(coarse, fine, strict=True)):
        return np.inf
    return max(float(np.abs(rate - converged).max()) for rate, converged in zip(coarse, fine, strict=True))


def _body_rates(scenario: Scenario, maneuver: Maneuver, engine: Engine) -> list[Vectors3]:
    platform = nominal_platform(scenario)
    rate = true_plant([(scenario, platform)]).layout.body_rate
    outcomes = fly_seeds(scenario, platform, maneuver, engine, list(CHECKED_SEEDS))
    return [outcome.log.qvel[:, rate] for outcome in outcomes]


def serve(path: Path, engine: Engine, step: float, seeds: list[int]) -> None:
    """Fly all seeds for every line that comes in."""
    scenario = with_step(brisk(path), step)
    nominal = nominal_platform(scenario)
    maneuver = plan_maneuver(scenario, nominal).maneuver
    print("ready", flush=True)
    for _ in sys.stdin:
        fly_seeds(scenario, nominal, maneuver, engine, seeds)
        print("done", flush=True)


if __name__ == "__main__":
    serve(Path(sys.argv[1]), cast("Engine", sys.argv[2]), float(sys.argv[3]), [int(seed) for seed in sys.argv[4:]])
