"""What torque a body is under that nobody commanded, from the residuals of many short windows.

Draughts, propellers and motors that do not do quite what they are asked turn a body by more than a gyro's noise. Of a
window whose initial rate is free, the rate's residual at the time t after its first sample has the covariance

    C(t, t') = s² δ(t, t') + q² min(t, t') + a² t t'

per axis: white noise of the samples, an angular acceleration that is white, and one that is constant in the window.
Source: Maybeck, "Stochastic Models, Estimation, and Control", vol. 1 (1979), section 4.5, for the second term.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from scipy.linalg.lapack import dpotrf, dpotrs

from testbed.arrays import Array, Series

_LEAST = 0.05
"""Share of the largest part of the scatter of single samples that their white noise has at least: it keeps covariances
away from singular ones, and is far below what the fastest changes of any gyro show."""
_STARTS = ((0.9, 0.3, 0.3), (0.3, 0.9, 0.3))
"""Shares of the scatter that the three parts begin with; both lead to the same end where the windows show it."""
_EVALUATIONS = 400
"""Of the likelihood at most: three unknowns are found to per cents in about 150."""


def torque_noise(times: Sequence[Series], residuals: Sequence[Array]) -> Array:
    """Return s, rad/s, q, rad/s per √s, and a, rad/s², of each axis by maximum likelihood, shape (3, 3).

    Args:
        times: of the samples of every window, shapes (N,), s; windows of the most frequent length are used.
        residuals: of the body rate in each, shapes (N, 3), rad/s.
    """
    lengths = [len(time) for time in times]
    usual = max(set(lengths), key=lengths.count)
    windows = np.stack([residual for residual in residuals if len(residual) == usual])
    time = np.median([time - time[0] for time in times if len(time) == usual], axis=0)
    # Contrasts, which no initial rate changes.
    contrasts = np.linalg.svd(np.ones((1, usual)))[2][1:]
    parts = [contrasts @ part @ contrasts.T for part in _parts(time)]
    return np.stack([_of_axis(parts, contrasts @ windows[:, :, axis].T, time) for axis in range(3)])


def covariance(time: Series, noise: Array) -> Array:
    """Return C of one window for every axis, shape (3, N, N), (rad/s)².

    Args:
        time: of its samples, shape (N,), s.
        noise: as `torque_noise`, shape (3, 3).
    """
    return np.asarray(np.einsum("ak,kmn->amn", noise**2, np.stack(_parts(time - time[0]))))


def _parts(time: Series) -> list[Array]:
    return [np.eye(len(time)), np.minimum.outer(time, time), np.outer(time, time)]


def _of_axis(parts: Sequence[Array], samples: Array, time: Series) -> Array:
    """Return s, q and a from contrasts of shape (N - 1, W)."""
    scatter = samples @ samples.T / samples.shape[1]
    whole = float(np.sqrt(np.trace(scatter) / len(scatter))) + np.finfo(float).tiny
    scale = whole / np.array([1.0, np.sqrt(time[-1]), time[-1]])

    white, walk, line = parts
    least = (_LEAST * whole) ** 2 * np.eye(len(scatter))

    def surprise(logarithms: Array) -> float:
        s, q, a = scale * np.exp(logarithms)
        # By LAPACK itself: for matrices of five rows all else takes ten times as long.
        factor, failed = dpotrf(s**2 * white + q**2 * walk + a**2 * line + least)
        if failed:
            return np.inf
        solved, _ = dpotrs(factor, scatter)
        return float(2.0 * np.log(factor.diagonal()).sum() + solved.trace())

    found = [
        scipy.optimize.minimize(surprise, np.log(start), method="Nelder-Mead", options={"maxfev": _EVALUATIONS})
        for start in _STARTS
    ]
    sizes = scale * np.exp(min(found, key=lambda each: each.fun).x)
    sizes[0] = np.hypot(sizes[0], _LEAST * whole)
    return np.asarray(sizes)
