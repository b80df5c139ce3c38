"""The spectrum of the gyro's noise, estimated from the fast part of a residual: its level, and its colour.

The noise of an axis is a first-order autoregression, z_k = ρ z_(k-1) + e_k, of the variance v and the spectrum

    S(ω) = v (1 - ρ²) / (1 + ρ² - 2 ρ cos ω),

ω in radians a sample; ρ = 0 is white. The cosine transform of a residual has independent ordinates of these variances
(Whittle's likelihood; the transform is asymptotically the Karhunen-Loève transform of such noise). Only ordinates above
a frequency count, below which whatever the model lacks may stand. log v is the sum of a level of all samples, of one of
each axis and of each run, each with a normal prior about zero, which is what is stated; ρ of an axis has a normal prior
about zero, part of which the axes share. Whether there is colour at all is uncertain too: estimates are averaged over
both models by their posterior probability (Bayesian model averaging).

Sources: Whittle, "Estimation and information in stationary time series", Arkiv för Matematik (1953); Ahmed, Natarajan
and Rao, "Discrete cosine transform", IEEE Trans. Computers (1974).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.fft import dct

from testbed.arrays import Array, Indices, Series, Vector3

FEWEST = 24
"""Ordinates of all runs and axes without which nothing is estimated: with fewer a level is known to 30 % at best, which
is less than what is stated."""
_LARGEST = 0.9
"""Size of ρ that a search does not pass: beyond it the noise wanders, and is no longer distinguished from a motion."""
_CAP = 10.0
"""Times its variance to which an ordinate counts: noise exceeds it in 1 of 600, by which a level is 0.3 % too low; a
line, of a rotor or a mode, in a few ordinates does not pass for a level."""
_STEPS = 60
"""Fisher-scoring steps at most; from white noise 6 to 12 suffice."""
_CLOSE = 1e-6
"""Change of every parameter after which no further step is taken: far below any standard error."""
_LONGEST = 0.3
"""Longest step of ρ: the likelihood is quadratic over about that."""


@dataclass(frozen=True, kw_only=True)
class SpectrumPrior:
    """What is known of a noise spectrum a priori, as standard deviations of normal distributions about what is stated.

    Attributes:
        level: of log v, of all samples together.
        deviation: of what an axis and a run add to it.
        correlation: of ρ, of what all axes share.
        correlation_deviation: of what an axis adds to it.
        color: probability that there is any.
        slowest: frequency above which ordinates count, Hz.
        share_of_rate: share of the sample rate at which they count in any case.
        most_power: mean square of the ordinates, over what is stated, beyond which they are something else than noise.
    """

    level: float
    deviation: float
    correlation: float
    correlation_deviation: float
    color: float
    slowest: float
    share_of_rate: float
    most_power: float


@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseSpectrum:
    """Level and colour of a gyro's noise, against what is stated.

    Attributes:
        variance_ratio: of each run and axis, over what is stated, shape (R, 3).
        correlation: ρ of each axis, shape (3,), averaged over a model with colour and one without.
        color: mean ρ of the axes if there is colour.
        color_std: its standard error.
        freedom: degrees of freedom with which the spectrum below the ordinates that count is known.
    """

    variance_ratio: Array
    correlation: Vector3
    color: float
    color_std: float
    freedom: float

    def decorrelated(self, values: Array, time: Series) -> Array:
        """Return samples of one run as if the noise had no colour; see the function of this name."""
        return decorrelated(values, time, self.correlation)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Ordinates:
    """Squares of the cosine transforms of all runs and axes, with their angular frequency, run and axis."""

    square: Array
    angle: Array
    columns: Array
    axis: Indices

    def log_shape(self, correlation: Vector3) -> Array:
        rho = correlation[self.axis]
        return np.asarray(np.log1p(-(rho**2)) - np.log(1.0 + rho**2 - 2.0 * rho * np.cos(self.angle)))


def noise_spectrum(whitened: Sequence[Array], times: Sequence[Series], prior: SpectrumPrior) -> NoiseSpectrum | None:
    """Return the spectrum of the noise in residuals; None of too few samples, or where they are no noise.

    Args:
        whitened: residual of each run over the stated standard deviation, shape (N, 3).
        times: of its samples, shape (N,), s.
        prior: of the spectrum.
    """
    ordinates = _ordinates(whitened, times, prior)
    if len(ordinates.square) < FEWEST or ordinates.square.mean() > prior.most_power:
        return None
    runs = len(whitened)
    colored, square = _posterior(ordinates, runs, prior, colored=True)
    white, _ = _posterior(ordinates, runs, prior, colored=False, square=square)
    odds = np.exp(np.clip(colored.log_evidence - white.log_evidence, -_SURE, _SURE)) * prior.color / (1.0 - prior.color)
    share = float(odds / (1.0 + odds))
    period = float(np.median(np.concatenate([np.diff(time) for time in times])))
    low = np.concatenate([_low_frequency(each, runs, pi * prior.slowest * period)[None] for each in (colored, white)])
    spread = low[0, 1] * share + low[1, 1] * (1.0 - share) + share * (1.0 - share) * (low[0, 0] - low[1, 0]) ** 2
    mean = share * colored.mean + (1.0 - share) * white.mean
    contrast = np.full(3, 1.0 / 3.0)
    return NoiseSpectrum(
        variance_ratio=np.exp(mean[0] + mean[_AXES][None] + mean[4:-3, None]),
        correlation=mean[-3:],
        color=float(contrast @ colored.mean[-3:]),
        color_std=float(np.sqrt(contrast @ colored.covariance[-3:, -3:] @ contrast)),
        freedom=float(2.0 / spread),
    )


_AXES = slice(1, 4)
"""Where the axes' levels stand among the parameters: that of all samples, the axes', the runs', and ρ of the axes."""
_SURE = 50.0
"""Logarithm of the odds beyond which nothing changes."""


