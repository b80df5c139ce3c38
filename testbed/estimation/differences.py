"""White noise from a signal's fastest changes, which no motion of the platform makes: differences of a high order.

Differences of order n take any polynomial of degree n - 1 out of a signal. Their weights have unit length, so that
differences of white noise have its variance. Whoever uses them chooses the order by how much of the motion is still in
them, and the statistic: the mean of their squares is surer, the median bears a tenth of outliers.
"""

from __future__ import annotations

from math import comb

import numpy as np
import scipy

from testbed.arrays import Array, Series

CHI_SQUARE_MEDIAN = float(2.0 * scipy.special.gammaincinv(0.5, 0.5))
"""Of the squares of a normal number of variance 1."""


def weights(order: int) -> Array:
    """Return the binomial weights of differences between even samples, not yet of unit length, shape (order + 1,)."""
    return np.array([(-1.0) ** index * comb(order, index) for index in range(order + 1)])


def squared_differences(values: Array, order: int) -> Array:
    """Return the squared differences of columns of even samples, weights of unit length, shape (N - order, W).

    Args:
        values: shape (N, W), N more than the order.
        order: of the differences.
    """
    return np.asarray(_squares(values, order) / _length(order))


def median_variance(values: Array, order: int) -> Array:
    """Return the variance of columns' white noise by the median of their squared differences, shape (W,).

    Args:
        values: even samples, shape (N, W), N more than the order.
        order: of the differences.
    """
    return np.asarray(np.median(_squares(values, order), axis=0) / (CHI_SQUARE_MEDIAN * _length(order)))


def median_std(differences: Array) -> Array:
    """Return the standard deviation of columns' white noise by the median size of their differences, shape (W,)."""
    return np.asarray(scipy.stats.median_abs_deviation(differences, axis=0, scale="normal"))


def divided_differences(time: Series, values: Array, order: int) -> Array:
    """Return the differences of columns of uneven samples, weights of unit length, shape (N - order, W).

    Args:
        time: of the samples, shape (N,), s.
        values: shape (N, W), N more than the order.
        order: of the differences.
    """
    times = np.lib.stride_tricks.sliding_window_view(time, order + 1)
    windows = np.lib.stride_tricks.sliding_window_view(values, order + 1, axis=0)
    apart = times[:, :, None] - times[:, None, :] + np.eye(order + 1)
    divided = 1.0 / apart.prod(axis=2)
    divided /= np.linalg.norm(divided, axis=1, keepdims=True)
    return np.asarray(np.matvec(windows, divided))


def correlated_share(order: int) -> float:
    """Return how many differences, which overlap, are worth one independent number: Σ ρ² over all lags."""
    correlation = np.convolve(weights(order), weights(order)[::-1])
    return float((correlation**2).sum() / correlation.max() ** 2)


def _squares(values: Array, order: int) -> Array:
    fast = np.lib.stride_tricks.sliding_window_view(values, order + 1, axis=0) @ weights(order)
    return np.asarray(fast**2)


def _length(order: int) -> float:
    """Return the squared length of the weights: what differences make of the variance of white noise."""
    return float(weights(order) @ weights(order))
