"""The gyro's bias as it is stated to wander, beside white noise: samples without it, by a Kalman filter's innovations.

The bias is the sum of a first-order Gauss-Markov process and of a random walk from nothing at the first sample. What of
a sample its predecessors foretell is taken off, and the rest is in units of its standard deviation: of the true process
white noise of the standard deviation 1.

Sources: IEEE Std 952, appendix B (bias instability as a Markov process, rate random walk); Brockwell and Davis, "Time
Series: Theory and Methods", 2nd ed., chapter 12 (innovations).
"""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import exp, inf, sqrt

import numpy as np

from testbed.arrays import Array, Series, Vector3
from testbed.compiled import kept

_REMEMBERED = 64
"""Filters that are kept: of as many runs as are compared again and again; a miss costs time only."""


@dataclass(frozen=True, kw_only=True)
class SlowBias:
    """How a gyro's bias wanders, about each axis alike.

    Attributes:
        instability: standard deviation of the Gauss-Markov process, rad/s.
        correlation_time: of it, s; infinite for a constant that is drawn once a run.
        random_walk: rad/s/√s.
    """

    instability: float
    correlation_time: float = inf
    random_walk: float = 0.0

    def whitened(self, values: Array, time: Series, sigma: Vector3) -> Array:
        """Return samples in units of the white noise with what the bias's course foretells taken off.

        Args:
            values: of one run over σ, shape (N, 3) or (N, 3, C) with derivatives by C parameters.
            time: of its samples, shape (N,), s.
            sigma: of the white noise about each axis, shape (3,), rad/s.
        """
        return self._passed(_take_off, values, time, sigma)

    def wandering(self, white: Array, time: Series, sigma: Vector3) -> Array:
        """Return white noise with this bias: the inverse of `whitened`; arguments as there."""
        return self._passed(_put_back, white, time, sigma)

    def whitened_back(self, values: Array, time: Series, sigma: Vector3) -> Array:
        """Return the transpose of `whitened` times values; arguments as there."""
        return self._passed(_take_off_back, values, time, sigma)

    def wandering_back(self, values: Array, time: Series, sigma: Vector3) -> Array:
        """Return the transpose of `wandering` times values; arguments as there."""
        return self._passed(_put_back_back, values, time, sigma)

    def log_deviation(self, time: Series, sigma: Vector3) -> Vector3:
        """Return the logarithm of what is not foretold of all samples over σ; arguments as in `whitened`."""
        filtered, _ = _filter(self, time.tobytes(), sigma.tobytes())
        return np.asarray(np.log(filtered[:, :, 2]).sum(axis=0))

    def _passed(self, loop: Callable[..., None], values: Array, time: Series, sigma: Vector3) -> Array:
        filtered, stays = _filter(self, time.tobytes(), sigma.tobytes())
        passed = np.array(values.reshape(len(values), 3, -1), dtype=np.float64, order="C")
        kept(loop, (("f8", 3), ("f8", 1), ("f8", 3)))(filtered, stays, passed)
        return passed.reshape(values.shape)


@lru_cache(maxsize=_REMEMBERED)
def _filter(bias: SlowBias, time: bytes, sigma: bytes) -> tuple[Array, Array]:
    """Return gains of both parts and the deviation of what was not foretold, over σ, shape (N, 3, 3), by axis first.

    And the share of the Gauss-Markov process that lasts until the next sample, shape (N,).
    """
    steps = np.append(np.diff(np.frombuffer(time)), 0.0)
    filtered = np.empty((len(steps), 3, 3))
    process = np.array([bias.instability**2, 1.0 / bias.correlation_time, bias.random_walk**2])
    kept(_gains, (("f8", 1), ("f8", 1), ("f8", 1), ("f8", 3)))(steps, process, np.frombuffer(sigma) ** 2, filtered)
    return filtered, np.exp(-steps / bias.correlation_time)


def _gains(steps, process, noise, filtered):
    stationary, rate, walk = process
    for axis in range(len(noise)):
        wander, both, walked = stationary, 0.0, 0.0  # covariance of the two parts
        for sample in range(len(steps)):
            variance = wander + 2.0 * both + walked + noise[axis]
            first, second = (wander + both) / variance, (both + walked) / variance
            filtered[sample, axis, 0], filtered[sample, axis, 1] = first, second
            filtered[sample, axis, 2] = sqrt(variance / noise[axis])
            wander, walked = wander - first * (wander + both), walked - second * (both + walked)
            both -= first * second * variance
            stays = exp(-rate * steps[sample])
            wander = stays**2 * wander + (1.0 - stays**2) * stationary
            both *= stays
            walked += walk * steps[sample]


def _take_off(filtered, stays, passed):
    foretold = np.zeros((2, *passed.shape[1:]))
    for sample in range(passed.shape[0]):
        for axis in range(passed.shape[1]):
            scale = filtered[sample, axis, 2]
            for column in range(passed.shape[2]):
                rest = passed[sample, axis, column] - foretold[0, axis, column] - foretold[1, axis, column]
                passed[sample, axis, column] = rest / scale
                _foretell(foretold[:, axis, column], filtered[sample, axis], stays[sample], rest)


def _put_back(filtered, stays, passed):
    foretold = np.zeros((2, *passed.shape[1:]))
    for sample in range(passed.shape[0]):
        for axis in range(passed.shape[1]):
            for column in range(passed.shape[2]):
                rest = passed[sample, axis, column] * filtered[sample, axis, 2]
                passed[sample, axis, column] = rest + foretold[0, axis, column] + foretold[1, axis, column]
                _foretell(foretold[:, axis, column], filtered[sample, axis], stays[sample], rest)


def _take_off_back(filtered, stays, passed):
    carried = np.zeros((2, *passed.shape[1:]))
    for sample in range(passed.shape[0] - 1, -1, -1):
        for axis in range(passed.shape[1]):
            scale = filtered[sample, axis, 2]
            for column in range(passed.shape[2]):
                of_later = _carry_back(carried[:, axis, column], filtered[sample, axis], stays[sample])
                rest = passed[sample, axis, column] / scale + of_later
                passed[sample, axis, column] = rest
                carried[0, axis, column] -= rest
                carried[1, axis, column] -= rest


def _put_back_back(filtered, stays, passed):
    carried = np.zeros((2, *passed.shape[1:]))
    for sample in range(passed.shape[0] - 1, -1, -1):
        for axis in range(passed.shape[1]):
            scale = filtered[sample, axis, 2]
            for column in range(passed.shape[2]):
                value = passed[sample, axis, column]
                of_later = _carry_back(carried[:, axis, column], filtered[sample, axis], stays[sample])
                passed[sample, axis, column] = (value + of_later) * scale
                carried[0, axis, column] += value
                carried[1, axis, column] += value


def _carry_back(carried, gains, stays):
    """Bring back to a sample what later ones take of both foretold parts, and return what they take of its own rest."""
    carried[0] *= stays
    return gains[0] * carried[0] + gains[1] * carried[1]


def _foretell(parts, gains, stays, rest):
    """Bring what is foretold of both parts of a bias to the next sample."""
    parts[0] = stays * (parts[0] + gains[0] * rest)
    parts[1] += gains[1] * rest
