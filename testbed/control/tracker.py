"""The body-rate tracker: which momentum the cluster should hold so that the platform follows its reference.

With the total angular momentum L conserved in inertial axes, J(d) ω + h = L: the reference rate fixes the momentum
that the cluster has to hold at every instant, without integrating a torque. The gyro corrects errors of the nominal
model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Matrix3, Series, Vector3, Vectors3
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import quaternion_inverse, turned

UNMODELLED_ACCELERATION = 5.6e-7
"""Spectral density of the angular acceleration that the nominal model does not explain, rad²/s³: 7.5e-4 rad/s of
unexplained rate after one second. It only sets how the feedback gain trades noise for error."""

_GAIN_PER_SAMPLE_RATE = 0.125
"""Keeps the loop well damped: at 16 Hz, 2 1/s against 9 1/s of the momentum loop inside it and 31 ms of holding."""


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


def feedback_momentum_rate(tracker: Tracker, rate_error: Vectors3) -> Vectors3:
    """Return -J k e: how fast the cluster should take up momentum to remove a rate error, shape (..., 3), N·m.

    Args:
        tracker: nominal inertia and gain.
        rate_error: e = ω_ref - ω̄ at the last gyro sample, shape (..., 3), rad/s, body axes.
    """
    # vecmat, here and below: a matrix product of a whole batch would round a row by how many rows there are.
    return np.asarray(-tracker.gain * np.vecmat(rate_error, tracker.inertia))


def momentum_of_rates(
    inertia: Matrix3,
    time: Series,
    reference_rate: Vectors3,
    initial_momentum_B: Vector3,
    outside_torque_B: Vectors3 | None = None,
) -> Vectors3:
    """Return the momentum Rᵀ (H₀ + ∫ R τ dt) - J ω_ref to hold along a reference, shape (N, 3), N·m·s.

    Which gimbal angles will hold it is open, so J stands for J(d) and the gimbals' own turning is left out: 1e-3 of
    the reference rate, which the feedback takes up.

    Args:
        inertia: nominal J, kg·m².
        time: shape (N,), s.
        reference_rate: ω_ref, shape (N, 3), rad/s, body axes.
        initial_momentum_B: total angular momentum at the first time, shape (3,), N·m·s, body axes.
        outside_torque_B: τ along the reference, shape (N, 3), N·m, body axes; none where None.
    """
    total_B = np.zeros_like(reference_rate)
    if outside_torque_B is not None:
        attitude = integrate_attitude(time, reference_rate)
        impulse = CubicSpline(time, turned(attitude, outside_torque_B)).antiderivative()(time)
        total_B = turned(quaternion_inverse(attitude), initial_momentum_B + impulse)
    elif np.any(initial_momentum_B):
        attitude = integrate_attitude(time, reference_rate)
        total_B = turned(quaternion_inverse(attitude), initial_momentum_B)
    return total_B - reference_rate @ inertia
