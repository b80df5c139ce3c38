"""All actuators of a platform that store momentum: control moment gyros and reaction wheels side by side.

What they are commanded in is put on one scale: the rate of a gimbal, rad/s, and the torque of a wheel as a share of its
limit times the gimbals' rate limit. A column of the Jacobian is then the torque of an actuator at the same share of
its limit, whatever kind it is of.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from testbed.arrays import Array, Axes, Series, Units, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, spin_momentum_and_jacobian
from testbed.cmg.singularity import envelope_fraction, envelope_radius, singularity_measure
from testbed.cmg.wheels import Wheels, momentum_envelope, wheel_envelope_share, wheel_momentum


@dataclass(frozen=True, kw_only=True)
class Actuators:
    """M control moment gyros and W reaction wheels; either may be none.

    Attributes:
        cluster: the gyros.
        wheels: the wheels.
        gimbal_rate_limit: rad/s; the scale of all commands.
    """

    cluster: Cluster
    wheels: Wheels
    gimbal_rate_limit: float

    @property
    def units(self) -> int:
        """M, number of control moment gyros."""
        return len(self.cluster.rotor_momentum)

    @property
    def count(self) -> int:
        """M + W, number of all actuators."""
        return self.units + len(self.wheels.spin_inertia)

    @cached_property
    def wheel_scale(self) -> Array:
        """Torque of each wheel for a command of 1 rad/s, shape (W,), N·m·s/rad."""
        return np.asarray(self.wheels.torque_limit / self.gimbal_rate_limit)

    @property
    def command_scale(self) -> Array:
        """What a command of 1 rad/s moves of each actuator in a second, shape (M + W,): rad, and N·m·s of wheels."""
        return np.concatenate([np.ones(self.units), self.wheel_scale])

    @property
    def move_scale(self) -> Array:
        """A move of each actuator of the order of its range, shape (M + W,): 1 rad, and a wheel's momentum limit."""
        return np.concatenate([np.ones(self.units), self.wheels.momentum_limit])

    @cached_property
    def wheel_columns(self) -> Axes:
        """Columns of the wheels in the Jacobian, shape (3, W), N·m·s/rad."""
        return np.ascontiguousarray((self.wheels.axis_B * self.wheel_scale[:, None]).T)

    @cached_property
    def momentum_scale(self) -> float:
        """The largest column that the Jacobian can have, by which steering laws are scaled, N·m·s."""
        return float(np.abs(np.concatenate([self.cluster.rotor_momentum, self.wheel_scale])).max())


def envelope_share(cluster: Cluster, wheels: Wheels, momentum_B: Vectors3, directions_B: Vectors3) -> Series:
    """Return the share of the momentum envelope that h uses, shape (...,): 1 on its surface.

    The envelope of all actuators is the sum of those of gyros and wheels, and its support the sum of theirs. Of wheels
    alone it is a polyhedron, and the share exact.

    Args:
        cluster: the gyros.
        wheels: the wheels.
        momentum_B: h, shape (..., 3), N·m·s, body axes.
        directions_B: along which the support is taken with gyros, shape (K, 3), unit vectors.
    """
    if not len(wheels.spin_inertia):
        return envelope_fraction(cluster, momentum_B, directions_B)
    if not len(cluster.rotor_momentum):
        return wheel_envelope_share(wheels, momentum_B)
    support = envelope_radius(cluster, directions_B) + momentum_envelope(wheels, directions_B)
    return np.asarray((np.asarray(momentum_B) @ directions_B.T / support).max(axis=-1))


def momentum_and_jacobian(
    actuators: Actuators, gimbal_angle: UnitSeries, wheel_momenta: UnitSeries
) -> tuple[Vectors3, Array]:
    """Return the momentum Σ Js Ω s(d) + Σ Jw Ω a and its Jacobian with respect to all commands.

    Args:
        actuators: at nominal rotor speeds.
        gimbal_angle: d, shape (..., M), rad.
        wheel_momenta: Jw Ω, shape (..., W), N·m·s.

    Returns:
        h, shape (..., 3), N·m·s, body axes, and [A(d) | wheel columns], shape (..., 3, M + W), N·m·s/rad.
    """
    momentum_B, jacobian = spin_momentum_and_jacobian(actuators.cluster, gimbal_angle)
    if not len(actuators.wheel_scale):
        return momentum_B, jacobian
    columns = np.broadcast_to(actuators.wheel_columns, (*jacobian.shape[:-1], len(actuators.wheel_scale)))
    return momentum_B + wheel_momentum(actuators.wheels, wheel_momenta), np.concatenate([jacobian, columns], axis=-1)


def momentum_of_actuators(actuators: Actuators, gimbal_angle: UnitSeries, wheel_momenta: UnitSeries) -> Vectors3:
    """Return the spin momentum Σ Js Ω s(d) + Σ Jw Ω a along a reference motion, shape (N, 3), N·m·s, body axes.

    Args:
        actuators: gyros and wheels.
        gimbal_angle: shape (N, M), rad.
        wheel_momenta: Jw Ω, shape (N, W), N·m·s.
    """
    of_gyros_B = cluster_momentum(actuators.cluster, gimbal_angle, np.zeros_like(gimbal_angle))
    return of_gyros_B + wheel_momentum(actuators.wheels, wheel_momenta) if len(actuators.wheel_scale) else of_gyros_B


def dexterity(actuators: Actuators, jacobian: Array, rotor_momentum: Units) -> Series:
    """Return the singularity measure of gyros and wheels together, each at the same share of its limit, shape (...,).

    Args:
        actuators: whose wheels these are.
        jacobian: A(d) of the gyros, shape (..., 3, M), N·m·s/rad.
        rotor_momentum: of the gyros, shape (M,), N·m·s.
    """
    strengths = rotor_momentum
    if len(actuators.wheel_scale):
        columns = np.broadcast_to(actuators.wheel_columns, (*jacobian.shape[:-1], len(actuators.wheel_scale)))
        jacobian = np.concatenate([jacobian, columns], axis=-1)
        strengths = np.concatenate([strengths, actuators.wheel_scale])
    return singularity_measure(jacobian, strengths)


def held_capacity(cluster: Cluster, wheels: Wheels) -> float:
    """Return the sum of what all rotors hold and all wheels can hold, N·m·s."""
    return float(np.abs(cluster.rotor_momentum).sum() + wheels.momentum_limit.sum())
