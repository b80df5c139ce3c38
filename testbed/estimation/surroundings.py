"""What acts on a measured platform from outside, along its attitude as it is known."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter, uniform_filter1d

from testbed.arrays import Array, Flags, Matrices3, Matrix3, Quaternion, Quaternions, Series, Vector3, Vectors3
from testbed.dynamics.environment import Environment, Pivoted, gravity_basis, gravity_torque, outside_torque
from testbed.estimation.differences import median_variance
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import exponential, matrix_of, quaternion_inverse, quaternion_product

EXACT = 1e-7
"""Noise of a sensor of the attitude that has none of its own, rad. Source: numbers of single precision."""


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
        return matrix_of(self.quat(time))

    def quat(self, time: Series) -> Quaternions:
        """Return quat_NB at times of shape (N,), s, shape (N, 4)."""
        values = self.turns(time)
        return quaternion_product(self.start, values / np.linalg.norm(values, axis=1, keepdims=True))


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """The environment of one run, and its attitude.

    Attributes:
        environment: what is believed to act.
        inertia: J about the centre of mass as it is known, kg·m²; a gravity gradient's small torque is taken of it.
        attitude: by a sensor of its own, or the gyro's integral from a known start.
        measured: whether a sensor tells it at all times.
        start_std: of an attitude that is the gyro's integral through a noisy sensor's samples, how well these tell its
            start about each axis, rad; 0 of any other.
        lag: by which a sensor's samples are later than the gyro's, s, where it was found.
        left_out: samples of a sensor that are off by far more than its noise.
    """

    environment: Environment
    inertia: Matrix3
    attitude: Attitude
    measured: bool
    start_std: float = 0.0
    lag: float = 0.0
    left_out: int = 0

    def turned(self, rotation_N: Vector3) -> Surroundings:
        """Return the same with all attitudes turned by a small rotation, rad, in N."""
        start = quaternion_product(exponential(rotation_N), self.attitude.start)
        return replace(self, attitude=replace(self.attitude, start=start))

    @property
    def exact(self) -> bool:
        """Whether gravity's torque may be taken along the attitude as it is, and need not follow from the motion."""
        return self.measured and self.start_std == 0.0

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Fused:
    """An attitude by gyro and sensor together.

    Attributes:
        attitude: the gyro's integral.
        start_std: standard deviation of its start, rad.
        lag: of the sensor's samples behind the gyro's, s.
        lag_std: its standard deviation, s.
    """

    attitude: Attitude
    start_std: float
    lag: float
    lag_std: float


def sensor_noise(attitude: Attitude, time: Series, quat_NB: Quaternions) -> float:
    """Return the standard deviation of a sensor's samples about an attitude, by their fastest changes, rad.

    Args:
        attitude: that changes smoothly, such as the gyro's integral from any start.
        time: of the samples, shape (K,), s.
        quat_NB: shape (K, 4).
    """
    return float(np.sqrt(median_variance(_apart(attitude, time, quat_NB), _ORDER).mean()))


_ORDER = 2
"""Of the differences: what the gyro's integral is off by changes along a line between three samples."""


