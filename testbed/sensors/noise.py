"""Noise processes of an inertial sensor on a regular time grid, each with its Allan variance.

The grid runs along the first axis. Source of the names and the Allan variances: IEEE Std 952, Annex C.
"""

from __future__ import annotations

import numpy as np
import scipy

from testbed.arrays import Array

Shape = tuple[int, ...]
"""Samples first, then anything that is drawn independently."""


def white_noise(std: Array | float, shape: Shape, rng: np.random.Generator) -> Array:
    """Draw white noise; Allan variance N²/τ with the angle random walk N = std·√dt.

    Args:
        std: standard deviation per sample; an array broadcasts.
        shape: samples first.
        rng: source of randomness.
    """
    return std * rng.standard_normal(shape)


def autoregression(correlation: float, white: Array) -> Array:
    """Return noise whose neighbouring samples are correlated, of the variance of the white noise that it is made of.

    Args:
        correlation: of neighbouring samples.
        white: samples first.
    """
    if correlation == 0.0:
        return white
    driven = np.sqrt(1.0 - correlation**2) * white
    driven[0] = white[0]
    return np.asarray(scipy.signal.lfilter([1.0], [1.0, -correlation], driven, axis=0))


def gauss_markov(std: float, correlation_time: float, dt: float, shape: Shape, rng: np.random.Generator) -> Array:
    """Draw a first-order Gauss-Markov process with correlation std²·exp(-|t|/T), stationary from the first sample on.

    Allan variance 2 std² T/τ·(1 - T/(2τ)·(3 - 4 exp(-τ/T) + exp(-2τ/T))).

    Args:
        std: stationary standard deviation.
        correlation_time: T, s; infinite for a constant drawn once.
        dt: sample period, s.
        shape: samples first.
        rng: source of randomness.
    """
    if std == 0.0:
        return np.zeros(shape)
    decay = np.exp(-dt / correlation_time)
    drive = std * rng.standard_normal(shape)
    drive[1:] *= np.sqrt(1.0 - decay**2)
    return np.asarray(scipy.signal.lfilter([1.0], [1.0, -decay], drive, axis=0))


def random_walk(coefficient: float, dt: float, shape: Shape, rng: np.random.Generator) -> Array:
    """Draw a random walk that starts at zero; Allan variance K²τ/3.

    Args:
        coefficient: K, the rate random walk, standard deviation gained per √s.
        dt: sample period, s.
        shape: samples first.
        rng: source of randomness.
    """
    if coefficient == 0.0:
        return np.zeros(shape)
    steps = coefficient * np.sqrt(dt) * rng.standard_normal(shape)
    steps[0] = 0.0
    return np.asarray(np.cumsum(steps, axis=0))


def angle_quantization(coefficient: float, dt: float, shape: Shape, rng: np.random.Generator) -> Array:
    """Draw the rate error of a gyro that counts angle increments; Allan variance 3Q²/τ².

    The rounding error of the angle is uniform and white, what one sample lacks the next one makes up.

    Args:
        coefficient: Q, standard deviation of the angle's rounding error: its step over √12.
        dt: sample period, s.
        shape: samples first.
        rng: source of randomness.
    """
    if coefficient == 0.0:
        return np.zeros(shape)
    half_step = np.sqrt(3.0) * coefficient
    angle_error = rng.uniform(-half_step, half_step, (shape[0] + 1, *shape[1:]))
    return np.diff(angle_error, axis=0) / dt
