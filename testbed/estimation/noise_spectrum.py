"""The spectrum of the gyro's noise, estimated from the fast part of a residual: its level, and its colour.

The noise of an axis, z_k = φ z_(k-1) + e_k + θ e_(k-1) (`noise_color`), of the variance v, has the spectrum

    S(ω) = v (1 - φ²) / (1 + 2 φ θ + θ²) (1 + θ² + 2 θ cos ω) / (1 + φ² - 2 φ cos ω),

ω in radians a sample. The cosine transform of a residual has independent ordinates of these variances (Whittle's
likelihood; the transform is asymptotically the Karhunen-Loève transform of such noise). Only ordinates above a
frequency count, below which whatever the model lacks may stand. log v is the sum of a level of all samples, of one of
each axis and of each run, each with a normal prior about zero, which is what is stated. φ and φ + θ of an axis, which
has the sign of the correlation of neighbours, have normal priors about zero, part of which the axes share. Whether
noise is white, an autoregression (θ = 0) or has both parameters is uncertain too: estimates are averaged over the three
models by their posterior probability (Bayesian model averaging).

Sources: Whittle, "Estimation and information in stationary time series", Arkiv för Matematik (1953); Ahmed, Natarajan
and Rao, "Discrete cosine transform", IEEE Trans. Computers (1974).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, log, pi, sqrt

import numpy as np
import scipy
from scipy.fft import dct
from scipy.linalg import block_diag
from scipy.special import softmax

from testbed.arrays import Array, Flags, Indices, Series
from testbed.estimation.differences import CHI_SQUARE_MEDIAN
from testbed.estimation.noise_color import NoiseColor, correlation_of, correlation_slopes

FEWEST = 24
"""Ordinates of all runs and axes without which nothing is estimated: with fewer a level is known to 30 % at best, which
is less than what is stated."""
_LARGEST = 0.9
"""Size of φ, and of θ, that a search does not pass: beyond it the noise wanders, and is no longer distinguished from a
motion."""
_FEWEST_FREEDOM = 3.0
"""Degrees of freedom that are reported at least, also where less is known: at 2 the mean of F, ν/(ν - 2), with which a
misfit is compared, is infinite."""
_CAP = 10.0
"""Times its variance to which an ordinate counts: noise exceeds it in 1 of 600, by which a level is 0.3 % too low; a
line, of a rotor or a mode, in a few ordinates does not pass for a level."""
_MOST_LINES = 3
"""Frequencies that are left out at most: what has more is not the noise of a gyro with a hum."""
_LINE_CHANCE = 0.01
"""p-value of a frequency that stands out, times the frequencies that are resolved, below which it is a line: of a
hundred sets without one the loudest band of one is left out, by which a level falls by a few percent."""
_STEPS = 60
"""Fisher-scoring steps at most; they stop where the posterior no longer grows."""
_HALVINGS = 20
"""Of a step, after which it is a millionth of what it was."""
_CLOSE = 1e-6
"""Change of every parameter after which no further step is taken: far below any standard error."""
_LONGEST = 0.3
"""Longest step of any parameter: the likelihood is quadratic over about that."""
_WIDTH = 3
"""Axes."""
_COLORS = 2 * _WIDTH
"""Parameters of the colour: φ of each axis, then θ."""


@dataclass(frozen=True, kw_only=True)
class SpectrumPrior:
    """What is known of a noise spectrum a priori, as standard deviations of normal distributions about what is stated.

    Attributes:
        level: of log v, of all samples together.
        deviation: of what an axis and a run add to it.
        correlation: of φ + θ, of what all axes share.
        correlation_deviation: of what an axis adds to it; of φ in proportion.
        persistence: of φ where θ is free, of what all axes share.
        color: probability that there is any; an autoregression has half of it.
        slowest: frequency above which ordinates count, Hz.
        share_of_rate: share of the sample rate at which they count in any case.
        most_power: mean square of the ordinates, over what is stated, beyond which they are something else than noise.
    """

    level: float
    deviation: float
    correlation: float
    correlation_deviation: float
    persistence: float
    color: float
    slowest: float
    share_of_rate: float
    most_power: float


@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseSpectrum:
    """Level and colour of a gyro's noise, against what is stated.

    Attributes:
        variance_ratio: of each run and axis, over what is stated, shape (R, 3); of an axis without samples a priori.
        color: averaged over the models; likewise.
        correlation: of neighbouring samples if there is colour, mean of the axes with samples.
        correlation_std: its standard error.
        freedom: degrees of freedom with which the spectrum below the ordinates that count is known.
    """

    variance_ratio: Array
    color: NoiseColor
    correlation: float
    correlation_std: float
    freedom: float


@dataclass(frozen=True, kw_only=True, eq=False)
class _Ordinates:
    """Squares of the cosine transforms of all runs and axes.

    Attributes:
        square: shape (M,).
        frequency: Hz, shape (M,).
        resolution: what a run of the mean length resolves, Hz.
        cosine: of the angular frequency in radians a sample, doubled, shape (M,).
        axis: shape (M,).
        cell: run and axis, shape (M,).
        columns: ∂ log v of each cell / ∂ levels of all samples, of the axes and of the runs, shape (3 R, R + 4).
        seen: which axes have samples, shape (3,).
    """

    square: Array
    frequency: Array
    resolution: float
    cosine: Array
    axis: Indices
    cell: Indices
    columns: Array
    seen: Flags

    def only(self, kept: Flags) -> _Ordinates:
        """Return some of the ordinates."""
        of_each = {name: getattr(self, name)[kept] for name in ("square", "frequency", "cosine", "axis", "cell")}
        return replace(self, **of_each)

    def log_power(self, parameters: Array) -> Array:
        """Return log S at the ordinates, shape (M,)."""
        levels, color = parameters[:-_COLORS], parameters[-_COLORS:].reshape(2, _WIDTH)
        persistence, average = color[:, self.axis]
        return np.asarray((self.columns @ levels)[self.cell] + _log_shape(persistence, average, self.cosine))

    def scored(self, parameters: Array, excess: Array) -> tuple[Array, Array]:
        """Return ½ Σ excess ∂ log S / ∂ parameters, shape (P,), and Fisher's ½ Σ ∂ log S ∂ log Sᵀ, shape (P, P).

        Args:
            parameters: of the spectrum.
            excess: squares over their variance, less 1, shape (M,).
        """
        slopes = self._slopes(parameters)
        score = [np.bincount(self.axis, slope * excess, _WIDTH) for slope in slopes]
        gradient = 0.5 * np.concatenate([self.columns.T @ self._summed(excess), *score])
        levels = self.columns.T @ (np.bincount(self.cell, minlength=len(self.columns))[:, None] * self.columns)
        axes = np.tile(np.eye(_WIDTH), (len(self.columns) // _WIDTH, 1))
        across = np.hstack([self.columns.T @ (self._summed(slope)[:, None] * axes) for slope in slopes])
        own = np.block([[np.diag(np.bincount(self.axis, one * other, _WIDTH)) for other in slopes] for one in slopes])
        return gradient, 0.5 * np.block([[levels, across], [across.T, own]])

    def _slopes(self, parameters: Array) -> tuple[Array, Array]:
        persistence, average = parameters[-_COLORS:].reshape(2, _WIDTH)[:, self.axis]
        return _slopes(persistence, average, self.cosine)

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
    ordinates = _without_lines(ordinates, _precision(runs, prior, parameters=2))
    models = _models(ordinates, runs, prior)
    shares = _shares([each.log_evidence for each in models], prior.color)
    period = float(np.median(np.concatenate([np.diff(time) for time in times])))
    slow = 2.0 * cos(pi * prior.slowest * period)  # in the middle of what is below the ordinates
    _, variance = _mixed(shares, [_low_frequency(each, ordinates.seen, runs, slow) for each in models])
    correlation, spread = _mixed(shares[1:], [_correlation(each, ordinates.seen) for each in models[1:]])
    mean = shares @ np.stack([each.mean for each in models])
    return NoiseSpectrum(
        variance_ratio=np.exp(mean[0] + mean[1 : 1 + _WIDTH] + mean[1 + _WIDTH : -_COLORS, None]),
        color=NoiseColor(persistence=mean[-_COLORS:-_WIDTH], average=mean[-_WIDTH:]),
        correlation=correlation,
        correlation_std=sqrt(spread),
        freedom=max(2.0 / variance, _FEWEST_FREEDOM),
    )


def _shares(log_evidence: Sequence[float], color: float) -> Array:
    """Return the probabilities of white noise, of an autoregression, and of noise with both parameters."""
    logarithm = np.array(log_evidence) + np.log([1.0 - color, 0.5 * color, 0.5 * color])
    return np.asarray(softmax(logarithm))


def _mixed(shares: Array, models: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return mean and variance of a mixture of models, each with its own."""
    means, variances = np.array(models).T
    weights = shares / shares.sum()
    mean = float(weights @ means)
    return mean, float(weights @ (variances + (means - mean) ** 2))


