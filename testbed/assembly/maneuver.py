"""From a scenario's maneuver section to what the maneuver room takes."""

from __future__ import annotations

from math import inf

import numpy as np

from testbed.assembly.platform import PlatformModel, first_gimbal_angle
from testbed.maneuver.design import BodyRateLimits, DesignProblem, GimbalLimits
from testbed.scenario.maneuver import BodyRateDesign, GimbalDesign
from testbed.scenario.scenario import Scenario


def design_problem(scenario: Scenario, section: BodyRateDesign | GimbalDesign, nominal: PlatformModel) -> DesignProblem:
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
        metric=section.metric,
        target_std=None if target is None else np.array(target),
        parameters=section.parameters if isinstance(section, GimbalDesign) else "inertia",
    )


def body_rate_limits(scenario: Scenario, section: BodyRateDesign) -> BodyRateLimits:
    """Return the share of the cluster's limits that a body-rate design may use, eqs. (25), (26)."""
    share = section.envelope_fraction
    return BodyRateLimits(
        cluster_torque=share * np.array(scenario.limits.cluster_torque_N_m),
        cluster_momentum=share * np.array(scenario.limits.cluster_momentum_N_m_s),
        body_rate=_or_unlimited(section.body_rate_limit_rad_s),
    )


def gimbal_limits(scenario: Scenario, section: GimbalDesign) -> GimbalLimits:
    """Return what a gimbal-space design may use: shares of the gimbals' and of the cluster's own limits."""
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
    )


def _or_unlimited(limit: float | None) -> float:
    return inf if limit is None else limit