def fused(time: Series, body_rate: Vectors3, sent: Series, quat_NB: Quaternions, *, noise: float, walk: float) -> Fused:
    """Return the gyro's integral from the start, and less the constant error, that suit a sensor's samples best.

    What it is off by is a constant, what a constant error of the rate adds up to, what the body turns in the time by
    which the samples are late, a walk by the gyro's noise, and the sensor's noise: least squares in their covariance.
    Early samples tell the start, late ones the rate's error.

    Args:
        time: of the gyro, shape (N,), s.
        body_rate: shape (N, 3), rad/s.
        sent: times of the sensor's samples, shape (K,), s, between the gyro's.
        quat_NB: shape (K, 4).
        noise: standard deviation of the sensor's samples, rad.
        walk: of the integral of the gyro's noise after a second, rad.
    """
    first = integrated(time, body_rate, quat_NB[0], float(sent[0]))
    turned = CubicSpline(time, first(time), axis=0).antiderivative()(sent)
    slow = uniform_filter1d(body_rate, max(round(_SLOW / float(np.median(np.diff(time)))), 1), axis=0)
    rate_N = first(sent) @ CubicSpline(time, slow)(sent)[:, :, None]
    start = np.broadcast_to(np.eye(3), turned.shape)
    regressor = np.concatenate([start, turned - turned[:1], -rate_N], axis=2)
    early = sent < sent[0] + _TELLING
    group = max(int(np.count_nonzero(early)) // _MOST, 1)
    after = _means((sent - sent[0])[early], group)
    columns = [_means(each[early], group) for each in (regressor, _apart(first, sent, quat_NB))]
    covariance = walk**2 * np.minimum(after[:, None], after) + noise**2 / group * np.eye(len(after))
    root = np.linalg.cholesky(covariance)
    white, apart = (np.linalg.solve(root, each.reshape(len(after), -1)).reshape(3 * len(after), -1) for each in columns)
    believed = np.diag([0.0] * 6 + [_USUAL_LAG**-2])
    covariance = np.linalg.inv(white.T @ white + believed)
    answer = covariance @ (white.T @ apart[:, 0])
    turn = quaternion_product(exponential(answer[:3]), quat_NB[0])
    variance = np.diag(covariance)
    return Fused(
        attitude=integrated(time, body_rate + answer[3:6], turn, float(sent[0])),
        start_std=float(np.sqrt(variance[:3].mean())),
        lag=float(answer[6]),
        lag_std=float(np.sqrt(variance[6])),
    )


_SLOW = 0.25
"""Over which the rate is averaged that shows a lag, s: the gyro's noise in it would make the lag seem shorter, 36
for 40 ms at 50 Hz."""
_USUAL_LAG = 0.1
"""Standard deviation of a sensor's lag as it is believed, s: a body that turns evenly does not show it. Source: chosen,
a few frames of a camera or the delay of a filter."""


def known_right(time: Series, body_rate: Vectors3, sent: Series, quat_NB: Quaternions, walk: float) -> Flags:
    """Return which samples of an attitude sensor are not single wrong ones, shape (K,).

    Args:
        time: of the gyro, shape (N,), s.
        body_rate: shape (N, 3), rad/s.
        sent: times of the sensor's samples, shape (K,), s, between the gyro's.
        quat_NB: shape (K, 4).
        walk: what the gyro's integral walks between two samples of the sensor, rad.
    """
    by_gyro = integrated(time, body_rate, quat_NB[0], float(sent[0]))
    apart = _apart(by_gyro, sent, quat_NB)
    off = np.abs(apart - median_filter(apart, (_BESIDE, 1), mode="nearest"))
    scale = np.hypot(sensor_noise(by_gyro, sent, quat_NB), walk)
    return np.asarray((off < _WRONG * scale).all(axis=1))


_BESIDE = 5
"""Samples of a median, which two wrong ones beside each other do not move."""
_WRONG = 8.0
"""Times the noise by which a wrong sample is off from the median of those beside it. Source: as for the gyro's spikes,
4.5, of a difference of two; a noise of normal numbers comes so far in one of 1e8."""


_TELLING = 60.0
"""The first seconds of the sensor's samples, which tell the start: after them the gyro's walk hides it."""
_MOST = 600
"""Numbers that they are compared by, of each axis: as many samples, or means of as many groups of a fast sensor's."""


def _means(values: Array, group: int) -> Array:
    """Return the means of so many values each, along the first axis; the last few may be in none."""
    whole = len(values) // group * group
    return np.asarray(values[:whole].reshape(-1, group, *values.shape[1:]).mean(axis=1))


def _apart(attitude: Attitude, time: Series, quat_NB: Quaternions) -> Vectors3:
    """Return the small rotations from an attitude to samples, shape (K, 3), rad, in N."""
    apart = matrix_of(quat_NB) @ np.swapaxes(attitude(time), 1, 2)
    return (
        np.stack(
            [apart[:, 2, 1] - apart[:, 1, 2], apart[:, 0, 2] - apart[:, 2, 0], apart[:, 1, 0] - apart[:, 0, 1]], axis=1
        )
        / 2.0
    )
