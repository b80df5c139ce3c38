"""The noise of the actuators' telemetry, estimated from its own samples, as it stands in a predicted body rate.

Of J ω = L - h the total angular momentum L is integrated and hardly feels single samples of h: an error δh of a sample
stands as J⁻¹ δh in the prediction of that sample.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Theta, Vector3, Vectors3
from testbed.cmg.cluster import spin_axes, transverse_axes
from testbed.dynamics.inertia import inertia_of, momentum_regressor
from testbed.estimation.differences import median_variance
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry, WheelTelemetry

_ORDER = 8
"""Of the differences: of a gimbal swinging by 0.3 rad at 1.5 Hz, they take 3e-5 rad for noise at 16 Hz."""

_LEAST_MOTION = 1e-12
"""Share of the motion's variance that each axis has at least: above rounding, far below what noise adds."""


def predicted_rate_variance(run: Telemetry, theta: Theta) -> Vector3:
    """Return the variance that the telemetry's noise puts on a predicted sample of each axis, shape (3,), rad²/s².

    Args:
        run: its telemetry.
        theta: inertia parameters, shape (6,), kg·m².
    """
    live = np.ix_(run.live, run.live)  # what a bearing holds does not turn
    inverse = np.zeros((3, 3))
    inverse[live] = np.linalg.inv(inertia_of(theta)[live])
    return np.diag(inverse @ momentum_covariance(run) @ inverse.T)


_AROUND = 10
"""Samples of the actuators on either side of an interval, beyond which they do not move a spline in it: by 3e-6."""


