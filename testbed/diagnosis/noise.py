"""How the gyro's samples scatter: the level of the noise, samples that stand apart, and the effects on it.

A transmission error or a spike of the sensor is one sample that stands away from both of its neighbours by far more
than the noise; what the platform does, or an effect of the library, lasts for longer than a sample or shows everywhere.
Such samples are left out before they pass for noise.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isinf, log

import numpy as np
import scipy

from testbed.arrays import Array, Theta, Vector3
from testbed.diagnosis.candidates import favoured_over_none, normalized
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted, nominal_fit
from testbed.diagnosis.model import Fit
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.size_prior import evidence_of_power
from testbed.diagnosis.testable import components_on
from testbed.dynamics.inertia import inertia_of
from testbed.effects.fast_changes import variance_ratio
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings
from testbed.estimation.noise_spectrum import NoiseSpectrum, SpectrumPrior, noise_spectrum


@dataclass(frozen=True, kw_only=True)
class NoiseLevel:
    """How the gyro's noise compares with what is stated.

    Attributes:
        ratio: measured over stated standard deviation, shape (3,), per axis; NaN where no run turns about it, or too
            few samples tell.
        std: of the ratio, shape (3,).
        p_value: of the stated noise on all axes, two-sided.
    """

    ratio: Vector3
    std: Vector3
    p_value: float

    @property
    def understated(self) -> bool:
        """Whether there is more noise than stated, by more than chance."""
        return self.p_value < SETTINGS.noise_level_p_value and bool(np.nanmean(self.ratio) > 1.0)

    @property
    def overstated(self) -> bool:
        """Whether there is less, by so much that effects have to be larger to be found."""
        return self.p_value < SETTINGS.noise_level_p_value and bool(np.nanmean(self.ratio) < SETTINGS.overstated_noise)


def noise_level(readings: Readings) -> NoiseLevel:
    """Compare the residual's fourth differences with those of white noise of the stated standard deviation."""
    ratios = [variance_ratio(readings, axis) for axis in np.eye(3, dtype=bool)]
    known = np.array([freedom for _, freedom in ratios]) > 0.0
    if not known.any():
        return NoiseLevel(ratio=np.full(3, np.nan), std=np.full(3, np.nan), p_value=1.0)
    ratio = np.where(known, np.sqrt([variance for variance, _ in ratios]), np.nan)
    freedom = np.where(known, [freedom for _, freedom in ratios], np.nan)
    pairs = zip((freedom * ratio**2)[known], freedom[known], strict=True)
    tails = np.array(
        [2.0 * min(scipy.stats.chi2.cdf(value, own), scipy.stats.chi2.sf(value, own)) for value, own in pairs]
    )
    return NoiseLevel(
        ratio=ratio, std=ratio / np.sqrt(2.0 * freedom), p_value=float(min(1.0, len(tails) * tails.min()))
    )


def readings_of(runs: Runs, fit: Fit) -> Readings:
    """Return what the gyro gave against what a model predicts."""
    return Readings(
        measured=[run.body_rate for run in runs.grid.runs],
        residual=runs.gyro_residual(fit.residual),
        sigma=runs.sigma,
        runs=runs.grid.runs,
        inertia=inertia_of(fit.theta),
        parameters=int((np.diag(fit.normal) > 0.0).sum()),
        stated=isinf(runs.noise_freedom),
        live=runs.live,
    )


def deviance(runs: Runs, fit: Fit) -> float:
    """Return minus twice the logarithm of the density of the gyro's samples, up to a constant.

    Args:
        runs: with their noise.
        fit: of any model to them.
    """
    total = 0.0
    for white, sigma, live, run in zip(runs.by_run(fit.residual), runs.sigma, runs.live, runs.grid.runs, strict=True):
        color = np.zeros(3) if runs.color is None else runs.color.log_scale(run.gyro_time)
        total += float((white[:, live] ** 2).sum() + 2.0 * (len(white) * np.log(sigma) - color)[live].sum())
    return total


