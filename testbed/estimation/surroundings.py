"""What acts on a measured platform from outside, along its attitude as it is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Matrices3, Matrix3, Quaternion, Quaternions, Series, Vectors3
from testbed.dynamics.environment import Environment, Pivoted, gravity_basis, gravity_torque, outside_torque
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import matrix_of, quaternion_inverse, quaternion_product


@dataclass(frozen=True, kw_only=True, eq=False)
class Attitude:
    """An attitude in time.

    Attributes:
        start: quat_NA, a turn before the others.
        turns: quat_AB through samples, shape (N, 4).
    """

    start: Quaternion
    turns: CubicSpline

    def __call__(self, time: Series) -> Matrices3:
        """Return R_NB at times of shape (N,), s, shape (N, 3, 3)."""
        values = self.turns(time)
        return matrix_of(self.start) @ matrix_of(values / np.linalg.norm(values, axis=1, keepdims=True))


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """The environment of one run, and its attitude.

    Attributes:
        environment: what is believed to act.
        inertia: J about the centre of mass as it is known, kg·m²; a gravity gradient's small torque is taken of it.
        attitude: by a sensor of its own, or the gyro's integral from a known start.
        measured: whether it is a sensor's.
    """

    environment: Environment
    inertia: Matrix3
    attitude: Attitude
    measured: bool

    def torque(self, time: Series, body_rate: Vectors3) -> Vectors3:
        """Return all that is believed to act, shape (N, 3), N·m, body axes; the measured rate is that of the drag."""
        return outside_torque(self.environment, self.inertia, time, self.attitude(time), body_rate)

    def gravity(self, time: Series) -> Vectors3:
        """Return the torque of gravity on a pivot at the believed centre of mass, shape (N, 3), N·m; zero without."""
        if not isinstance(self.environment, Pivoted):
            return np.zeros((len(time), 3))
        return gravity_torque(self.environment.weight, self.up_B(time), self.environment.offset_B)

    def gravity_basis(self, time: Series) -> Array:
        """Return that torque for a unit of each coordinate of the offset, shape (N, 3, 3), N; (N, 3, 0) without."""
        if not isinstance(self.environment, Pivoted):
            return np.zeros((len(time), 3, 0))
        return gravity_basis(self.environment.weight, self.up_B(time))

    def up_B(self, time: Series) -> Vectors3:
        """Return the z axis of N in body axes, shape (N, 3)."""
        return self.attitude(time)[:, 2]


def integrated(time: Series, body_rate: Vectors3, start: Quaternion, start_time: float | None = None) -> Attitude:
    """Return the attitude as the gyro's integral.

    Args:
        time: of its samples, shape (N,), s.
        body_rate: shape (N, 3), rad/s.
        start: quat_NB where it is known.
        start_time: when that is, s; at the first sample where None.
    """
    turns = CubicSpline(time, integrate_attitude(time, body_rate))
    if start_time is not None:
        turned = turns(start_time)
        start = quaternion_product(start, quaternion_inverse(turned / np.linalg.norm(turned)))
    return Attitude(start=start, turns=turns)


def measured(time: Series, quat_NB: Quaternions) -> Attitude:
    """Return the attitude through the samples of a sensor.

    Args:
        time: shape (K,), s.
        quat_NB: shape (K, 4); of either sign.
    """
    flips = np.cumprod(np.where((quat_NB[1:] * quat_NB[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
    return Attitude(
        start=np.array([1.0, 0.0, 0.0, 0.0]),
        turns=CubicSpline(time, quat_NB * np.concatenate([[1.0], flips])[:, None]),
    )
