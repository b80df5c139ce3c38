"""The exact momentum balance of gyros and wheels at one instant, as CasADi functions.

The same equations as `testbed.cmg.cluster`, symbolic so that the optimiser gets exact derivatives; the tests hold the
two against each other. L = J(d) ω + h(d, ḋ) is the total momentum in body axes, and turns with L̇ = -ω × L.

The actuators' motion is q = (d, x): the angles of M gimbals, rad, then the momenta of W wheels in shares of their
limits, so that all entries are of one size.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from testbed.arrays import Matrix3, Units
from testbed.cmg.actuators import Actuators
from testbed.cmg.cluster import Cluster
from testbed.cmg.wheels import Wheels
from testbed.maneuver.envelope import envelope_share_function

MOTION_OUTPUTS = (
    "body_rate",
    "momentum",
    "momentum_rate",
    "envelope_share",
    "dexterity",
    "gimbal_torque",
    "wheel_torque",
    "excess",
)
"""What `motion_function` returns, in order."""


class _Frame(NamedTuple):
    """Axes of the units as columns, each of shape (3, M), body axes."""

    spin: ca.SX
    transverse: ca.SX
    gimbal: ca.DM


def body_rate_function(actuators: Actuators, inertia: Matrix3) -> ca.Function:
    """Return ω(q, q̇, L) = J(d)⁻¹ (L - h(q, q̇)), exact: with the gimbals' own momentum and share of J.

    Args:
        actuators: gyros and wheels.
        inertia: J with all gimbals at zero, kg·m², body axes.
    """
    cluster, wheels, count = actuators.cluster, actuators.wheels, actuators.count
    motion, rate, total = ca.SX.sym("motion", count), ca.SX.sym("rate", count), ca.SX.sym("total", 3)
    frame = _frame(cluster, motion)
    held = _momentum(cluster, frame, rate) + _of_wheels(cluster, wheels, motion)
    return ca.Function("body_rate", [motion, rate, total], [_body_rate(cluster, inertia, frame, held, total)])


def motion_function(actuators: Actuators, inertia: Matrix3, friction: Units) -> ca.Function:
    """Return the quantities that are limited, named in `MOTION_OUTPUTS`, as a function of (q, q̇, q̈, L).

    body_rate ω; momentum h and its rate ḣ of all actuators; envelope_share of the gyros' h; dexterity of all actuators,
    det(A Aᵀ)/(Σ h²/3)³, the square of the singularity measure; gimbal_torque of each motor, N·m, and wheel_torque in
    shares of its limit; excess h - L of the actuators' momentum over the total, none where the platform rests.

    Args:
        actuators: gyros and wheels.
        inertia: J with all gimbals at zero, kg·m², body axes.
        friction: of each wheel's bearing, shape (W,), N·m·s/rad.
    """
    cluster, wheels, units, count = actuators.cluster, actuators.wheels, actuators.units, actuators.count
    motion, rate, acceleration = (ca.SX.sym(name, count) for name in ("motion", "rate", "acceleration"))
    total = ca.SX.sym("total", 3)
    frame = _frame(cluster, motion)
    of_units = _momentum(cluster, frame, rate)
    momentum = of_units + _of_wheels(cluster, wheels, motion)
    momentum_rate = _momentum_rate(cluster, frame, rate, acceleration) + _of_wheels(cluster, wheels, rate)
    body_rate = _body_rate(cluster, inertia, frame, momentum, total)
    # J(d) ω̇ = d/dt L - ḣ - dJ(d)/dt ω
    remainder = -ca.cross(body_rate, total) - momentum_rate - _inertia_rate(cluster, frame, rate) @ body_rate
    body_acceleration = ca.solve(_inertia(cluster, inertia, frame), remainder)
    torque = _gimbal_torque(cluster, frame, acceleration, body_rate, body_acceleration)
    wheel_torque = _wheel_torque(wheels, motion[units:], rate[units:], body_acceleration, friction)
    share = envelope_share_function(cluster)(of_units) if has_envelope(actuators) else ca.SX(0.0)
    outputs = [body_rate, momentum, momentum_rate, share, _dexterity(actuators, frame), torque, wheel_torque]
    outputs.append(momentum - total)
    return ca.Function("motion", [motion, rate, acceleration, total], outputs)


def has_envelope(actuators: Actuators) -> bool:
    """Return whether there is an envelope to keep a margin to: the momentum of a single gyro is always on its own."""
    return actuators.units > 1


def _frame(cluster: Cluster, motion: ca.SX) -> _Frame:
    angle = _gimbals(cluster, motion)
    spin, transverse = ca.DM(cluster.spin_axis_B.T), ca.DM(cluster.transverse_axis_B.T)
    cos, sin = ca.diag(ca.cos(angle)), ca.diag(ca.sin(angle))
    return _Frame(
        spin=spin @ cos + transverse @ sin,
        transverse=transverse @ cos - spin @ sin,
        gimbal=ca.DM(cluster.gimbal_axis_B.T),
    )


def _body_rate(cluster: Cluster, inertia: Matrix3, frame: _Frame, held: ca.SX, total: ca.SX) -> ca.SX:
    return ca.solve(_inertia(cluster, inertia, frame), total - held)


def _of_wheels(cluster: Cluster, wheels: Wheels, motion: ca.SX) -> ca.SX:
    """Σ limit x a, or its rate of that of x."""
    return ca.DM((wheels.axis_B * wheels.momentum_limit[:, None]).T) @ motion[len(cluster.rotor_momentum) :]


def _wheel_torque(wheels: Wheels, share: ca.SX, rate: ca.SX, body_acceleration: ca.SX, friction: Units) -> ca.SX:
    """Jw (Ω̇ + a·ω̇) + c Ω, of each motor in shares of its limit."""
    along = ca.DM(wheels.spin_inertia) * (ca.DM(wheels.axis_B) @ body_acceleration)
    slowed = ca.DM(wheels.momentum_limit * friction / wheels.spin_inertia) * share
    return (ca.DM(wheels.momentum_limit) * rate + along + slowed) / ca.DM(wheels.torque_limit)


def _momentum(cluster: Cluster, frame: _Frame, rate: ca.SX) -> ca.SX:
    """H = Σ (Js Ω s + (Jg + Jt) ḋ g)."""
    turning = ca.DM(cluster.gimbal_axis_inertia) * _gimbals(cluster, rate)
    return frame.spin @ ca.DM(cluster.rotor_momentum) + frame.gimbal @ turning


def _momentum_rate(cluster: Cluster, frame: _Frame, rate: ca.SX, acceleration: ca.SX) -> ca.SX:
    """ḣ = A ḋ + Σ (Jg + Jt) d̈ g."""
    turning = ca.DM(cluster.gimbal_axis_inertia) * _gimbals(cluster, acceleration)
    return frame.transverse @ (ca.DM(cluster.rotor_momentum) * _gimbals(cluster, rate)) + frame.gimbal @ turning


def _inertia(cluster: Cluster, inertia: Matrix3, frame: _Frame) -> ca.SX:
    """J(d) = J + Σ (Js - Jt)(s sᵀ - s0 s0ᵀ)."""
    weight, home = np.diag(_asymmetry(cluster)), cluster.spin_axis_B.T
    return ca.DM(inertia - home @ weight @ home.T) + frame.spin @ ca.DM(weight) @ frame.spin.T


def _inertia_rate(cluster: Cluster, frame: _Frame, rate: ca.SX) -> ca.SX:
    """dJ(d)/dt = Σ (Js - Jt) ḋ (t sᵀ + s tᵀ)."""
    half = frame.transverse @ ca.diag(ca.DM(_asymmetry(cluster)) * _gimbals(cluster, rate)) @ frame.spin.T
    return half + half.T


def _dexterity(actuators: Actuators, frame: _Frame) -> ca.SX:
    """Of all columns, each the torque of an actuator at the same share of its limit."""
    momenta = actuators.cluster.rotor_momentum
    jacobian = ca.horzcat(frame.transverse @ ca.DM(np.diag(momenta)), ca.DM(actuators.wheel_columns))
    strengths = np.concatenate([momenta, actuators.wheel_scale])
    dexterity: ca.SX = ca.det(jacobian @ jacobian.T) / (np.sum(strengths**2) / 3.0) ** 3
    return dexterity


def _gimbal_torque(
    cluster: Cluster, frame: _Frame, acceleration: ca.SX, body_rate: ca.SX, body_acceleration: ca.SX
) -> ca.SX:
    """(Jg + Jt)(d̈ + g·ω̇) - (Js Ω + (Js - Jt) s·ω)(t·ω): along g, what turns a unit; Jg is the same about all axes."""
    carried = ca.DM(cluster.rotor_momentum) + ca.DM(_asymmetry(cluster)) * (frame.spin.T @ body_rate)
    turned = ca.DM(cluster.gimbal_axis_inertia) * (_gimbals(cluster, acceleration) + frame.gimbal.T @ body_acceleration)
    return turned - carried * (frame.transverse.T @ body_rate)


def _gimbals(cluster: Cluster, motion: ca.SX) -> ca.SX:
    """Return the gimbals' entries of a motion."""
    return motion[: len(cluster.rotor_momentum)]


def _asymmetry(cluster: Cluster) -> Units:
    """Js - Jt of each rotor, shape (M,), kg·m²."""
    return cluster.rotor_spin_inertia - cluster.rotor_transverse_inertia