def pooled_noise(runs: Runs, theta: Theta) -> tuple[float, float] | None:
    """Return the noise estimated from the samples of all runs together, rad/s, and its degrees of freedom.

    None where they are too few.

    Args:
        runs: all of them.
        theta: to start their fit from, shape (6,), kg·m².
    """
    # All runs get the same weight: noise levels estimated run by run must not decide this fit.
    runs = runs.with_sigma(np.sqrt(np.mean(runs.sigma**2, axis=0)))
    # The fastest changes, from which it is estimated, show no inertia that windows of half-known torque could tell of.
    model = nominal_fit(runs, theta) if runs.known_in_part else fitted(runs, [], theta, [])
    ratio, freedom = variance_ratio(readings_of(runs, model), np.ones(3, dtype=bool))
    return (float(np.sqrt(ratio * np.mean(runs.sigma**2))), freedom) if freedom > 0.0 else None


def with_pooled_noise(runs: Runs, level: tuple[float, float]) -> Runs:
    """Return runs with the noise estimated from the samples; it includes that of the actuators' telemetry.

    Args:
        runs: any of them.
        level: as `pooled_noise`.
    """
    noise, freedom = level
    return replace(
        runs.with_sigma(np.full(3, noise)),
        noise_stated=False,
        noise_freedom=freedom,
        noise_uncertainty=SETTINGS.unstated_noise_uncertainty,
    )


