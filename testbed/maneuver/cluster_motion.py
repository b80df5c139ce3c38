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

MOTION_OUTPUTS = ("body_rate", "momentum", "momentum_rate", "dexterity", "gimbal_torque")
"""What `motion_function` returns, in order."""


class _Frame(NamedTuple):
    """Axes of the units as columns, each of shape (3, 6), body axes."""

    spin: ca.SX
    transverse: ca.SX
    gimbal: ca.DM


def body_rate_function(cluster: Cluster, inertia: Matrix3) -> ca.Function:
    """Return ω(d, ḋ, L) = J(d)⁻¹ (L - h(d, ḋ)), exact (trap 8b).

    Args:
        cluster: the units.
        inertia: J with all gimbals at zero, kg·m², body axes.
    """
    angle, rate, total = ca.SX.sym("angle", 6), ca.SX.sym("rate", 6), ca.SX.sym("total", 3)
    return ca.Function("body_rate", [angle, rate, total], [_body_rate(cluster, inertia, angle, rate, total)])


def motion_function(cluster: Cluster, inertia: Matrix3) -> ca.Function:
    """Return the quantities that are limited, named in `MOTION_OUTPUTS`, as a function of (d, ḋ, d̈, L).

    body_rate ω; momentum h; momentum_rate ḣ = A ḋ + Σ (Jg + Jt) d̈ g; dexterity det(A Aᵀ)/(Σ h²/3)³, the square of the
    singularity measure; gimbal_torque (Jg + Jt)(d̈ + g·ω̇) - (h + (Js - Jt) s·ω)(t·ω) of each motor.

    Args:
        cluster: the units.
        inertia: J with all gimbals at zero, kg·m², body axes.
    """
    angle, rate, acceleration = ca.SX.sym("angle", 6), ca.SX.sym("rate", 6), ca.SX.sym("acceleration", 6)
    total = ca.SX.sym("total", 3)
    frame = _frame(cluster, angle)
    body_rate = _body_rate(cluster, inertia, angle, rate, total)
    momentum_rate = frame.transverse @ (ca.DM(cluster.rotor_momentum) * rate) + _gimbal_part(
        cluster, frame, acceleration
    )
    # d/dt (J(d) ω + h) = -ω × L
    balance = -ca.cross(body_rate, total) - momentum_rate - _inertia_rate(cluster, frame, rate) @ body_rate
    body_acceleration = ca.solve(_inertia(cluster, inertia, frame), balance)
    outputs = [
        body_rate,
        _momentum(cluster, frame, rate),
        momentum_rate,
        _dexterity(cluster, frame),
        _gimbal_torque(cluster, frame, acceleration, body_rate, body_acceleration),
    ]
    inputs = [angle, rate, acceleration, total]
    return ca.Function("motion", inputs, outputs, ["d", "d_dot", "d_ddot", "total"], list(MOTION_OUTPUTS))


def _frame(cluster: Cluster, angle: ca.SX) -> _Frame:
    spin, transverse = ca.DM(cluster.spin_axis_B.T), ca.DM(cluster.transverse_axis_B.T)
    cos, sin = ca.diag(ca.cos(angle)), ca.diag(ca.sin(angle))
    return _Frame(
        spin=spin @ cos + transverse @ sin,
        transverse=transverse @ cos - spin @ sin,
        gimbal=ca.DM(cluster.gimbal_axis_B.T),
    )


def _body_rate(cluster: Cluster, inertia: Matrix3, angle: ca.SX, rate: ca.SX, total: ca.SX) -> ca.SX:
    frame = _frame(cluster, angle)
    return ca.solve(_inertia(cluster, inertia, frame), total - _momentum(cluster, frame, rate))


def _momentum(cluster: Cluster, frame: _Frame, rate: ca.SX) -> ca.SX:
    return frame.spin @ ca.DM(cluster.rotor_momentum) + _gimbal_part(cluster, frame, rate)


def _gimbal_part(cluster: Cluster, frame: _Frame, rate: ca.SX) -> ca.SX:
    """Σ (Jg + Jt) ḋ g, or its derivative where it is given d̈."""
    return frame.gimbal @ (ca.DM(cluster.gimbal_axis_inertia) * rate)


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
    """Component along g of the rate of change of a unit's angular momentum; Jg is the same about all axes."""
    carried = ca.DM(cluster.rotor_momentum) + ca.DM(_asymmetry(cluster)) * (frame.spin.T @ body_rate)
    turned = ca.DM(cluster.gimbal_axis_inertia) * (acceleration + frame.gimbal.T @ body_acceleration)
    return turned - carried * (frame.transverse.T @ body_rate)


def _asymmetry(cluster: Cluster) -> Units:
    """Js - Jt of each rotor, shape (6,), kg·m²."""
    return cluster.rotor_spin_inertia - cluster.rotor_transverse_inertia