def _ordinates(whitened: Sequence[Array], times: Sequence[Series], prior: SpectrumPrior) -> _Ordinates:
    squares, angles, runs, axes = [], [], [], []
    for run, (values, time) in enumerate(zip(whitened, times, strict=True)):
        number, period = np.arange(len(values)), float(np.median(np.diff(time)))
        slowest = min(prior.slowest, prior.share_of_rate / period)
        fast = number > 2.0 * slowest * period * len(values)  # of half periods in the run
        count = int(fast.sum())
        squares.append((dct(values, axis=0, norm="ortho")[fast] ** 2).T.ravel())
        angles.append(np.tile(pi * number[fast] / len(values), 3))
        axes.append(np.repeat(np.arange(3), count))
        runs.append(np.full(3 * count, run))
    axis, run_of = np.concatenate(axes), np.concatenate(runs)
    columns = np.column_stack([np.ones(len(axis)), np.eye(3)[axis], np.eye(len(whitened))[run_of]])
    return _Ordinates(square=np.concatenate(squares), angle=np.concatenate(angles), columns=columns, axis=axis)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Posterior:
    """Of all parameters, ρ of white noise being zero without uncertainty: mean (P,), covariance (P, P)."""

    mean: Array
    covariance: Array
    log_evidence: float


def _posterior(
    ordinates: _Ordinates, runs: int, prior: SpectrumPrior, *, colored: bool, square: Array | None = None
) -> tuple[_Posterior, Array]:
    """Return the posterior by Fisher scoring (Laplace), and the ordinates' squares as they counted.

    Args:
        ordinates: of all runs.
        runs: R.
        prior: of the spectrum.
        colored: whether ρ is free.
        square: as they count; None to cap them by the spectrum that is found.
    """
    precision = _precision(runs, prior)
    free = np.arange(len(precision)) < len(precision) - (0 if colored else 3)
    precision = precision[np.ix_(free, free)]
    mean, counted = np.zeros(runs + 7), ordinates.square
    mean[0] = np.log(np.median(ordinates.square) / _MEDIAN)
    for _ in range(_STEPS):
        log_power = ordinates.columns @ mean[:-3] + ordinates.log_shape(mean[-3:])
        counted = np.minimum(ordinates.square, _CAP * np.exp(log_power)) if square is None else square
        slopes = _slopes(ordinates, mean[-3:])[:, free]
        information = 0.5 * slopes.T @ slopes + precision
        gradient = 0.5 * slopes.T @ (counted * np.exp(-log_power) - 1.0) - precision @ mean[free]
        step = np.linalg.solve(information, gradient)
        step *= min(1.0, _LONGEST / max(np.abs(step).max(), np.finfo(float).tiny))
        mean[free] += step
        mean[-3:] = np.clip(mean[-3:], -_LARGEST, _LARGEST)
        if np.abs(step).max() < _CLOSE:
            break
    log_power = ordinates.columns @ mean[:-3] + ordinates.log_shape(mean[-3:])
    log_likelihood = -0.5 * float((log_power + counted * np.exp(-log_power)).sum())
    determinants = np.linalg.slogdet(precision)[1] - np.linalg.slogdet(information)[1]
    covariance = np.zeros((len(free), len(free)))
    covariance[np.ix_(free, free)] = np.linalg.inv(information)
    prior_log = -0.5 * float(mean[free] @ precision @ mean[free])
    evidence = log_likelihood + prior_log + 0.5 * float(determinants)
    return _Posterior(mean=mean, covariance=covariance, log_evidence=evidence), counted


