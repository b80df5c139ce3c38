"""From a scenario's maneuver section to the maneuver that is flown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Series
from testbed.assembly.control import reference_attitude, tilts_along
from testbed.assembly.maneuver import body_rate_limits, design_problem, gimbal_limits, profile_of
from testbed.assembly.platform import PlatformModel, initial_momentum
from testbed.cmg.wheels import wheel_envelope_share
from testbed.errors import InputError
from testbed.maneuver.body_rate_design import body_rate_design
from testbed.maneuver.design import Design, Search, Start
from testbed.maneuver.gimbal_design import gimbal_design
from testbed.maneuver.gimbal_maneuver import WheelMotion, gimbal_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.penalty import Penalty
from testbed.maneuver.profiles import basic_profile
from testbed.maneuver.splines import clamped_spline
from testbed.scenario.environment import AirBearing
from testbed.scenario.maneuver import (
    ActuatorDesign,
    ActuatorPoints,
    BasicManeuver,
    BodyRateDesign,
    BodyRatePoints,
    CsvManeuver,
    Designed,
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
    return section.starts if isinstance(section, Designed) else 0


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
        InputError: a file cannot be read, the limits cannot be met, or the maneuver tilts the platform beyond what its
            bearing allows.
    """
    plan = _planned(scenario, nominal, progress, seed)
    require_tilt(scenario, plan.maneuver)
    return plan


def require_flyable_by(scenario: Scenario, nominal: PlatformModel, maneuver: Maneuver) -> None:
    """Refuse a maneuver of another platform: of another number of units or wheels, or that tilts it too far.

    Args:
        scenario: that is to fly it.
        nominal: its platform.
        maneuver: planned for any platform.

    Raises:
        InputError: what does not fit.
    """
    wheels = len(nominal.wheels.axis_B)
    for words, spline, there in (
        ("gimbals", maneuver.gimbal_angle, nominal.units),
        ("wheels", maneuver.wheel_momentum, wheels),
    ):
        planned = there if spline is None else int(np.size(spline(0.0)))
        if planned != there:
            raise InputError(
                f"{scenario.name}: the maneuver {maneuver.name} moves {planned} {words}, the platform has {there}: "
                "design it for this scenario"
            )
    require_tilt(scenario, maneuver)


def beyond_envelope(scenario: Scenario, nominal: PlatformModel, maneuver: Maneuver) -> str:
    """Return in words that no allocation of momentum follows a maneuver; empty where one does, or wheels are not alone.

    The limits of a design of the body rate are those of each axis by itself; together they reach beyond what wheels
    can hold. On a bearing and on an orbit momentum is not conserved, and nothing is said.

    Args:
        scenario: that is to fly it.
        nominal: its platform.
        maneuver: planned for it.
    """
    if scenario.environment.kind != "free" or nominal.units or np.linalg.matrix_rank(nominal.wheels.axis_B) < 3:
        return ""
    time = _instants(maneuver)
    rate = maneuver.reference(time).body_rate
    attitude = reference_attitude(scenario, time, rate)
    total_N = attitude[0] @ initial_momentum(scenario, nominal)
    share = wheel_envelope_share(nominal.wheels, total_N @ attitude - rate @ nominal.turned_inertia)
    worst = int(np.argmax(share))
    if share[worst] <= 1.0:
        return ""
    return (
        f"the maneuver needs {100.0 * share[worst]:.0f} % of a wheel's momentum limit at {time[worst]:.3g} s, however "
        "momentum is shared among them, so that they cannot follow it: design it in actuator space "
        '(maneuver.parametrization = "actuator"), or lower limits.cluster_momentum_N_m_s'
    )


def require_tilt(scenario: Scenario, maneuver: Maneuver) -> None:
    """Refuse a maneuver whose reference tilts the platform beyond what its bearing allows.

    Raises:
        InputError: with the largest tilt, and when it is reached.
    """
    environment = scenario.environment
    if not isinstance(environment, AirBearing) or environment.tilt_limit_rad is None:
        return
    time = _instants(maneuver)
    tilt = tilts_along(scenario, maneuver, time)
    worst = int(np.argmax(tilt))
    if tilt[worst] > environment.tilt_limit_rad:
        raise InputError(
            f"{scenario.name}: the maneuver tilts the platform by {tilt[worst]:.3g} rad at {time[worst]:.3g} s, beyond "
            f"environment.tilt_limit_rad = {environment.tilt_limit_rad}: lower its rates about x and y, turn back "
            "earlier, or start more upright"
        )


_LOOKED_AT = 50.0
"""Hz. Between two instants a body of 1 rad/s turns by 0.02 rad, and a spline at its largest tilt by far less."""


def _instants(maneuver: Maneuver) -> Series:
    """Return when a maneuver is looked at, its ends included, shape (N,), s."""
    return np.linspace(0.0, maneuver.duration, max(2, round(maneuver.duration * _LOOKED_AT)))


def _planned(scenario: Scenario, nominal: PlatformModel, progress: Callable[[Start], None], seed: int | None) -> Plan:
    match scenario.maneuver:
        case BodyRateDesign() | GimbalDesign() | ActuatorDesign() as section:
            design = _design(scenario, section, nominal, _search(section, progress, seed))
            return Plan(maneuver=design.maneuver, design=design)
        case BasicManeuver() as section:
            return Plan(maneuver=basic_profile(duration=section.duration_s, scale=section.scale))
        case CsvManeuver() as section:
            return Plan(maneuver=profile_of(section, scenario))
        case BodyRatePoints() as section:
            spline = clamped_spline(section.duration_s, np.array(section.body_rate_rad_s))
            return Plan(maneuver=Maneuver(name=scenario.name, duration=section.duration_s, body_rate=spline))
        case GimbalPoints() | ActuatorPoints() as section:
            return Plan(maneuver=_actuator_points(scenario, section, nominal))


def design_seed(scenario: Scenario, seed: int | None) -> int | None:
    """Return the seed of a design's starts: the given one, or else that of the maneuver section, if it has one."""
    section = scenario.maneuver
    return section.seed if seed is None and isinstance(section, Designed) else seed


def _search(section: Designed, progress: Callable[[Start], None], seed: int | None) -> Search:
    return Search(starts=section.starts, seed=section.seed if seed is None else seed, progress=progress)


def _design(scenario: Scenario, section: Designed, nominal: PlatformModel, search: Search) -> Design:
    problem = design_problem(scenario, section, nominal)
    if not isinstance(section, BodyRateDesign):
        return gimbal_design(problem, gimbal_limits(scenario, section), search)
    penalty = Penalty() if section.constraint == "penalty" else None
    initial = basic_profile(duration=section.duration_s) if section.start_from == "basic" else None
    return body_rate_design(problem, body_rate_limits(scenario, section), search, penalty, initial)


def _actuator_points(scenario: Scenario, section: GimbalPoints | ActuatorPoints, nominal: PlatformModel) -> Maneuver:
    """Fly given gimbal angles and wheel momenta from the scenario's initial body rate."""
    if isinstance(section, GimbalPoints):
        rows, turning = section.gimbal_angle_rad, None
    else:
        rows = section.gimbal_angle_rad or ((),) * len(section.wheel_momentum_N_m_s)
        momenta = clamped_spline(section.duration_s, np.array(section.wheel_momentum_N_m_s))
        turning = WheelMotion(nominal.wheels, momenta)
    return gimbal_maneuver(
        scenario.name,
        clamped_spline(section.duration_s, np.array(rows)),
        inertia=nominal.inertia,
        cluster=nominal.cluster,
        total_momentum_B=initial_momentum(scenario, nominal),
        wheel_motion=turning,
    )
