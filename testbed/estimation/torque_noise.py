"""What torque a body is under that nobody commanded, from the residuals of many short windows.

Draughts, propellers and motors that do not do quite what they are asked turn a body by more than a gyro's noise. Of a
window whose initial rate is free, the rate's residual at the time t after its first sample has the covariance

    C(t, t') = s² δ(t, t') + q² min(t, t') + b² K(t, t'; T) + a² t t'

per axis: white noise of the samples, an angular acceleration that is white, one that is forgotten with a time constant
T (a Gauss-Markov process of first order, K the covariance of its integral), and one that is constant in the window.
Source: Maybeck, "Stochastic Models, Estimation, and Control", vol. 1 (1979), sections 4.5 and 4.11.

A controller answers what turns a body, so that its commands go along with such a torque, and the noise decides how much
of the answer passes for what the actuators do (Ljung, "System Identification" (1999), section 13.4): of a simulated
quadcopter in gusts of 0.25 s the motors seemed late by 64 ms, not by 37, where noise was white or constant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Array, Flags, Series

_SIZES = 4
"""Numbers of an axis that are sizes, s, q, b and a; T follows them."""
_CORRELATED = 2
"""Which of them forgets."""
_LEAST = 0.01
"""Share of the largest part of the scatter of single samples that their white noise has at least: it keeps covariances
away from singular ones, and is far below what the fastest changes of any gyro show."""
_STARTS = ((0.9, 0.3, 0.3, 0.3), (0.3, 0.9, 0.3, 0.3), (0.3, 0.3, 0.9, 0.3))
"""Shares of the scatter that the four parts begin with; all lead to the same end where the windows show it."""
_ROUNDS = 60
"""Steps of a search at most; 10 to 30 find it."""
_FOUND = 1e-3
"""What twice the logarithm of the likelihood may still gain when a search ends."""
_LONGEST = 1.0
"""Largest step of the logarithm of T: where what forgets is hardly there, its slope points anywhere."""
_DAMPING, _DAMPED = (1e-6, 1e6), 1e-3
"""Least and greatest Levenberg-Marquardt damping, in shares of the information's diagonal, and the least after a step
that gains nothing. Source: chosen; from everywhere the same end is reached, at other speed."""


def torque_noise(
    times: Sequence[Series], residuals: Sequence[Array], least: Array | None = None, begun: Array | None = None
) -> Array:
    """Return s, rad/s, q, rad/s per √s, b and a, rad/s², and T, s, of each axis by maximum likelihood, shape (3, 5).

    Args:
        times: of the samples of every window, shapes (N,), s; windows of the most frequent length are used.
        residuals: of the body rate in each, shapes (N, 3), rad/s.
        least: sizes that there are at least, and T, shape (3, 5); none where None.
        begun: noise of nearly the same residuals, shape (3, 5), where the search begins; several starts where None.
    """
    lengths = [len(time) for time in times]
    usual = max(set(lengths), key=lengths.count)
    windows = np.stack([residual for residual in residuals if len(residual) == usual])
    time = np.median([time - time[0] for time in times if len(time) == usual], axis=0)
    # Contrasts, which no initial rate changes.
    contrasts = np.linalg.svd(np.ones((1, usual)))[2][1:]
    axes = [_Axis(time, contrasts, windows[:, :, axis]) for axis in range(3)]
    near = [None] * len(axes) if begun is None else list(begun)
    forgotten = [None] * len(axes) if least is None else [float(own[-1]) for own in least]
    known = zip(axes, forgotten, near, strict=True)
    found = np.stack([axis.likeliest(time_constant, one) for axis, time_constant, one in known])
    return found if least is None else found.clip(min=least)


def covariance(time: Series, noise: Array) -> Array:
    """Return C of windows for every axis, shape (..., 3, N, N), (rad/s)².

    Args:
        time: of their samples, shape (..., N), s.
        noise: as `torque_noise`, shape (3, 5).
    """
    parts = (_parts(time - time[..., :1], own[_SIZES]) for own in noise)
    axes = [np.einsum("k,k...->...", own[:_SIZES] ** 2, each) for own, each in zip(noise, parts, strict=True)]
    return np.stack(axes, axis=-3)


def _parts(time: Array, forgotten: float) -> Array:
    """Return the parts of C of size one, shape (4, ..., N, N), of times of shape (..., N)."""
    row, column = time[..., :, None], time[..., None, :]
    early = np.minimum(row, column)
    integrated = forgotten * (2.0 * early - _turned(time, forgotten))
    return np.stack([np.broadcast_to(np.eye(time.shape[-1]), early.shape), early, integrated, row * column])


def _by_forgetting(time: Series, forgotten: float) -> Array:
    """Return the slope of the third part by the logarithm of T, shape (N, N)."""
    early, since = np.minimum.outer(time, time), np.abs(np.subtract.outer(time, time))
    kept = time * np.exp(-time / forgotten)
    turned = 2.0 * (early - _turned(time, forgotten))
    return np.asarray(forgotten * (turned + np.add.outer(kept, kept) - since * np.exp(-since / forgotten)))


def _turned(time: Array, forgotten: float) -> Array:
    """Return T (1 - exp(-t/T) - exp(-t'/T) + exp(-|t - t'|/T)), shape (..., N, N), s."""
    kept, since = np.exp(-time / forgotten), np.abs(time[..., :, None] - time[..., None, :])
    return np.asarray(forgotten * (1.0 - kept[..., :, None] - kept[..., None, :] + np.exp(-since / forgotten)))


class _Axis:
    """Contrasts of the windows about one axis: how likely a noise makes them, and which one does it most."""

    def __init__(self, time: Series, contrasts: Array, windows: Array) -> None:
        """Take windows of shape (W, N) at the times of shape (N,), s, and contrasts, shape (N - 1, N)."""
        self._time, self._contrasts, self._count = time, contrasts, len(windows)
        samples = windows @ contrasts.T
        self._scatter = samples.T @ samples / self._count
        self._whole = float(np.sqrt(np.trace(self._scatter) / len(contrasts))) + np.finfo(float).tiny
        self._scale = self._whole / np.array([1.0, np.sqrt(time[-1]), time[-1], time[-1]])
        self._reach = np.log([time[1], time[-1]])

    def likeliest(self, forgotten: float | None, begun: Array | None = None) -> Array:
        """Return s, q, b, a and T, shape (5,); T is searched for between a sample and a window unless it is given."""
        middle = float(np.mean(self._reach)) if forgotten is None else np.log(forgotten)
        free = np.append(np.ones(_SIZES, dtype=bool), forgotten is None)
        starts = [np.append(np.square(start), middle) for start in _STARTS]
        if begun is not None:
            time = np.clip(np.log(begun[_SIZES]), *self._reach) if forgotten is None else middle
            starts = [np.append(np.square(begun[:_SIZES] / self._scale), time)]
        best = min((self._search(start, free) for start in starts), key=lambda each: each[1])[0]
        sizes = self._scale * np.sqrt(best[:_SIZES])
        sizes[0] = np.hypot(sizes[0], _LEAST * self._whole)
        return np.append(sizes, np.exp(best[_SIZES]))

    def _search(self, point: Array, free: Flags) -> tuple[Array, float]:
        """Return squares of the sizes in their scale and the logarithm of T, and the surprise there.

        Scoring by Fisher's method, damped; a size at zero comes back where more of it would surprise less.
        """
        lower, upper = np.append(np.zeros(_SIZES), self._reach[0]), np.append(np.full(_SIZES, np.inf), self._reach[1])
        damping, (surprise, slope, information) = _DAMPING[0], self._surprise(point)
        for _ in range(_ROUNDS):
            moving = free & ~((point <= lower) & (slope > 0.0)) & ~((point >= upper) & (slope < 0.0))
            step = _step(slope, information, moving, damping)
            if -slope @ step * self._count < _FOUND or damping > _DAMPING[1]:
                break
            there = np.where(free, np.clip(point + step, lower, upper), point)
            trial = self._surprise(there)
            if trial[0] < surprise:
                point, (surprise, slope, information), damping = there, trial, max(0.1 * damping, _DAMPING[0])
            else:
                damping = max(10.0 * damping, _DAMPED)
        return point, surprise

    def _surprise(self, point: Array) -> tuple[float, Array, Array]:
        """Return log det C + tr C⁻¹ S of the scatter S, its slope, shape (5,), and Fisher's information, (5, 5)."""
        time, forgotten, squares = self._time, float(np.exp(point[_SIZES])), self._scale**2
        by_time = point[_CORRELATED] * squares[_CORRELATED] * _by_forgetting(time, forgotten)
        scaled = [*(squares[:, None, None] * _parts(time, forgotten)), by_time]
        slopes = self._contrasts @ np.stack(scaled) @ self._contrasts.T
        whole = np.einsum("k,kmn->mn", point[:_SIZES], slopes[:_SIZES])
        whole[np.diag_indices_from(whole)] += (_LEAST * self._whole) ** 2
        inverse = np.linalg.inv(whole)
        ahead, residual = inverse @ slopes, inverse @ self._scatter
        slope = np.trace(ahead, axis1=1, axis2=2) - np.einsum("kmn,nm->k", ahead, residual)
        information = np.einsum("kmn,lnm->kl", ahead, ahead)
        return float(np.linalg.slogdet(whole)[1] + np.trace(residual)), slope, information


def _step(slope: Array, information: Array, moving: Flags, damping: float) -> Array:
    """Return the step to the least surprise, of T no longer than `_LONGEST`; none along what changes nothing."""
    shown = moving & (np.diag(information) > 0.0)
    scale = np.sqrt(np.diag(information)[shown])
    scaled = information[np.ix_(shown, shown)] / np.outer(scale, scale) + damping * np.eye(len(scale))
    step = np.zeros(len(slope))
    step[shown] = -np.linalg.lstsq(scaled, slope[shown] / scale, rcond=None)[0] / scale
    return np.asarray(step * min(1.0, _LONGEST / max(abs(step[_SIZES]), np.finfo(float).tiny)))
