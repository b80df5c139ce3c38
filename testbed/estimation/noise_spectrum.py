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
from scipy.linalg import block_diag

from testbed.arrays import Array, Flags, Indices, Series, Vector3
from testbed.estimation.differences import CHI_SQUARE_MEDIAN

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
_SURE = 50.0
"""Logarithm of the odds beyond which nothing changes."""
_WIDTH = 3
"""Axes."""


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
        variance_ratio: of each run and axis, over what is stated, shape (R, 3); of an axis without samples a priori.
        correlation: ρ of each axis, shape (3,), averaged over a model with colour and one without; likewise.
        color: mean ρ of the axes with samples if there is colour.
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
    """Squares of the cosine transforms of all runs and axes.

    Attributes:
        square: shape (M,).
        angle: angular frequency, radians a sample, shape (M,).
        axis: shape (M,).
        cell: run and axis, shape (M,).
        columns: ∂ log v of each cell / ∂ levels of all samples, of the axes and of the runs, shape (3 R, R + 4).
        seen: which axes have samples, shape (3,).
    """

    square: Array
    angle: Array
    axis: Indices
    cell: Indices
    columns: Array
    seen: Flags

    def log_power(self, parameters: Array) -> Array:
        """Return log S at the ordinates, shape (M,)."""
        levels, correlation = parameters[:-_WIDTH], parameters[-_WIDTH:]
        return np.asarray((self.columns @ levels)[self.cell] + _log_shape(correlation[self.axis], self.angle))

    def gradient(self, parameters: Array, excess: Array) -> Array:
        """Return ½ Σ excess ∂ log S / ∂ parameters, shape (P,).

        Args:
            parameters: of the spectrum.
            excess: squares over their variance, less 1, shape (M,).
        """
        slope = _slope(parameters[-_WIDTH:][self.axis], self.angle)
        own = np.bincount(self.axis, slope * excess, _WIDTH)
        return 0.5 * np.concatenate([self.columns.T @ self._summed(excess), own])

    def information(self, parameters: Array) -> Array:
        """Return ½ Σ ∂ log S ∂ log Sᵀ, Fisher's information, shape (P, P)."""
        slope = _slope(parameters[-_WIDTH:][self.axis], self.angle)
        levels = self.columns.T @ (self._summed(np.ones_like(slope))[:, None] * self.columns)
        axes = np.tile(np.eye(_WIDTH), (len(self.columns) // _WIDTH, 1))
        across = self.columns.T @ (self._summed(slope)[:, None] * axes)
        own = np.diag(np.bincount(self.axis, slope**2, _WIDTH))
        return 0.5 * np.block([[levels, across], [across.T, own]])

    def _summed(self, values: Array) -> Array:
        return np.asarray(np.bincount(self.cell, values, len(self.columns)), dtype=np.float64)


def noise_spectrum(
    whitened: Sequence[Array], times: Sequence[Series], prior: SpectrumPrior, live: Flags | None = None
) -> NoiseSpectrum | None:
    """Return the spectrum of the noise in residuals; None of too few samples, or where they are no noise.

    Args:
        whitened: residual of each run over the stated standard deviation, shape (N, 3).
        times: of its samples, shape (N,), s.
        prior: of the spectrum.
        live: which axes of each run are samples of a gyro, shape (R, 3); None of a platform that turns freely.
    """
    ordinates = _ordinates(
        whitened, times, prior, np.ones((len(whitened), _WIDTH), dtype=bool) if live is None else live
    )
    if len(ordinates.square) < FEWEST or ordinates.square.mean() > prior.most_power:
        return None
    runs = len(whitened)
    colored = _posterior(ordinates, _precision(runs, prior))
    white = _posterior(ordinates, _precision(runs, prior), square=colored.square)
    odds = np.exp(np.clip(colored.log_evidence - white.log_evidence, -_SURE, _SURE)) * prior.color / (1.0 - prior.color)
    share = float(odds / (1.0 + odds))
    mean = share * colored.mean + (1.0 - share) * white.mean
    period = float(np.median(np.concatenate([np.diff(time) for time in times])))
    slow = pi * prior.slowest * period  # in the middle of what is below the ordinates
    (low, spread), (white_low, white_spread) = (
        _low_frequency(each, ordinates.seen, runs, slow) for each in (colored, white)
    )
    variance = share * spread + (1.0 - share) * white_spread + share * (1.0 - share) * (low - white_low) ** 2
    of_axes = colored.covariance[-_WIDTH:, -_WIDTH:][np.ix_(ordinates.seen, ordinates.seen)]
    return NoiseSpectrum(
        variance_ratio=np.exp(mean[0] + mean[1 : 1 + _WIDTH] + mean[1 + _WIDTH : -_WIDTH, None]),
        correlation=mean[-_WIDTH:],
        color=float(colored.mean[-_WIDTH:][ordinates.seen].mean()),
        color_std=float(np.sqrt(of_axes.mean())),
        freedom=2.0 / variance,
    )


def _ordinates(whitened: Sequence[Array], times: Sequence[Series], prior: SpectrumPrior, live: Flags) -> _Ordinates:
    squares, angles, cells = [], [], []
    for run, (values, time, own) in enumerate(zip(whitened, times, live, strict=True)):
        number, period = np.arange(len(values)), float(np.median(np.diff(time)))
        slowest = min(prior.slowest, prior.share_of_rate / period)
        fast = number > 2.0 * slowest * period * len(values)  # of half periods in the run
        count = int(fast.sum())
        squares.append((dct(values[:, own], axis=0, norm="ortho")[fast] ** 2).T.ravel())
        angles.append(np.tile(pi * number[fast] / len(values), int(own.sum())))
        cells.append(_WIDTH * run + np.repeat(np.flatnonzero(own), count))
    cell, runs = np.concatenate(cells), len(whitened)
    every = np.arange(_WIDTH * runs)
    return _Ordinates(
        square=np.concatenate(squares),
        angle=np.concatenate(angles),
        axis=cell % _WIDTH,
        cell=cell,
        columns=np.column_stack([np.ones(len(every)), np.eye(_WIDTH)[every % _WIDTH], np.eye(runs)[every // _WIDTH]]),
        seen=np.any(live, axis=0),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Posterior:
    """Of the parameters: log v of all samples, of each axis and each run, ρ of each axis; zero where noise is white.

    Attributes:
        mean: shape (P,).
        covariance: shape (P, P).
        log_evidence: logarithm of the data's probability, up to what both models share.
        square: the ordinates' squares as they counted.
    """

    mean: Array
    covariance: Array
    log_evidence: float
    square: Array


def _posterior(ordinates: _Ordinates, precision: Array, square: Array | None = None) -> _Posterior:
    """Return the posterior by Fisher scoring (Laplace): of noise with a colour, or of white noise.

    Args:
        ordinates: of all runs.
        precision: of the prior.
        square: as they count for white noise; None for noise with a colour, whose spectrum caps them.
    """
    colored = square is None
    free = np.arange(len(precision)) < len(precision) - (0 if colored else _WIDTH)
    own = precision[np.ix_(free, free)]
    mean = np.zeros(len(precision))
    mean[0] = np.log(np.median(ordinates.square) / CHI_SQUARE_MEDIAN)
    for _ in range(_STEPS):
        log_power = ordinates.log_power(mean)
        counted = np.minimum(ordinates.square, _CAP * np.exp(log_power)) if square is None else square
        information = ordinates.information(mean)[np.ix_(free, free)] + own
        gradient = ordinates.gradient(mean, counted * np.exp(-log_power) - 1.0)[free] - own @ mean[free]
        step = np.linalg.solve(information, gradient)
        step *= min(1.0, _LONGEST / max(np.abs(step).max(), np.finfo(float).tiny))
        mean[free] += step
        mean[-_WIDTH:] = np.clip(mean[-_WIDTH:], -_LARGEST, _LARGEST)
        if np.abs(step).max() < _CLOSE:
            break
    log_power = ordinates.log_power(mean)
    squares = (log_power + counted * np.exp(-log_power)).sum() + mean[free] @ own @ mean[free]
    determinants = np.linalg.slogdet(own)[1] - np.linalg.slogdet(information)[1]
    covariance = np.zeros_like(precision)
    covariance[np.ix_(free, free)] = np.linalg.inv(information)
    evidence = 0.5 * float(determinants - squares)
    return _Posterior(mean=mean, covariance=covariance, log_evidence=evidence, square=counted)


def _precision(runs: int, prior: SpectrumPrior) -> Array:
    """Return the inverse of the prior covariance of the parameters, P = R + 7, shape (P, P)."""
    levels = np.array([prior.level, *[prior.deviation] * (_WIDTH + runs)])
    shared, own = prior.correlation**2, prior.correlation_deviation**2
    correlations = shared * np.ones((_WIDTH, _WIDTH)) + own * np.eye(_WIDTH)
    return np.asarray(block_diag(np.diag(levels**-2), np.linalg.inv(correlations)))


def _log_shape(rho: Array, angle: Array | float) -> Array:
    """Return log S of the variance 1."""
    return np.asarray(np.log1p(-(rho**2)) - np.log(1.0 + rho**2 - 2.0 * rho * np.cos(angle)))


def _slope(rho: Array, angle: Array | float) -> Array:
    """Return its derivative with respect to ρ."""
    return np.asarray(
        -2.0 * rho / (1.0 - rho**2) - (2.0 * rho - 2.0 * np.cos(angle)) / (1.0 + rho**2 - 2.0 * rho * np.cos(angle))
    )


def _low_frequency(posterior: _Posterior, seen: Flags, runs: int, angle: float) -> tuple[float, float]:
    """Return mean and variance of the logarithm of the spectrum, of axes with samples and runs, at a frequency."""
    rho = posterior.mean[-_WIDTH:]
    slope = np.where(seen, _slope(rho, angle), 0.0) / seen.sum()
    contrast = np.concatenate([[1.0], seen / seen.sum(), np.full(runs, 1.0 / runs), slope])
    level = contrast[:-_WIDTH] @ posterior.mean[:-_WIDTH] + _log_shape(rho, angle)[seen].mean()
    return float(level), float(contrast @ posterior.covariance @ contrast)


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
