"""From a scenario's maneuver section to the maneuver that is flown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.assembly.maneuver import body_rate_limits, design_problem, gimbal_limits
from testbed.assembly.platform import PlatformModel
from testbed.cmg.cluster import platform_momentum
from testbed.maneuver.body_rate_design import body_rate_design
from testbed.maneuver.design import Design, Search, Start
from testbed.maneuver.gimbal_design import gimbal_design
from testbed.maneuver.gimbal_maneuver import gimbal_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.penalty import Penalty
from testbed.maneuver.profiles import basic_profile, read_profile
from testbed.maneuver.splines import clamped_spline
from testbed.scenario.maneuver import (
    BasicManeuver,
    BodyRateDesign,
    BodyRatePoints,
    CsvManeuver,
    GimbalDesign,
    GimbalPoints,
)
from testbed.scenario.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A maneuver to fly.

    Attributes:
        maneuver: the reference.
        design: how it was found; None for a maneuver that was given.
    """

    maneuver: Maneuver
    design: Design | None = None


def starts_of(scenario: Scenario) -> int:
    """Return how many starts the scenario's design has; 0 where the maneuver is given."""
    section = scenario.maneuver
    return section.starts if isinstance(section, BodyRateDesign | GimbalDesign) else 0


def plan_maneuver(
    scenario: Scenario,
    nominal: PlatformModel,
    progress: Callable[[Start], None] = lambda _: None,
    seed: int | None = None,
) -> Plan:
    """Design, build or read the maneuver of a scenario.

    Args:
        scenario: what to fly.
        nominal: the platform to design for.
        progress: called with each start of a design as it ends.
        seed: of the starts; the maneuver section's own where None.

    Raises:
        InputError: a file cannot be read, or the limits cannot be met.
    """
    match scenario.maneuver:
        case BodyRateDesign() | GimbalDesign() as section:
            design = _design(scenario, section, nominal, _search(section, progress, seed))
            return Plan(maneuver=design.maneuver, design=design)
        case BasicManeuver() as section:
            return Plan(maneuver=basic_profile(duration=section.duration_s, scale=section.scale))
        case CsvManeuver() as section:
            return Plan(maneuver=read_profile(section.file, scenario.gyros.units))
        case BodyRatePoints() as section:
            spline = clamped_spline(section.duration_s, np.array(section.body_rate_rad_s))
            return Plan(maneuver=Maneuver(name=scenario.name, duration=section.duration_s, body_rate=spline))
        case GimbalPoints() as section:
            return Plan(maneuver=_gimbal_points(scenario, section, nominal))


def design_seed(scenario: Scenario, seed: int | None) -> int | None:
    """Return the seed of a design's starts: the given one, or else that of the maneuver section, if it has one."""
    section = scenario.maneuver
    return section.seed if seed is None and isinstance(section, BodyRateDesign | GimbalDesign) else seed


def _search(section: BodyRateDesign | GimbalDesign, progress: Callable[[Start], None], seed: int | None) -> Search:
    return Search(starts=section.starts, seed=section.seed if seed is None else seed, progress=progress)


def _design(
    scenario: Scenario, section: BodyRateDesign | GimbalDesign, nominal: PlatformModel, search: Search
) -> Design:
    problem = design_problem(scenario, section, nominal)
    if isinstance(section, GimbalDesign):
        return gimbal_design(problem, gimbal_limits(scenario, section), search)
    penalty = Penalty() if section.constraint == "penalty" else None
    initial = basic_profile(duration=section.duration_s) if section.start_from == "basic" else None
    return body_rate_design(problem, body_rate_limits(scenario, section), search, penalty, initial)


def _gimbal_points(scenario: Scenario, section: GimbalPoints, nominal: PlatformModel) -> Maneuver:
    """Fly given gimbal angles from the scenario's initial body rate."""
    angle, rate = np.array(section.gimbal_angle_rad), np.array(scenario.initial.body_rate_rad_s)
    return gimbal_maneuver(
        scenario.name,
        clamped_spline(section.duration_s, angle),
        inertia=nominal.inertia,
        cluster=nominal.cluster,
        total_momentum_B=platform_momentum(nominal.cluster, nominal.inertia, rate, angle[0], np.zeros_like(angle[0])),
    )
