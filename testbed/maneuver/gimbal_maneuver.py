"""The exact body rate of a platform whose gimbals follow a spline, from conservation of momentum."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import BSpline, make_interp_spline

from testbed.arrays import Array, Matrices3, Matrix3, Series, Vector3, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change
from testbed.maneuver.maneuver import Maneuver

_STEP = 0.0025
"""s, between the exact values that the body-rate spline goes through; it strays from them by less than 1e-7 rad/s."""


def gimbal_maneuver(
    name: str, gimbal_angle: BSpline, *, inertia: Matrix3, cluster: Cluster, total_momentum_B: Vector3
) -> Maneuver:
    """Return the maneuver that a gimbal motion makes: ω = J(d)⁻¹ (Rᵀ H₀ - h(d, ḋ)).

    Args:
        name: of the maneuver.
        gimbal_angle: d(t), 6 components, rad, clamped on [0, duration].
        inertia: J with all gimbals at zero, kg·m², body axes.
        cluster: the units.
        total_momentum_B: H₀, shape (3,), N·m·s, in the body axes of the start.
    """
    duration = float(gimbal_angle.t[-1])
    time = np.linspace(0.0, duration, int(np.ceil(duration / _STEP)) + 1)
    rate = body_rate_of(gimbal_angle, time, inertia=inertia, cluster=cluster, total_momentum_B=total_momentum_B)
    return Maneuver(
        name=name, duration=duration, body_rate=make_interp_spline(time, rate, k=3), gimbal_angle=gimbal_angle
    )


def body_rate_of(
    gimbal_angle: BSpline, time: Series, *, inertia: Matrix3, cluster: Cluster, total_momentum_B: Vector3
) -> Vectors3:
    """Return ω at sorted times from 0, shape (N, 3), rad/s, body axes; arguments as in `gimbal_maneuver`."""
    inertia_at, momentum = _balance(gimbal_angle, time, inertia, cluster)

    def turn(now: float, total: Array) -> Array:
        inertia_now, momentum_now = _balance(gimbal_angle, np.array([now]), inertia, cluster)
        return -np.cross(np.linalg.solve(inertia_now[0], total - momentum_now[0]), total)  # L̇ = -ω × L

    solved = solve_ivp(turn, (0.0, time[-1]), total_momentum_B, method="DOP853", t_eval=time, rtol=1e-10, atol=1e-14)
    return np.linalg.solve(inertia_at, (solved.y.T - momentum)[..., None])[..., 0]


def _balance(gimbal_angle: BSpline, time: Series, inertia: Matrix3, cluster: Cluster) -> tuple[Matrices3, Vectors3]:
    """J(d), shape (N, 3, 3), and h(d, ḋ), shape (N, 3)."""
    angle, rate = gimbal_angle(time), gimbal_angle(time, nu=1)
    return inertia + inertia_change(cluster, angle), cluster_momentum(cluster, angle, rate)