def _ordinates(whitened: Sequence[Array], times: Sequence[Series], prior: SpectrumPrior, live: Flags) -> _Ordinates:
    squares, frequencies, cosines, cells = [], [], [], []
    for run, (values, time, own) in enumerate(zip(whitened, times, live, strict=True)):
        number, period = np.arange(len(values)), float(np.median(np.diff(time)))
        slowest = min(prior.slowest, prior.share_of_rate / period)
        fast = number > 2.0 * slowest * period * len(values)  # of half periods in the run
        count = int(fast.sum())
        squares.append((dct(values[:, own], axis=0, norm="ortho")[fast] ** 2).T.ravel())
        frequencies.append(np.tile(number[fast] / (2.0 * period * len(values)), int(own.sum())))
        cosines.append(np.tile(2.0 * np.cos(pi * number[fast] / len(values)), int(own.sum())))
        cells.append(_WIDTH * run + np.repeat(np.flatnonzero(own), count))
    cell, runs = np.concatenate(cells), len(whitened)
    every = np.arange(_WIDTH * runs)
    return _Ordinates(
        square=np.concatenate(squares),
        frequency=np.concatenate(frequencies),
        resolution=1.0 / float(np.mean([np.ptp(time) for time in times])),
        cosine=np.concatenate(cosines),
        axis=cell % _WIDTH,
        cell=cell,
        columns=np.column_stack([np.ones(len(every)), np.eye(_WIDTH)[every % _WIDTH], np.eye(runs)[every // _WIDTH]]),
        seen=np.any(live, axis=0),
    )


def _without_lines(ordinates: _Ordinates, precision: Array) -> _Ordinates:
    """Return ordinates without those in which one frequency stands out, in all runs and axes together.

    A hum, a mode or a rotor is no noise, and would be foretold by its colour.

    Args:
        ordinates: of all runs.
        precision: of the prior of noise with both parameters.
    """
    for _ in range(_MOST_LINES):
        line = _line(ordinates, _posterior(ordinates, precision))
        if line is None or np.count_nonzero(~line) < FEWEST:
            break
        ordinates = ordinates.only(~line)
    return ordinates


def _line(ordinates: _Ordinates, noise: _Posterior) -> Flags | None:
    """Return the ordinates within what runs resolve of the frequency that stands out the most, if one does."""
    order = np.argsort(ordinates.frequency)
    frequency = ordinates.frequency[order]
    power = np.concatenate([[0.0], np.cumsum((ordinates.square * np.exp(-ordinates.log_power(noise.mean)))[order])])
    first = np.searchsorted(frequency, frequency - ordinates.resolution)
    end = np.searchsorted(frequency, frequency + ordinates.resolution, side="right")
    chance = scipy.stats.chi2.logsf(power[end] - power[first], end - first)
    best = int(np.argmin(chance))
    bands = max(float(np.ptp(frequency)) / ordinates.resolution, 1.0)
    if chance[best] + log(bands) > log(_LINE_CHANCE):
        return None
    return np.asarray(np.abs(ordinates.frequency - frequency[best]) <= ordinates.resolution)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Posterior:
    """Of the parameters: log v of all samples, of each axis and each run, φ and θ of each axis; zero where not free.

    Attributes:
        mean: shape (P,).
        covariance: shape (P, P).
        log_evidence: logarithm of the data's probability, up to what all models share.
        square: the ordinates' squares as they counted.
    """

    mean: Array
    covariance: Array
    log_evidence: float
    square: Array


def _models(ordinates: _Ordinates, runs: int, prior: SpectrumPrior) -> tuple[_Posterior, _Posterior, _Posterior]:
    """Return the posteriors of white noise, of an autoregression, and of noise with both parameters.

    The same squares count for all: as the one with both caps them.
    """
    white, simple, both = (_precision(runs, prior, parameters) for parameters in range(3))
    first = _posterior(ordinates, simple)
    last = _posterior(ordinates, both, color=first.mean[-_COLORS:])
    square = last.square
    return _posterior(ordinates, white, square=square), _posterior(ordinates, simple, square=square), last


def _posterior(
    ordinates: _Ordinates, precision: Array, color: Array | None = None, square: Array | None = None
) -> _Posterior:
    """Return the posterior by Fisher scoring (Laplace).

    A step that makes the data less probable is halved; what lies at a bound and would leave it stays there.

    Args:
        ordinates: of all runs.
        precision: of the prior of the parameters that are free, the first of all.
        color: φ and θ to start from, shape (6,); zero where None.
        square: as the ordinates count; None where the spectrum caps them.
    """
    count = len(precision)
    mean = np.zeros(ordinates.columns.shape[1] + _COLORS)
    mean[0] = np.log(np.median(ordinates.square) / CHI_SQUARE_MEDIAN)
    mean[-_COLORS:] = 0.0 if color is None else color
    index, levels = np.arange(count), len(mean) - _COLORS
    log_power = ordinates.log_power(mean)
    for _ in range(_STEPS):
        counted = np.minimum(ordinates.square, _CAP * np.exp(log_power)) if square is None else square
        score, scatter = ordinates.scored(mean, counted * np.exp(-log_power) - 1.0)
        gradient, information = score[:count] - precision @ mean[:count], scatter[:count, :count] + precision
        moving = ~((np.abs(mean[:count]) >= _LARGEST) & (mean[:count] * gradient > 0.0) & (index >= levels))
        step = np.zeros(len(mean))
        step[:count][moving] = np.linalg.solve(information[np.ix_(moving, moving)], gradient[moving])
        step *= min(1.0, _LONGEST / max(np.abs(step).max(), np.finfo(float).tiny))
        reached, log_power = _stepped(ordinates, precision, counted, mean, log_power, step)
        mean, step = reached, reached - mean
        if np.abs(step).max() < _CLOSE:
            break
    squares = _misfit(precision, counted, mean, log_power)
    determinants = np.linalg.slogdet(precision)[1] - np.linalg.slogdet(information)[1]
    covariance = np.zeros((len(mean), len(mean)))
    covariance[:count, :count] = np.linalg.inv(information)
    evidence = 0.5 * float(determinants - squares)
    return _Posterior(mean=mean, covariance=covariance, log_evidence=evidence, square=counted)


def _misfit(precision: Array, counted: Array, mean: Array, log_power: Array) -> float:
    """Return minus twice the logarithm of the posterior density, without constants, where log S is as given."""
    free = mean[: len(precision)]
    return float((log_power + counted * np.exp(-log_power)).sum() + free @ precision @ free)


def _stepped(
    ordinates: _Ordinates, precision: Array, counted: Array, mean: Array, log_power: Array, step: Array
) -> tuple[Array, Array]:
    """Return the parameters after a step, or as much of it as makes the data more probable, and log S there."""
    before = _misfit(precision, counted, mean, log_power)
    for _ in range(_HALVINGS):
        after = mean + step
        after[-_COLORS:] = np.clip(after[-_COLORS:], -_LARGEST, _LARGEST)
        power_after = ordinates.log_power(after)
        if _misfit(precision, counted, after, power_after) <= before:
            return after, power_after
        step = 0.5 * step
    return mean, log_power


def _precision(runs: int, prior: SpectrumPrior, parameters: int) -> Array:
    """Return the inverse of the prior covariance of the levels and of so many parameters of each axis' colour."""
    levels = np.diag(np.array([prior.level, *[prior.deviation] * (_WIDTH + runs)]) ** -2)
    if parameters == 0:
        return np.asarray(levels)
    own = (prior.correlation_deviation / prior.correlation) ** 2
    axes = np.linalg.inv(np.ones((_WIDTH, _WIDTH)) + own * np.eye(_WIDTH))
    sums = np.full((parameters, parameters), prior.correlation**-2)
    if parameters == 2:
        sums[0, 0] += prior.persistence**-2
    return np.asarray(block_diag(levels, np.kron(sums, axes)))


def _log_shape(persistence: Array, average: Array, cosine: Array | float) -> Array:
    """Return log S of the variance 1, by twice the cosine of the angular frequency in radians a sample."""
    moved = np.log1p(average**2 + average * cosine) - np.log(1.0 + 2.0 * persistence * average + average**2)
    return np.asarray(np.log1p(-(persistence**2)) + moved - np.log(1.0 + persistence**2 - persistence * cosine))


def _slopes(persistence: Array, average: Array, cosine: Array | float) -> tuple[Array, Array]:
    """Return its derivatives with respect to φ and to θ."""
    whole = 1.0 + 2.0 * persistence * average + average**2
    by_persistence = -2.0 * persistence / (1.0 - persistence**2) - 2.0 * average / whole
    by_persistence = by_persistence - (2.0 * persistence - cosine) / (1.0 + persistence**2 - persistence * cosine)
    by_average = (2.0 * average + cosine) / (1.0 + average**2 + average * cosine)
    return np.asarray(by_persistence), np.asarray(by_average - 2.0 * (persistence + average) / whole)


def _low_frequency(posterior: _Posterior, seen: Flags, runs: int, cosine: float) -> tuple[float, float]:
    """Return mean and variance of the logarithm of the spectrum, of axes with samples and runs, by twice a cosine."""
    color = posterior.mean[-_COLORS:].reshape(2, _WIDTH)
    slopes = np.where(seen, _slopes(color[0], color[1], cosine), 0.0).ravel() / seen.sum()
    contrast = np.concatenate([[1.0], seen / seen.sum(), np.full(runs, 1.0 / runs), slopes])
    level = contrast[:-_COLORS] @ posterior.mean[:-_COLORS] + _log_shape(color[0], color[1], cosine)[seen].mean()
    return float(level), float(contrast @ posterior.covariance @ contrast)


def _correlation(posterior: _Posterior, seen: Flags) -> tuple[float, float]:
    """Return mean and variance of the correlation of neighbouring samples, mean of the axes with samples."""
    color = posterior.mean[-_COLORS:].reshape(2, _WIDTH)
    contrast = np.where(seen, correlation_slopes(color[0], color[1]), 0.0).ravel() / seen.sum()
    spread = contrast @ posterior.covariance[-_COLORS:, -_COLORS:] @ contrast
    return float(correlation_of(color[0], color[1])[seen].mean()), float(spread)
