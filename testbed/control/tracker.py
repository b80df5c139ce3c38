"""The body-rate tracker: how the cluster's momentum has to change so that the platform follows its reference."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Matrix3, Vector3, Vectors3

UNMODELLED_ACCELERATION = 1e-5
"""Spectral density of the angular acceleration that the nominal model does not explain, rad²/s³: about 2 % of the
shipped maneuvers' accelerations over a fifth of a second. It only sets how the feedback gain trades noise for error."""

_GAIN_PER_SAMPLE_RATE = 0.25
"""A loop that samples and holds keeps a phase margin above 60 degrees up to a quarter of its sample rate, in 1/s."""


@dataclass(frozen=True, kw_only=True)
class Tracker:
    """Feed-forward along the reference, feedback on the gyro.

    Attributes:
        inertia: nominal J, kg·m², body axes.
        gain: k, 1/s.
    """

    inertia: Matrix3
    gain: float


def feedback_gain(gyro_noise: float, sample_period: float) -> float:
    """Return the gain k of the rate feedback, 1/s.

    k = sqrt(q / (σ² T)) is the steady-state Kalman gain of a rate that drifts with the unmodelled acceleration's
    spectral density q and is measured with noise of spectral density σ² T; it is bounded by what a sampled loop bears.

    Args:
        gyro_noise: σ per sample, rad/s.
        sample_period: T of the gyro, s.
    """
    bound = _GAIN_PER_SAMPLE_RATE / sample_period
    if gyro_noise == 0.0:
        return bound
    return min(math.sqrt(UNMODELLED_ACCELERATION / (gyro_noise**2 * sample_period)), bound)


def wanted_momentum_rate(
    tracker: Tracker,
    reference_rate: Vectors3,
    reference_acceleration: Vectors3,
    cluster_momentum_B: Vectors3,
    rate_error: Vectors3,
) -> Vectors3:
    """Return ḣ = -(J (ω̇_ref + k e) + ω_ref × (J ω_ref + h)), shape (..., 3), N·m, body axes.

    Euler's equation solved for the cluster. The cross product takes the reference, not the noisy gyro (trap 2).

    Args:
        tracker: nominal inertia and gain.
        reference_rate: ω_ref, shape (..., 3), rad/s.
        reference_acceleration: ω̇_ref, shape (..., 3), rad/s².
        cluster_momentum_B: h at the measured gimbal angles, shape (..., 3), N·m·s.
        rate_error: e = ω_ref - ω̄ at the last gyro sample, shape (..., 3), rad/s.

    Source: paper eq. (1) with M = -ḣ.
    """
    total = reference_rate @ tracker.inertia + cluster_momentum_B
    gyroscopic = _cross(reference_rate, total)
    return -((reference_acceleration + tracker.gain * rate_error) @ tracker.inertia + gyroscopic)  # eq. (1)


def _cross(left: Vector3, right: Vector3) -> Vector3:
    """The cross product by index: np.cross takes ten times as long on a single vector, once in every control period."""
    return np.asarray(
        left[..., _NEXT] * right[..., _AFTER_NEXT] - left[..., _AFTER_NEXT] * right[..., _NEXT], dtype=np.float64
    )


_NEXT, _AFTER_NEXT = np.array([1, 2, 0]), np.array([2, 0, 1])