@lru_cache(maxsize=64)
def common_to_neighbours(run: Telemetry) -> float:
    """Return the correlation that the telemetry's noise gives neighbouring samples of a prediction, times its share.

    Of the variance of a sample of the telemetry, what two neighbouring samples of the gyro have in common: nothing of
    clocks that are alike, six tenths of a gyro twice as fast, all of telemetry that was freed of its fast errors.
    """
    sent, time = run.actuator_time, run.gyro_time
    smoothed = (run.wheels is not None and run.wheels.smoothed is not None) or (
        run.gimbals is not None and run.gimbals.angle_variance is not None
    )
    if smoothed or len(sent) < 2 * _AROUND + 2:
        return float(smoothed)
    middle = len(sent) // 2
    around = sent[middle - _AROUND : middle + _AROUND + 1]
    between = time[(time >= around[_AROUND // 2]) & (time <= around[-_AROUND // 2])]
    if len(between) < 2:  # a gyro slower than that
        return 0.0
    weights = CubicSpline(around, np.eye(len(around)))(between)
    return float(np.sum(weights[1:] * weights[:-1], axis=1).mean())


@dataclass(frozen=True, kw_only=True, eq=False)
class Attenuation:
    """By how much the telemetry's noise makes an inertia look larger, about the axis about which it does the most.

    Attributes:
        axis_B: the axis, shape (3,), unit vector, body axes.
        share: of the variance of the predicted body rate about the axis that is the telemetry's noise.
        in_std: the error of the moment of inertia about it over its standard deviation.
    """

    axis_B: Vector3
    share: float
    in_std: float


def attenuation(run: Telemetry, body_rate: Vectors3, theta: Theta, covariance: Array) -> Attenuation:
    """Return the attenuation of J⁻¹ by errors in variables: the regression of ω on h that is measured with noise.

    Slopes are lower by the share of the variance that is noise.

    Source: Fuller, "Measurement error models" (1987), eq. (1.1.5).

    Args:
        run: its telemetry.
        body_rate: that the model predicts from it, shape (N, 3), rad/s.
        theta: estimated inertia parameters, shape (6,), kg·m².
        covariance: of these, shape (6, 6).
    """
    inverse = np.linalg.inv(inertia_of(theta))
    total = np.cov(body_rate, rowvar=False)
    least = _LEAST_MOTION * float(np.trace(total)) + np.finfo(float).tiny
    shares, axes_B = scipy.linalg.eigh(inverse @ momentum_covariance(run) @ inverse.T, total + least * np.eye(3))
    found = []
    for share, axis_B in zip(shares, (axes_B / np.linalg.norm(axes_B, axis=0)).T, strict=True):
        row = axis_B @ momentum_regressor(axis_B)  # of the moment about the axis
        in_std = share * float(row @ theta) / float(np.sqrt(row @ covariance @ row))
        found.append(Attenuation(axis_B=axis_B, share=float(share), in_std=in_std))
    return max(found, key=lambda each: each.in_std)


def momentum_covariance(run: Telemetry) -> Array:
    """Return the covariance of a sample of the cluster's momentum by its telemetry's noise, (N·m·s)², shape (3, 3)."""
    return _covariance_of_gimbals(run) + _covariance_of_wheels(run.wheels)


def _covariance_of_wheels(sent: WheelTelemetry | None) -> Array:
    if sent is None:
        return np.zeros((3, 3))
    axes_B = sent.wheels.axis_B
    variance = fast_variance(sent.momentum) if sent.smoothed is None else sent.smoothed.variance
    return np.asarray((axes_B.T * variance) @ axes_B)


def _covariance_of_gimbals(run: Telemetry) -> Array:
    """Return the covariance of the gyros' momentum, or of the one that the platform reports."""
    if run.gimbals is not None:
        cluster, angle, known = run.gimbals.cluster, run.gimbals.angle, run.gimbals.angle_variance
        variance = fast_variance(angle) if known is None else known
        slopes = cluster.rotor_momentum[:, None] * transverse_axes(cluster, angle)
        by_angle = np.einsum("kui,kuj,u->ij", slopes, slopes, variance) / len(slopes)
        return np.asarray(by_angle + _covariance_of_rotors(run.gimbals))
    if run.cluster_momentum is not None and run.wheels is None:
        return np.diag(fast_variance(run.cluster_momentum))
    return np.zeros((3, 3))


def _covariance_of_rotors(sent: GimbalTelemetry) -> Array:
    if sent.rotor_momentum is None:
        return np.zeros((3, 3))
    axes_B = spin_axes(sent.cluster, sent.angle)
    variance = fast_variance(sent.rotor_momentum)
    return np.asarray(np.einsum("kui,kuj,u->ij", axes_B, axes_B, variance) / len(axes_B))


def is_as_sent(run: Telemetry) -> bool:
    """Return whether the actuators' telemetry has all noise that it was sent with: no channel of it is smoothed."""
    angles = run.gimbals is None or run.gimbals.angle_variance is None
    return angles and (run.wheels is None or run.wheels.smoothed is None)


def with_more_noise(run: Telemetry, rng: np.random.Generator) -> Telemetry:
    """Return a run with as much noise added as the sensors of its actuators, and of where it stood, have."""
    gimbals, wheels, reported = run.gimbals, run.wheels, run.cluster_momentum
    if gimbals is not None:
        gimbals = replace(gimbals, angle=_noisy(gimbals.angle, fast_variance(gimbals.angle), rng))
    if wheels is not None:
        wheels = replace(wheels, momentum=_noisy(wheels.momentum, fast_variance(wheels.momentum), rng))
    if gimbals is None and wheels is None and reported is not None:
        reported = _noisy(reported, fast_variance(reported), rng)
    around = run.surroundings
    if around is not None and around.start_std > 0.0:
        around = around.turned(around.start_std * rng.standard_normal(3))
    return replace(run, gimbals=gimbals, wheels=wheels, cluster_momentum=reported, surroundings=around)


def _noisy(channel: Array, variance: Array, rng: np.random.Generator) -> Array:
    return np.asarray(channel + np.sqrt(variance) * rng.standard_normal(channel.shape))


def fast_variance(channel: Array) -> Array:
    """Return the variance of columns' white noise, estimated from their fastest changes; zero of too few samples."""
    return np.zeros(channel.shape[1]) if len(channel) <= _ORDER else median_variance(channel, _ORDER)
