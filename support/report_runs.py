"""Real runs for the tests of the pages: a short zero-g flight of given gimbal angles, one that diverges, a design."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from testbed.experiment.conduct import conduct
from testbed.experiment.experiment import Experiment
from testbed.maneuver.design import Design, Start
from testbed.maneuver.information import maneuver_information
from testbed.scenario.maneuver import GimbalPoints
from testbed.scenario.platform import Initial
from testbed.scenario.reader import read_scenario

SCENARIO = Path(__file__).parents[1] / "scenarios" / "zero_g.toml"
PROVENANCE = {"command": "testbed run zero_g.toml", "seed": "4", "scenario.toml": SCENARIO.read_text(encoding="utf-8")}


@cache
def flight(amplitude: float = 0.4, duration: float = 2.5) -> Experiment:
    """A flight whose gimbals swing by so many rad; 0.4 keeps every limit, 1.2 asks for too large gimbal rates."""
    scenario = read_scenario(SCENARIO)
    points = np.zeros((12, 6))
    points[2:-2] = amplitude * np.random.default_rng(8).uniform(-1.0, 1.0, (8, 6))
    maneuver = GimbalPoints(
        kind="control_points",
        duration_s=duration,
        parametrization="gimbal",
        gimbal_angle_rad=tuple(map(tuple, points.tolist())),
    )
    simulation = scenario.simulation.model_copy(update={"duration_s": duration})
    return conduct(scenario.model_copy(update={"maneuver": maneuver, "simulation": simulation}), 4)


@cache
def diverged_flight(spin: float = 1.0) -> Experiment:
    """A flight released at a spin that its step cannot follow: it lasts for one row, at spin 0.36 for four."""
    start = Initial(body_rate_rad_s=(2000.0 * spin, 1300.0 * spin, 600.0 * spin))
    return conduct(flight().scenario.model_copy(update={"initial": start}), 4)


def designed(experiment: Experiment) -> Experiment:
    """The same run, its maneuver the best of three starts, one of which broke a limit."""
    maneuver = experiment.plan.maneuver
    outcomes = ((-1.25, "Solve_Succeeded"), (np.inf, "Infeasible_Problem_Detected"), (-2.5, "Solve_Succeeded"))
    design = Design(
        maneuver=maneuver,
        criterion="D",
        parametrization="gimbal",
        information=maneuver_information(maneuver, 16.0, 0.8),
        starts=tuple(
            Start(index=index, cost=cost, seconds=1.0 + index, status=status)
            for index, (cost, status) in enumerate(outcomes)
        ),
        best=2,
        setup_seconds=0.5,
    )
    return replace(experiment, plan=replace(experiment.plan, design=design))
