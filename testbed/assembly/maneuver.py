"""From a scenario's maneuver section to what the maneuver room takes."""

from __future__ import annotations

from math import inf

import numpy as np

from testbed.assembly.platform import PlatformModel, each_wheel, first_gimbal_angle, first_wheel_momentum
from testbed.maneuver.design import BodyRateLimits, DesignProblem, GimbalLimits
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.profiles import read_profile
from testbed.rotation.quaternion import matrix_of
from testbed.scenario.environment import AirBearing
from testbed.scenario.maneuver import ActuatorDesign, BodyRateDesign, CsvManeuver, Designed, GimbalDesign
from testbed.scenario.scenario import Scenario


def design_problem(scenario: Scenario, section: Designed, nominal: PlatformModel) -> DesignProblem:
    """Return what to design, for the nominal platform in the scenario's initial state."""
    target = section.target_std_kg_m2
    return DesignProblem(
        name=scenario.name,
        criterion=section.criterion,
        duration=section.duration_s,
        control_points=section.control_points,
        sample_rate=section.sample_rate_hz,
        prefilter_time_constant=section.prefilter_time_constant_s,
        inertia=nominal.inertia,
        cluster=nominal.cluster,
        initial_body_rate=np.array(scenario.initial.body_rate_rad_s),
        initial_gimbal_angle=first_gimbal_angle(scenario),
        wheels=nominal.wheels,
        initial_wheel_momentum=first_wheel_momentum(scenario),
        gimbal_rate_limit=scenario.gyros.gimbal_rate_limit,
        metric=section.metric,
        initial_up_B=matrix_of(np.array(scenario.initial.attitude_quat_NB))[2],
        target_std=None if target is None else np.array(target),
        parameters=section.parameters if isinstance(section, GimbalDesign) else "inertia",
    )


def profile_of(section: CsvManeuver, scenario: Scenario) -> Maneuver:
    """Return the maneuver of a table.

    Raises:
        InputError: the table cannot be used.
    """
    return read_profile(section.file, scenario.gyros.units, each_wheel(scenario, "spin_inertia_kg_m2"))


def body_rate_limits(scenario: Scenario, section: BodyRateDesign) -> BodyRateLimits:
    """Return the share of the cluster's limits that a body-rate design may use, eqs. (25), (26)."""
    share, environment = section.envelope_fraction, scenario.environment
    tilt = environment.tilt_limit_rad if isinstance(environment, AirBearing) else None
    return BodyRateLimits(
        cluster_torque=share * np.array(scenario.limits.cluster_torque_N_m),
        cluster_momentum=share * np.array(scenario.limits.cluster_momentum_N_m_s),
        body_rate=_or_unlimited(section.body_rate_limit_rad_s),
        tilt=inf if tilt is None else _TILT_SHARE * tilt,
    )


_TILT_SHARE = 0.97
"""Of what a bearing allows, left to a design: a tilt grows by less than a per cent between the instants at which it
looks, and the tracker leaves the reference by a few thousandths of a radian."""


def gimbal_limits(scenario: Scenario, section: GimbalDesign | ActuatorDesign) -> GimbalLimits:
    """Return what a design of gimbal angles and wheel momenta may use: shares of the actuators' own limits."""
    gyros = scenario.gyros
    return GimbalLimits(
        gimbal_rate=section.gimbal_rate_fraction * gyros.gimbal_rate_limit,
        gimbal_torque=gyros.gimbal_torque_limit,
        gimbal_acceleration=_or_unlimited(section.gimbal_acceleration_limit_rad_s2),
        cluster_torque=section.cluster_torque_fraction * np.array(scenario.limits.cluster_torque_N_m),
        cluster_momentum=np.array(scenario.limits.cluster_momentum_N_m_s),
        envelope_fraction=section.envelope_fraction,
        min_singularity_measure=section.min_singularity_measure,
        body_rate=_or_unlimited(section.body_rate_limit_rad_s),
        wheel_momentum_fraction=section.wheel_momentum_fraction if isinstance(section, ActuatorDesign) else 1.0,
        wheel_torque_fraction=section.wheel_torque_fraction if isinstance(section, ActuatorDesign) else 1.0,
        wheel_friction=each_wheel(scenario, "viscous_friction_N_m_s_rad"),
    )


def _or_unlimited(limit: float | None) -> float:
    return inf if limit is None else limit