_MEDIAN = 0.4549364
"""Of the square of a normal number of variance 1."""


def _precision(runs: int, prior: SpectrumPrior) -> Array:
    """Return the inverse of the prior covariance, shape (R + 7, R + 7)."""
    levels = np.array([prior.level, *[prior.deviation] * (3 + runs)])
    precision = np.zeros((runs + 7, runs + 7))
    precision[:-3, :-3] = np.diag(levels**-2)
    shared, own = prior.correlation**2, prior.correlation_deviation**2
    precision[-3:, -3:] = np.linalg.inv(shared * np.ones((3, 3)) + own * np.eye(3))
    return precision


def _slopes(ordinates: _Ordinates, correlation: Vector3) -> Array:
    """Return ∂ log S / ∂ parameters at the ordinates, shape (M, R + 7)."""
    slope = _slope(correlation[ordinates.axis], ordinates.angle)
    return np.hstack([ordinates.columns, slope[:, None] * np.eye(3)[ordinates.axis]])


def _slope(rho: Array, angle: Array | float) -> Array:
    """Return ∂ log S / ∂ρ."""
    return np.asarray(
        -2.0 * rho / (1.0 - rho**2) - (2.0 * rho - 2.0 * np.cos(angle)) / (1.0 + rho**2 - 2.0 * rho * np.cos(angle))
    )


def _low_frequency(posterior: _Posterior, runs: int, angle: float) -> Array:
    """Return mean and variance of the logarithm of the spectrum, of all axes and runs, at an angular frequency."""
    rho = posterior.mean[-3:]
    shape = np.log1p(-(rho**2)) - np.log(1.0 + rho**2 - 2.0 * rho * np.cos(angle))
    contrast = np.concatenate([[1.0], np.full(3, 1.0 / 3.0), np.full(runs, 1.0 / runs), _slope(rho, angle) / 3.0])
    level = contrast[:-3] @ posterior.mean[:-3] + shape.mean()
    return np.array([level, contrast @ posterior.covariance @ contrast])


def decorrelated(values: Array, time: Series, correlation: Vector3) -> Array:
    """Return noise with a colour made white, its variance the same, sample by sample.

    Over a gap of k periods ρ counts as ρ^k; the first sample stays as it is.

    Args:
        values: of one run, shape (N, 3) or (N, 3, C) of C columns.
        time: of its samples, shape (N,), s.
        correlation: ρ of each axis, shape (3,).
    """
    own, before = _filter(time, correlation)
    shape = (-1, 3, *[1] * (values.ndim - 2))
    white = own.reshape(shape) * values
    white[1:] -= before[1:].reshape(shape) * values[:-1]
    return np.asarray(white)


def correlated(values: Array, time: Series, correlation: Vector3) -> Array:
    """Return white noise with a colour, the inverse of `decorrelated`; arguments as there, shape (N, 3)."""
    own, before = _filter(time, correlation)
    colored = np.empty_like(values)
    last = np.zeros(3)
    for index, white in enumerate(values):
        last = (white + before[index] * last) / own[index]
        colored[index] = last
    return colored


def _filter(time: Series, correlation: Vector3) -> tuple[Array, Array]:
    """Return what a sample and the one before it count in the white noise, shapes (N, 3)."""
    steps = np.diff(time)
    periods = np.maximum(np.rint(steps / np.median(steps)), 1.0)
    with_last = np.vstack(
        [np.zeros(3), np.sign(correlation) ** periods[:, None] * np.abs(correlation) ** periods[:, None]]
    )
    own = 1.0 / np.sqrt(1.0 - with_last**2)
    return own, with_last * own
