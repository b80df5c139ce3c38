"""What acts on a platform from outside: gravity on a pivot, or what a circular orbit brings with it.

All torques are analytic in what they are given, so that complex steps pass through them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from testbed.arrays import Array, Matrices3, Matrix3, Vector3, Vectors3
from testbed.dynamics.gravity_gradient import gravity_gradient_torque
from testbed.dynamics.inertia import cross_matrix
from testbed.rotation.vectors import cross

EARTH = 3.986004418e14
"""m³/s², μ of the Earth. Source: IERS Conventions (2010), table 1.1."""
EARTH_RADIUS = 6.371e6
"""m, the mean radius. Source: H. Moritz, Geodetic Reference System 1980, Journal of Geodesy 74, 2000."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pivoted:
    """A platform on a ball joint: gravity acts at its centre of mass, beside the pivot, and air against its turning.

    The pivot is the origin of N, whose z points up.

    Attributes:
        mass: m of the whole platform, kg.
        gravity: g, m/s², along -z of N.
        offset_B: c, from the pivot to the centre of mass, shape (3,), m, body axes.
        drag: c_d in the torque -c_d ω, the same about every axis, N·m·s/rad.
    """

    mass: float
    gravity: float
    offset_B: Vector3
    drag: float = 0.0

    @property
    def weight(self) -> float:
        """M g, N."""
        return self.mass * self.gravity

    @property
    def added_inertia(self) -> Matrix3:
        """What J about the pivot is more than about the centre of mass, shape (3, 3), kg·m²."""
        return parallel_axes(self.mass, self.offset_B)


@dataclass(frozen=True, kw_only=True, eq=False)
class Orbiting:
    """A platform on a circular orbit of the Earth.

    N is the local frame at time zero: x forward, y against the orbit's normal, z down. What is constant in the local
    frame L turns with the platform's place on the orbit.

    Attributes:
        rate: n, rad/s.
        field_L: magnetic field, shape (3,), T, local axes.
        torque_L: constant torque, of air and sunlight, shape (3,), N·m, local axes.
        dipole_B: of the platform, shape (3,), A·m², body axes.
        gradient: torque of the gravity gradient over 3 n² r × J r; 1 but for what is flown otherwise.
    """

    rate: float
    field_L: Vector3
    torque_L: Vector3
    dipole_B: Vector3
    gradient: float = 1.0


Environment: TypeAlias = Pivoted | Orbiting


def parallel_axes(mass: float, offset: Array) -> Array:
    """Return m (c·c 1 - c cᵀ), shape (..., 3, 3), kg·m².

    Args:
        mass: m, kg.
        offset: c, shape (..., 3), m.
    """
    square = (offset * offset).sum(axis=-1)[..., None, None]
    return np.asarray(mass * (square * np.eye(3) - offset[..., :, None] * offset[..., None, :]))


def outside_torque(
    environment: Environment, inertia: Matrix3, time: Array, matrix_NB: Matrices3, body_rate: Vectors3
) -> Vectors3:
    """Return what acts on a platform along a motion, shape (N, 3), N·m, body axes, about the point it turns about.

    Args:
        environment: what acts.
        inertia: J about the centre of mass, kg·m².
        time: shape (N,), s.
        matrix_NB: R_NB, shape (N, 3, 3).
        body_rate: ω, shape (N, 3), rad/s.
    """
    to_body = np.swapaxes(matrix_NB, -1, -2)
    if isinstance(environment, Orbiting):
        return _torque_at(environment, inertia, to_body @ local_axes(environment, time))
    gravity_B = gravity_torque(environment.weight, to_body[..., 2], environment.offset_B)
    return np.asarray(gravity_B - environment.drag * body_rate)


def gravity_torque(weight: float, up_B: Array, offset_B: Array) -> Array:
    """Return m g u × c about the pivot, shape (..., 3), N·m, body axes.

    Args:
        weight: m g, N.
        up_B: u, against gravity, unit vectors, shape (..., 3), body axes.
        offset_B: c, from the pivot to the centre of mass, shape (..., 3), m, body axes.
    """
    return np.asarray(weight * cross(up_B, offset_B))


def gravity_basis(weight: float, up_B: Array) -> Array:
    """Return the torques of unit offsets, m g u×, shape (..., 3, 3), N: in the offset the torque is linear."""
    return np.asarray(weight * cross_matrix(up_B))


def local_axes(orbit: Orbiting, time: Array) -> Array:
    """Return R_NL, local to inertial axes, shape (..., 3, 3).

    Args:
        orbit: its rate.
        time: from that at which L is N, shape (...,), s.
    """
    angle = np.asarray(orbit.rate * time)
    axes = np.zeros((*angle.shape, 3, 3))
    axes[..., 1, 1] = 1.0
    axes[..., 0, 0] = axes[..., 2, 2] = np.cos(angle)
    axes[..., 2, 0] = np.sin(angle)
    axes[..., 0, 2] = -axes[..., 2, 0]
    return axes


def orbit_torque(orbit: Orbiting, inertia: Array, outward_B: Array, field_B: Array, constant_B: Array) -> Array:
    """Return what acts on orbit, 3 n² r × J r + m × B and the constant torque, shape (..., 3), N·m, body axes.

    Args:
        orbit: its rate, and the platform's dipole.
        inertia: J about the centre of mass, shape (..., 3, 3), kg·m².
        outward_B: r, the z axis of L, shape (..., 3).
        field_B: B, shape (..., 3), T.
        constant_B: torque that is constant in L, shape (..., 3), N·m.
    """
    gradient_B = gradient_torque(orbit, inertia, outward_B)
    return np.asarray(gradient_B + dipole_torque(orbit.dipole_B, field_B) + constant_B)


def _torque_at(orbit: Orbiting, inertia: Array, local_B: Array) -> Array:
    """Return the same where R_BL, shape (..., 3, 3), is known."""
    field_B, constant_B = np.matvec(local_B, orbit.field_L), np.matvec(local_B, orbit.torque_L)
    return orbit_torque(orbit, inertia, local_B[..., 2], field_B, constant_B)


@dataclass(frozen=True, kw_only=True, eq=False)
class OrbitTorque:
    """What an orbit does to B platforms that fly on it.

    Attributes:
        orbit: the same of all.
        inertia: J of each about its centre of mass, shape (B, 3, 3), kg·m².
    """

    orbit: Orbiting
    inertia: Array

    def __call__(self, time: float, matrix_NB: Matrices3) -> Vectors3:
        """Return torques, shape (B, 3), N·m, body axes, at a time in s and attitudes R_NB, shape (B, 3, 3)."""
        local_B = np.swapaxes(matrix_NB, -1, -2) @ local_axes(self.orbit, np.asarray(time))
        return _torque_at(self.orbit, self.inertia, local_B)


def gradient_torque(orbit: Orbiting, inertia: Array, outward_B: Array) -> Array:
    """Return the gravity gradient's torque alone, as `orbit_torque`; up and down are the same."""
    return np.asarray(orbit.gradient * gravity_gradient_torque(inertia, outward_B, orbit.rate))


def dipole_torque(dipole_B: Array, field_B: Array) -> Array:
    """Return m × B of a dipole, shape (..., 3), N·m, body axes.

    Args:
        dipole_B: m, shape (..., 3), A·m².
        field_B: B, shape (..., 3), T.
    """
    return cross(dipole_B, field_B)
