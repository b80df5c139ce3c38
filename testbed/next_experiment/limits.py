"""How much of the cluster's limits a path of the gimbals takes, for many paths at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Matrix3
from testbed.assembly.maneuver import gimbal_limits, profile_of
from testbed.assembly.platform import PlatformModel
from testbed.cmg.cluster import Cluster, cluster_momentum, momentum_jacobian
from testbed.cmg.singularity import envelope_fraction, singularity_measure, sphere_directions
from testbed.maneuver.design import GimbalLimits
from testbed.maneuver.splines import basis_matrix, derivative_points_matrix
from testbed.scenario.maneuver import CsvManeuver, GimbalDesign
from testbed.scenario.scenario import Scenario

CONTROL_POINTS = 24
"""Of a flight's spline: 1.9 Hz at most in 5 s, above which the acceleration limit leaves no momentum to see."""
_CHECKS = 60
"""Instants at which what is not linear in the control points is kept, as many as the designer checks in 5 s."""
_DIRECTIONS = sphere_directions(100)
"""Unit vectors on which the momentum envelope is taken, 0.35 rad apart: of 4,000 random angles the envelope's share is
up to 0.02 less than with 5,000 vectors, for which the share of a design has room."""
_USUAL_SHARE = 0.8
"""Of envelope and gimbal rate, left to a path where the scenario designs none: those of the shipped
diagnose.toml and zero_g.toml; the rest is for what the nominal model gets wrong."""
_USUAL_ACCELERATION = 10.0
"""rad/s² of a gimbal, as in the same designs: with it, gimbal_d_optimal.toml saturates in none of 250 seeds."""
_USUAL_MEASURE = 0.3
"""Singularity measure at least, as in the same designs: below, gimbal rates grow faster than the torque that they
give."""
_GYRO_RATE = 16.0
"""Hz: the gyro of the paper. Only the designer's criterion would use it, which is not asked for here."""
_PREFILTER = 0.8
"""s: the prefilter of the paper, likewise of the designer's criterion alone."""


@dataclass(frozen=True, kw_only=True)
class DesignLimits:
    """What a flight may take.

    Attributes:
        limits: margins taken off.
        cluster: the units; one whose rotor carries no momentum has failed and stays where it is.
        inertia: J, kg·m², body axes.
        duration: s.
    """

    limits: GimbalLimits
    cluster: Cluster
    inertia: Matrix3
    duration: float


def design_limits_of(scenario: Scenario, nominal: PlatformModel) -> DesignLimits:
    """Return the shares of the limits that the scenario's own gimbal design may use, or the designer's usual ones."""
    own, duration = scenario.maneuver, _duration(scenario)
    section = own if isinstance(own, GimbalDesign) else _usual(duration)
    limits = gimbal_limits(scenario, section)
    return DesignLimits(limits=limits, cluster=nominal.cluster, inertia=nominal.inertia, duration=duration)


def _duration(scenario: Scenario) -> float:
    """Return how long a flight of the scenario lasts, s."""
    if scenario.simulation.duration_s is not None:
        return scenario.simulation.duration_s
    own = scenario.maneuver
    return profile_of(own, scenario).duration if isinstance(own, CsvManeuver) else own.duration_s


def limit_shares(design_limits: DesignLimits, body_rate: Array, points: Array) -> Array:
    """Return shares of limits, each at most 1 where a path keeps them, shape (F, K).

    Gimbal rate and acceleration by the convex hull; envelope, momentum, torque and singularity measure at instants;
    body rate and gimbal torque by bounds that hold whatever way the total momentum turns.

    Args:
        design_limits: the limits.
        body_rate: at release, shape (F, 3), rad/s.
        points: control points of the gimbal angles, shape (F, n, 6), rad.
    """
    limits, cluster, count = design_limits.limits, design_limits.cluster, points.shape[1]
    rate, acceleration = (derivative_points_matrix(design_limits.duration, count, order) @ points for order in (1, 2))
    time = np.linspace(0.0, design_limits.duration, _CHECKS + 1)
    angle, turning = (basis_matrix(design_limits.duration, count, time, order) @ points for order in (0, 1))
    momentum = cluster_momentum(cluster, angle, turning)
    jacobian = momentum_jacobian(cluster, angle)
    torque = np.matvec(jacobian, turning)
    dexterity = singularity_measure(jacobian, cluster.rotor_momentum)
    fastest, motor = _bounds(design_limits, body_rate, momentum, np.abs(acceleration).max(axis=(1, 2)))
    shares = (
        np.abs(rate) / limits.gimbal_rate,
        np.abs(acceleration) / limits.gimbal_acceleration,
        np.abs(momentum) / limits.cluster_momentum,
        np.abs(torque) / limits.cluster_torque,
        envelope_fraction(cluster, momentum, _DIRECTIONS) / limits.envelope_fraction,
        1.0 + limits.min_singularity_measure - dexterity,
        fastest / limits.body_rate,
        motor / limits.gimbal_torque,
    )
    return np.concatenate([share.reshape(len(points), -1) for share in shares], axis=1)


def _bounds(design_limits: DesignLimits, body_rate: Array, momentum: Array, acceleration: Array) -> tuple[Array, Array]:
    """Return the fastest body rate, rad/s, and the largest gimbal torque, N·m, that there can be, shapes (F,).

    ω = J⁻¹ (L - h), and L keeps its length.
    """
    total = np.linalg.norm(body_rate @ design_limits.inertia + momentum[:, 0], axis=-1)
    held = np.linalg.norm(momentum, axis=-1).max(axis=1)
    fastest = (total + held) / np.linalg.eigvalsh(design_limits.inertia)[0]
    cluster = design_limits.cluster
    motor = cluster.gimbal_axis_inertia.max() * acceleration + np.abs(cluster.rotor_momentum).max() * fastest
    return fastest, motor


def _usual(duration: float) -> GimbalDesign:
    """Return what the shipped scenarios' gimbal designs leave to the tracker."""
    return GimbalDesign(
        kind="design",
        parametrization="gimbal",
        criterion="D",
        duration_s=duration,
        control_points=CONTROL_POINTS,
        starts=1,
        seed=1,
        sample_rate_hz=_GYRO_RATE,
        prefilter_time_constant_s=_PREFILTER,
        envelope_fraction=_USUAL_SHARE,
        gimbal_rate_fraction=_USUAL_SHARE,
        gimbal_acceleration_limit_rad_s2=_USUAL_ACCELERATION,
        min_singularity_measure=_USUAL_MEASURE,
    )
