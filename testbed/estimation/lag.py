"""The first-order lag F(s) = 1/(γs + 1) on sampled signals, and its transpose. Source: paper eq. (32)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from testbed.arrays import Array


class LagWeights(NamedTuple):
    """The exact discretisation y ← decay y + old x₀ + new x₁ for signals that are linear between samples."""

    decay: float
    old: float
    new: float


def lag_weights(step: float, time_constant: float) -> LagWeights:
    """Return the weights for a step and a time constant γ, s."""
    ratio = step / time_constant
    decay = float(np.exp(-ratio))
    mean_decay = (1.0 - decay) / ratio
    return LagWeights(decay=decay, old=mean_decay - decay, new=1.0 - mean_decay)


def first_order_lag(signal: Array, step: float, time_constant: float) -> Array:
    """Return F x from zero state; exact where x is linear between samples.

    Args:
        signal: x, shape (M, ...), uniformly sampled along its first axis.
        step: between the samples, s.
        time_constant: γ, s.

    Source: paper eq. (32).
    """
    decay, old, new = lag_weights(step, time_constant)
    start = -new * signal[:1]  # so that the first output is zero
    return np.asarray(scipy.signal.lfilter([new, old], [1.0, -decay], signal, axis=0, zi=start)[0])


def transposed_lag(signal: Array, step: float, time_constant: float) -> Array:
    """Return Fᵀ x, F the matrix that `first_order_lag` multiplies by: the lag run backwards.

    Args:
        signal: x, shape (M, ...), uniformly sampled along its first axis.
        step: between the samples, s.
        time_constant: γ, s.
    """
    decay, old, new = lag_weights(step, time_constant)
    later = scipy.signal.lfilter([1.0], [1.0, -decay], signal[::-1], axis=0)[::-1]
    later[0] = 0.0  # the first output of the lag is zero whatever comes in
    return np.asarray(new * later + old * np.concatenate([later[1:], np.zeros_like(later[:1])]))


def impulse_power(step: float, time_constant: float) -> tuple[float, float]:
    """Return the lag's immediate response to an impulse, and the sum of squares of what follows."""
    decay, old, new = lag_weights(step, time_constant)
    return new, (old + decay * new) ** 2 / (1.0 - decay**2)
