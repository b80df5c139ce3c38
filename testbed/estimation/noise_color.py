"""The colour of a channel's noise, and samples without it.

The noise of a gyro's axis, or of another column, is z_k = φ z_(k-1) + e_k + θ e_(k-1), e white: its autocorrelation at
k samples is r_1 φ^(k-1).
θ = 0 is a first-order autoregression, φ = 0 a mean of two samples, θ between 0 and -φ a sum of an autoregression and
white noise, and θ = -φ white. Samples are whitened by their innovations: what a Kalman filter of this model does not
foretell of each, over its standard deviation. Over lost samples it foretells less.

Source: Brockwell and Davis, "Time Series: Theory and Methods", 2nd ed., chapter 12 (state-space form by innovations).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Series
from testbed.estimation.recursions import accumulated

_REMEMBERED = 64
"""Filters that are kept: of as many runs as are compared again and again; a miss costs time only."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseColor:
    """How neighbouring samples of each of W columns go along: of a gyro's three axes, of the motors of its units.

    Attributes:
        persistence: φ, shape (W,), between -1 and 1.
        average: θ, shape (W,), between -1 and 1.
    """

    persistence: Array
    average: Array

    @property
    def correlation(self) -> Array:
        """Autocorrelation r_1 at one sample, shape (W,)."""
        return correlation_of(self.persistence, self.average)

    def decorrelated(self, values: Array, time: Series) -> Array:
        """Return noise made white, its variance the same, sample by sample.

        The first sample stays as it is.

        Args:
            values: of one run, shape (N, W) or (N, W, C) with derivatives by C parameters.
            time: of its samples, shape (N,), s.
        """
        filtered = self._filter(time)
        flat = values.reshape(*values.shape[:2], -1)
        carried, taken, scale = (each[:, :, None] for each in filtered)
        foretold = accumulated(
            np.broadcast_to(carried, flat.shape).reshape(1, len(values), -1),
            (taken * flat).reshape(1, len(values), -1),
        ).reshape(flat.shape)
        white = flat.copy()
        white[1:] -= foretold[:-1]
        return np.asarray((scale * white).reshape(values.shape))

    def correlated(self, white: Array, time: Series) -> Array:
        """Return white noise, shape (N, W), with this colour: the inverse of `decorrelated`; arguments as there."""
        colored = np.empty_like(white)
        foretold = np.zeros(white.shape[1])
        for index, (carried, taken, scale) in enumerate(zip(*self._filter(time), strict=True)):
            colored[index] = white[index] / scale + foretold
            foretold = carried * foretold + taken * colored[index]
        return colored

    def log_scale(self, time: Series) -> Array:
        """Return the logarithm of what the density of samples is multiplied by as against white ones, shape (W,)."""
        return np.asarray(np.log(self._filter(time).scale).sum(axis=0))

    def _filter(self, time: Series) -> _Filter:
        return _filter(self, _periods(time.tobytes()))


class _Filter(NamedTuple):
    """With m_k what is foretold of z_k: m_(k+1) = a_k m_k + b_k z_k, and s_k (z_k - m_k) has the variance of z.

    Attributes:
        carried: a, shape (N, W).
        taken: b, shape (N, W).
        scale: s, shape (N, W).
    """

    carried: Array
    taken: Array
    scale: Array


@lru_cache(maxsize=_REMEMBERED)
def _periods(time: bytes) -> tuple[int, ...]:
    """Return how many of the usual periods lie between samples at given times, as bytes of float64."""
    steps = np.diff(np.frombuffer(time))
    periods = np.maximum(np.rint(steps / np.median(steps)), 1.0) if len(steps) else steps
    return tuple(periods.astype(int).tolist())


@lru_cache(maxsize=_REMEMBERED)
def _filter(color: NoiseColor, periods: tuple[int, ...]) -> _Filter:
    """Return the filter of samples so many periods apart, one fewer than samples."""
    persistence, gain = color.persistence, color.persistence + color.average
    stationary = gain**2 / (1.0 - persistence**2)
    found = _Filter(*(np.empty((len(periods) + 1, len(persistence))) for _ in range(3)))
    variance = stationary  # of what is foretold, over that of e
    for index, period in enumerate((*periods, 1)):
        whole = variance + 1.0
        kalman = (persistence * variance + gain) / whole
        behind = persistence ** (period - 1)
        found.carried[index], found.taken[index] = behind * (persistence - kalman), behind * kalman
        found.scale[index] = np.sqrt((1.0 + stationary) / whole)
        variance = persistence**2 * variance + gain**2 - kalman**2 * whole
        variance = behind**2 * variance + (1.0 - behind**2) * stationary
    return found


def correlation_of(persistence: Array, average: Array) -> Array:
    """Return r_1 of φ and θ, arrays of one shape."""
    product = persistence * average
    return np.asarray((1.0 + product) * (persistence + average) / (1.0 + 2.0 * product + average**2))


def correlation_slopes(persistence: Array, average: Array) -> tuple[Array, Array]:
    """Return its derivatives with respect to φ and to θ."""
    product = persistence * average
    upper, lower = (1.0 + product) * (persistence + average), 1.0 + 2.0 * product + average**2
    by_persistence = (average * (persistence + average) + 1.0 + product - 2.0 * average * upper / lower) / lower
    by_average = persistence * (persistence + average) + 1.0 + product
    by_average = (by_average - 2.0 * (persistence + average) * upper / lower) / lower
    return np.asarray(by_persistence), np.asarray(by_average)
