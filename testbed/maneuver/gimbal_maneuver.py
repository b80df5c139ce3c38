"""The exact body rate of a platform whose gimbals and wheels follow splines, from conservation of momentum."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from scipy.interpolate import BSpline, make_interp_spline

from testbed.arrays import Array, Matrices3, Matrix3, Series, Vector3, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change
from testbed.cmg.wheels import Wheels, wheel_momentum
from testbed.maneuver.maneuver import Maneuver

_STEP = 0.0025
"""s, between the exact values that the body-rate spline goes through; it strays from them by less than 1e-7 rad/s."""


class WheelMotion(NamedTuple):
    """How W wheels turn.

    Attributes:
        wheels: the array.
        momentum: Jw Ω(t), W components, N·m·s, clamped on [0, duration].
    """

    wheels: Wheels
    momentum: BSpline


def gimbal_maneuver(
    name: str,
    gimbal_angle: BSpline,
    *,
    inertia: Matrix3,
    cluster: Cluster,
    total_momentum_B: Vector3,
    wheel_motion: WheelMotion | None = None,
) -> Maneuver:
    """Return the maneuver that a motion of gimbals and wheels makes: ω = J(d)⁻¹ (Rᵀ H₀ - h(d, ḋ)).

    Args:
        name: of the maneuver.
        gimbal_angle: d(t), M components, rad, clamped on [0, duration].
        inertia: J with all gimbals at zero, kg·m², body axes.
        cluster: the units.
        total_momentum_B: H₀, shape (3,), N·m·s, in the body axes of the start.
        wheel_motion: of the wheels; None of a platform without any.
    """
    duration = float(gimbal_angle.t[-1])
    time = np.linspace(0.0, duration, int(np.ceil(duration / _STEP)) + 1)
    rate = body_rate_of(
        gimbal_angle,
        time,
        inertia=inertia,
        cluster=cluster,
        total_momentum_B=total_momentum_B,
        wheel_motion=wheel_motion,
    )
    return Maneuver(
        name=name,
        duration=duration,
        body_rate=make_interp_spline(time, rate, k=3),
        gimbal_angle=gimbal_angle if len(cluster.rotor_momentum) else None,
        wheel_momentum=None if wheel_motion is None else wheel_motion.momentum,
    )


def body_rate_of(
    gimbal_angle: BSpline,
    time: Series,
    *,
    inertia: Matrix3,
    cluster: Cluster,
    total_momentum_B: Vector3,
    wheel_motion: WheelMotion | None = None,
) -> Vectors3:
    """Return ω at sorted times from 0, shape (N, 3), rad/s, body axes; arguments as in `gimbal_maneuver`."""
    motions = (gimbal_angle, inertia, cluster, wheel_motion)
    inertia_at, momentum = _balance(time, *motions)

    def turn(now: float, total: Array) -> Array:
        inertia_now, momentum_now = _balance(np.array([now]), *motions)
        return -np.cross(np.linalg.solve(inertia_now[0], total - momentum_now[0]), total)  # L̇ = -ω × L

    solved = scipy.integrate.solve_ivp(
        turn, (0.0, time[-1]), total_momentum_B, method="DOP853", t_eval=time, rtol=1e-10, atol=1e-14
    )
    return np.linalg.solve(inertia_at, (solved.y.T - momentum)[..., None])[..., 0]


def _balance(
    time: Series, gimbal_angle: BSpline, inertia: Matrix3, cluster: Cluster, wheel_motion: WheelMotion | None
) -> tuple[Matrices3, Vectors3]:
    """J(d), shape (N, 3, 3), and h of gyros and wheels, shape (N, 3)."""
    angle, rate = gimbal_angle(time), gimbal_angle(time, nu=1)
    inertia_at, momentum = inertia + inertia_change(cluster, angle), cluster_momentum(cluster, angle, rate)
    if wheel_motion is None:
        return inertia_at, momentum
    return inertia_at, momentum + wheel_momentum(wheel_motion.wheels, wheel_motion.momentum(time))