_PLAIN = 1e4
"""Standard errors of a typical size at most: an exact estimate, such as that of a step, has no error."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseHypothesis:
    """A hypothesis on the gyro's noise, with its test on the samples.

    Attributes:
        effect: which.
        component: where.
        finding: its parameters, and how sure it is.
        tested: number of hypotheses, which share the family-wise error alike.
        look_alikes: hypotheses that are indistinguishable from it.
        probability: that it, or one of these, is there, among all effects on the scatter and none.
        held_out_gain: twice the logarithm of how much more probable it makes the samples of held-out runs.
    """

    effect: NoiseEffect
    component: str
    finding: Finding
    tested: int
    look_alikes: tuple[NoiseHypothesis, ...] = ()
    probability: float = 0.0
    held_out_gain: float = 0.0

    @property
    def key(self) -> str:
        """Unique name, e.g. `gyro_noise:x`."""
        return _key(self.effect, self.component)

    @property
    def size(self) -> tuple[float, float]:
        """Its first parameter, by which it is large or small, and the standard error."""
        return float(self.finding.values[0]), float(self.finding.std[0])

    @property
    def chi_square_reduction(self) -> float:
        """Twice the logarithm of the likelihood ratio with and without it."""
        return self.finding.chi_square_reduction

    @property
    def log_bayes_factor(self) -> float:
        """Twice the logarithm of the effect's Bayes factor, its size having the prior of all effects; of all runs."""
        (size,), (std,) = self.effect.parameters, self.finding.std
        typical = abs(size.typical - size.absent) / std if std > 0.0 else np.inf
        evidence = evidence_of_power(self.chi_square_reduction, self.finding.freedom, min(typical, _PLAIN) ** 2)
        return evidence + self.held_out_gain

    @property
    def odds(self) -> float:
        """Twice the logarithm of its posterior odds against none; all hypotheses have equal priors."""
        return self.log_bayes_factor - 2.0 * log(self.tested)

    @property
    def p_value(self) -> float:
        """p-value without the effect, times the number of hypotheses (Bonferroni)."""
        return min(1.0, self.tested * self.finding.p_value)

    @property
    def present(self) -> bool:
        """Whether it is significant at the family-wise error, with posterior odds above even."""
        return self.p_value < SETTINGS.family_wise_error and self.odds > 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class NoiseTests:
    """Tests of all hypotheses on the gyro's noise.

    Attributes:
        tested: every hypothesis against the stated noise, the one with the most evidence first.
        found: the significant ones, the clearest first, each tested with those before it in the model.
        level: the noise against what is stated, without its colour.
    """

    level: NoiseLevel
    tested: tuple[NoiseHypothesis, ...] = ()
    found: tuple[NoiseHypothesis, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Residuals:
    """Runs and held-out ones with a model's residual in each: both tell how the gyro's noise is.

    Attributes:
        runs: that were fitted, with the noise that is stated.
        fit: of the present model to them.
        heldout: that were not; None where there are none.
        seen: the model with the initial rates of these.
        white: whether the fit is known to leave nothing but noise.
    """

    runs: Runs
    fit: Fit
    heldout: Runs | None = None
    seen: Fit | None = None
    white: bool = False

    @property
    def readings(self) -> list[Readings]:
        """What the gyro gave against the model, the fitted runs first."""
        pairs = ((self.runs, self.fit), (self.heldout, self.seen))
        both = [readings_of(runs, fit) for runs, fit in pairs if runs is not None and fit is not None]
        return [replace(each, white=self.white) for each in both]


def noise_tests(residuals: Residuals, effects: Mapping[str, NoiseEffect], others: int) -> NoiseTests:
    """Test the noise effects on the samples, and return which of them are present.

    Args:
        residuals: of the present model.
        effects: by id.
        others: number of further hypotheses by which the family-wise error is divided.
    """
    runs = residuals.runs
    hypotheses = [(effect, component) for effect in effects.values() for component in components_on(runs, effect)]
    tested, found = others + len(hypotheses), list[NoiseHypothesis]()
    readings, heldout = _against(residuals, found)
    level = noise_level(readings)
    candidates = first = _tested(readings, hypotheses, tested, heldout)
    while (best := _named(candidates, runs.prior_odds.none)) is not None:
        found.append(best)
        hypotheses = [each for each in hypotheses if _key(*each) != best.key]
        readings, heldout = _against(residuals, found)  # it leaves noise of another level and colour
        candidates = _tested(readings, hypotheses, tested, heldout)
    return NoiseTests(level=level, tested=first, found=tuple(found))


def _named(candidates: Sequence[NoiseHypothesis], none: float) -> NoiseHypothesis | None:
    """Return the hypothesis with the most evidence of those that are there, if its class is favoured over none."""
    best = next((_with_look_alikes(each, candidates, none) for each in candidates if each.present), None)
    if best is None or not favoured_over_none((each.odds for each in (best, *best.look_alikes)), none):
        return None
    return best


def _against(residuals: Residuals, found: Sequence[NoiseHypothesis]) -> tuple[Readings, Readings | None]:
    """Return the readings of fitted and of held-out runs with effects on the noise, in the noise that these leave."""
    both = [_applied(each, found)[0] for each in residuals.readings]
    spectrum = _spectrum(both, residuals.runs.noise_uncertainty)
    fitted_runs, *heldout = [replace(each, spectrum=spectrum) for each in both]
    return fitted_runs, heldout[0] if heldout else None


def with_noise_model(residuals: Residuals, found: Sequence[NoiseHypothesis]) -> tuple[Runs, Runs | None]:
    """Return fitted and held-out runs with the noise as it is estimated.

    The noise effects are applied: less the noise estimated sample by sample, σ widened by the rest. Then level and
    colour are those of the residual's fast part, what is stated being a prior; where that part is no noise of this gyro
    they stay as they are.

    Args:
        residuals: of the present model.
        found: effects that are there.
    """
    runs = [each for each in (residuals.runs, residuals.heldout) if each is not None]
    both = [_applied(each, found) for each in residuals.readings]
    spectrum = _spectrum([readings for readings, _ in both], residuals.runs.noise_uncertainty)
    freedom = min([residuals.runs.noise_freedom, *(each.finding.noise_freedom for each in found)])
    changed, first = [], 0
    for each, (readings, lines) in zip(runs, both, strict=True):
        wider = each.with_sigma(readings.sigma)
        wider = replace(wider, noise_freedom=freedom, estimated_noise=lines, stated_sigma=each.sigma)
        changed.append(wider if spectrum is None else _with_spectrum(wider, spectrum, first))
        first += len(each.names)
    return changed[0], changed[1] if len(changed) > 1 else None


def _applied(readings: Readings, found: Sequence[NoiseHypothesis]) -> tuple[Readings, tuple[Array, ...]]:
    """Return readings with noise effects, and the noise that these estimate sample by sample, of every run."""
    lines = _estimated_noise(readings, found)
    left = readings.residual
    if lines:
        left = [residual - noise for residual, noise in zip(readings.residual, lines, strict=True)]
    return replace(readings, residual=left, sigma=_widened(readings.sigma, found)), lines


def _with_spectrum(runs: Runs, spectrum: NoiseSpectrum, first: int) -> Runs:
    """Return runs with a level and a colour of their noise; they are those of the spectrum from one on."""
    own = spectrum.variance_ratio[first : first + len(runs.names)]
    farthest = np.exp(2.0 * SETTINGS.noise_farthest_std * runs.noise_uncertainty)
    return replace(
        runs,
        sigma=runs.sigma * np.sqrt(np.clip(own, 1.0 / farthest, farthest)),
        color=spectrum.color,
        noise_freedom=min(runs.noise_freedom, spectrum.freedom),
    )


def _spectrum(both: Sequence[Readings], uncertainty: float) -> NoiseSpectrum | None:
    """Return the spectrum of the noise in readings; None where their residual is another thing, or too short."""
    prior = SpectrumPrior(
        level=2.0 * uncertainty,
        deviation=2.0 * min(uncertainty, SETTINGS.noise_uncertainty),
        correlation=SETTINGS.noise_correlation_std,
        correlation_deviation=SETTINGS.noise_correlation_axis_std,
        persistence=SETTINGS.noise_persistence_std,
        color=SETTINGS.noise_color_prior,
        slowest=SETTINGS.noise_slowest_of_all_hz if both[0].white else SETTINGS.noise_slowest_hz,
        share_of_rate=SETTINGS.noise_share_of_rate,
        most_power=SETTINGS.noise_most_power,
    )
    whitened = [values for readings in both for values in readings.whitened_residual]
    times = [run.gyro_time for readings in both for run in readings.runs]
    return noise_spectrum(whitened, times, prior, np.concatenate([readings.live for readings in both]))


def _estimated_noise(readings: Readings, found: Sequence[NoiseHypothesis]) -> tuple[Array, ...]:
    """Return the noise that the effects estimate sample by sample, shape (N, 3) of every run; empty if none does."""
    lines = [each for each in found if each.finding.explained is not None]
    left = readings
    for each in lines:
        again = each.effect.found(each.component, left)
        left = left if again is None else _less(left, again)
    pairs = zip(readings.residual, left.residual, strict=True)
    return tuple(before - after for before, after in pairs) if lines else ()


def added_variance(found: Iterable[NoiseHypothesis]) -> Vector3:
    """Return the variance that effects add to each axis, without the noise estimated sample by sample."""
    noisier = (each.finding.variance for each in found if each.finding.explained is None)
    return np.asarray(sum(noisier, np.zeros(3)))


def _widened(sigma: Array, found: Iterable[NoiseHypothesis]) -> Array:
    return np.asarray(np.sqrt(sigma**2 + added_variance(found)))


def _tested(
    readings: Readings, hypotheses: Sequence[tuple[NoiseEffect, str]], tested: int, heldout: Readings | None
) -> tuple[NoiseHypothesis, ...]:
    """Test hypotheses on readings, and on held-out ones, and return them, the one with the most evidence first."""
    findings = [(effect, component, effect.found(component, readings)) for effect, component in hypotheses]
    candidates = [
        NoiseHypothesis(
            effect=effect,
            component=component,
            finding=finding,
            tested=tested,
            held_out_gain=0.0 if heldout is None else effect.held_out_gain(component, finding.values, heldout),
        )
        for effect, component, finding in findings
        if finding is not None
    ]
    return tuple(sorted(candidates, key=lambda each: -each.log_bayes_factor))


def _with_look_alikes(best: NoiseHypothesis, candidates: Sequence[NoiseHypothesis], none: float) -> NoiseHypothesis:
    """Return a hypothesis with its equivalence class, and the probability of that class."""
    alike = tuple(
        each
        for each in candidates
        if each is not best and best.log_bayes_factor - each.log_bayes_factor < SETTINGS.indistinguishable
    )
    probability = normalized({each.key: each.odds for each in candidates}, none)
    return replace(best, look_alikes=alike, probability=sum(probability[each.key] for each in (best, *alike)))


def _less(readings: Readings, finding: Finding) -> Readings:
    if finding.explained is None:
        return readings
    residual = [left - noise for left, noise in zip(readings.residual, finding.explained, strict=True)]
    return replace(readings, residual=residual)


def _key(effect: NoiseEffect, component: str) -> str:
    return f"{effect.id}:{component}"
