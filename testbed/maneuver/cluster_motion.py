"""The cluster's exact momentum balance at one instant, as CasADi functions.

The same equations as `testbed.cmg.cluster`, symbolic so that the optimiser gets exact derivatives; the tests hold the
two against each other. L = J(d) ω + h(d, ḋ) is the total momentum in body axes, and turns with L̇ = -ω × L.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from testbed.arrays import Matrix3, Units
from testbed.cmg.cluster import Cluster
from testbed.maneuver.envelope import envelope_share_function

MOTION_OUTPUTS = ("body_rate", "momentum", "momentum_rate", "envelope_share", "dexterity", "gimbal_torque")
"""What `motion_function` returns, in order."""


class _Frame(NamedTuple):
    """Axes of the units as columns, each of shape (3, M), body axes."""

    spin: ca.SX
    transverse: ca.SX
    gimbal: ca.DM


def body_rate_function(cluster: Cluster, inertia: Matrix3) -> ca.Function:
    """Return ω(d, ḋ, L) = J(d)⁻¹ (L - h(d, ḋ)), exact: with the gimbals' own momentum and share of J.

    Args:
        cluster: the units.
        inertia: J with all gimbals at zero, kg·m², body axes.
    """
    units = len(cluster.rotor_momentum)
    angle, rate, total = ca.SX.sym("angle", units), ca.SX.sym("rate", units), ca.SX.sym("total", 3)
    body_rate = _body_rate(cluster, inertia, _frame(cluster, angle), rate, total)
    return ca.Function("body_rate", [angle, rate, total], [body_rate])


def motion_function(cluster: Cluster, inertia: Matrix3) -> ca.Function:
    """Return the quantities that are limited, named in `MOTION_OUTPUTS`, as a function of (d, ḋ, d̈, L).

    body_rate ω; momentum h and its rate ḣ; envelope_share of h; dexterity det(A Aᵀ)/(Σ h²/3)³, the square of the
    singularity measure; gimbal_torque of each motor.

    Args:
        cluster: the units.
        inertia: J with all gimbals at zero, kg·m², body axes.
    """
    angle, rate, acceleration = (
        ca.SX.sym(name, len(cluster.rotor_momentum)) for name in ("angle", "rate", "acceleration")
    )
    total = ca.SX.sym("total", 3)
    frame = _frame(cluster, angle)
    body_rate = _body_rate(cluster, inertia, frame, rate, total)
    momentum, momentum_rate = _momentum(cluster, frame, rate), _momentum_rate(cluster, frame, rate, acceleration)
    # J(d) ω̇ = d/dt L - ḣ - dJ(d)/dt ω
    remainder = -ca.cross(body_rate, total) - momentum_rate - _inertia_rate(cluster, frame, rate) @ body_rate
    body_acceleration = ca.solve(_inertia(cluster, inertia, frame), remainder)
    torque = _gimbal_torque(cluster, frame, acceleration, body_rate, body_acceleration)
    share = envelope_share_function(cluster)(momentum)
    outputs = [body_rate, momentum, momentum_rate, share, _dexterity(cluster, frame), torque]
    return ca.Function("motion", [angle, rate, acceleration, total], outputs)


def _frame(cluster: Cluster, angle: ca.SX) -> _Frame:
    spin, transverse = ca.DM(cluster.spin_axis_B.T), ca.DM(cluster.transverse_axis_B.T)
    cos, sin = ca.diag(ca.cos(angle)), ca.diag(ca.sin(angle))
    return _Frame(
        spin=spin @ cos + transverse @ sin,
        transverse=transverse @ cos - spin @ sin,
        gimbal=ca.DM(cluster.gimbal_axis_B.T),
    )


def _body_rate(cluster: Cluster, inertia: Matrix3, frame: _Frame, rate: ca.SX, total: ca.SX) -> ca.SX:
    return ca.solve(_inertia(cluster, inertia, frame), total - _momentum(cluster, frame, rate))


def _momentum(cluster: Cluster, frame: _Frame, rate: ca.SX) -> ca.SX:
    """H = Σ (Js Ω s + (Jg + Jt) ḋ g)."""
    turning = ca.DM(cluster.gimbal_axis_inertia) * rate
    return frame.spin @ ca.DM(cluster.rotor_momentum) + frame.gimbal @ turning


def _momentum_rate(cluster: Cluster, frame: _Frame, rate: ca.SX, acceleration: ca.SX) -> ca.SX:
    """ḣ = A ḋ + Σ (Jg + Jt) d̈ g."""
    turning = ca.DM(cluster.gimbal_axis_inertia) * acceleration
    return frame.transverse @ (ca.DM(cluster.rotor_momentum) * rate) + frame.gimbal @ turning


def _inertia(cluster: Cluster, inertia: Matrix3, frame: _Frame) -> ca.SX:
    """J(d) = J + Σ (Js - Jt)(s sᵀ - s0 s0ᵀ)."""
    weight, home = np.diag(_asymmetry(cluster)), cluster.spin_axis_B.T
    return ca.DM(inertia - home @ weight @ home.T) + frame.spin @ ca.DM(weight) @ frame.spin.T


def _inertia_rate(cluster: Cluster, frame: _Frame, rate: ca.SX) -> ca.SX:
    """dJ(d)/dt = Σ (Js - Jt) ḋ (t sᵀ + s tᵀ)."""
    half = frame.transverse @ ca.diag(ca.DM(_asymmetry(cluster)) * rate) @ frame.spin.T
    return half + half.T


def _dexterity(cluster: Cluster, frame: _Frame) -> ca.SX:
    jacobian = frame.transverse @ ca.DM(np.diag(cluster.rotor_momentum))
    return ca.det(jacobian @ jacobian.T) / (np.sum(cluster.rotor_momentum**2) / 3.0) ** 3


def _gimbal_torque(
    cluster: Cluster, frame: _Frame, acceleration: ca.SX, body_rate: ca.SX, body_acceleration: ca.SX
) -> ca.SX:
    """(Jg + Jt)(d̈ + g·ω̇) - (Js Ω + (Js - Jt) s·ω)(t·ω): along g, what turns a unit; Jg is the same about all axes."""
    carried = ca.DM(cluster.rotor_momentum) + ca.DM(_asymmetry(cluster)) * (frame.spin.T @ body_rate)
    turned = ca.DM(cluster.gimbal_axis_inertia) * (acceleration + frame.gimbal.T @ body_acceleration)
    return turned - carried * (frame.transverse.T @ body_rate)


def _asymmetry(cluster: Cluster) -> Units:
    """Js - Jt of each rotor, shape (M,), kg·m²."""
    return cluster.rotor_spin_inertia - cluster.rotor_transverse_inertia
