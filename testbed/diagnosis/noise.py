"""How the gyro's samples scatter: the hypotheses on its noise, tested on the residual of a model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from testbed.arrays import Array, Vector3
from testbed.diagnosis.candidates import favoured_over_none, normalized
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise_level import NoiseLevel, noise_level, readings_of
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.size_prior import evidence_of_power
from testbed.diagnosis.testable import components_on
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings
from testbed.estimation.noise_spectrum import NoiseSpectrum, SpectrumPrior, noise_spectrum

_PLAIN = 1e4
"""Standard errors of a typical size at most: an exact estimate, such as that of a step, has no error."""


_ROUNDS, _SETTLED = 10, 0.1
"""Rounds at most in which a walk and the noise beside it are estimated in turn, and by how much of its standard error
it may still change: walks of a tenth of the noise and more in a second settle in two to five."""


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
    def walks(self) -> bool:
        """Whether it is a bias that walks."""
        return self.finding.slow_bias is not None

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
        both = [(runs, fit) for runs, fit in pairs if runs is not None and fit is not None]
        return [replace(readings_of(*each), white=self.white, absorbed=self._absorbed(*each)) for each in both]

    def _absorbed(self, runs: Runs, fit: Fit) -> list[Array]:
        """Return what the parameters can make of each run's samples, where these may be noise alone; not of windows."""
        if not self.white or runs.windowed:
            return []
        parts = enumerate(runs.by_run(fit.jacobian))
        return [runs.wandering(run, part) * runs.sigma[run][:, None] for run, part in parts]


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
        found.append(_settled(residuals, [*found, best]))
        hypotheses = [each for each in hypotheses if _key(*each) != best.key]
        readings, heldout = _against(residuals, found)  # it leaves noise of another level and colour
        candidates = _tested(readings, hypotheses, tested, heldout)
    return NoiseTests(level=level, tested=first, found=tuple(found))


def _named(candidates: Sequence[NoiseHypothesis], none: float) -> NoiseHypothesis | None:
    """Return the hypothesis with the most evidence of those that are there, if its class is favoured over none.

    A bias that walks comes first: it changes level and colour of the noise, and these make no walk.
    """
    order = sorted(candidates, key=lambda each: not each.walks)
    best = next((_with_look_alikes(each, candidates, none) for each in order if each.present), None)
    if best is None or not favoured_over_none((each.odds for each in (best, *best.look_alikes)), none):
        return None
    return best


def _settled(residuals: Residuals, found: Sequence[NoiseHypothesis]) -> NoiseHypothesis:
    """Return the newest effect; where it is a bias that walks, by as much as it does in the noise that it leaves.

    Until it is taken off, part of it counts as a level and a colour of the noise.
    """
    *before, newest = found
    for _ in range(_ROUNDS):
        if not newest.walks:
            break
        readings, _ = _against(residuals, [*before, newest])
        finding = newest.effect.found(newest.component, replace(readings, slow_bias=None))
        if finding is None:
            break
        (walked, _), newest = newest.size, replace(newest, finding=finding)
        if abs(newest.size[0] - walked) < _SETTLED * newest.size[1]:
            break
    return newest


def _against(residuals: Residuals, found: Sequence[NoiseHypothesis]) -> tuple[Readings, Readings | None]:
    """Return the readings of fitted and of held-out runs with effects on the noise, in the noise that these leave."""
    both = [_applied(each, found)[0] for each in residuals.readings]
    spectrum, first = _spectrum(both, residuals.runs.noise_uncertainty), len(both[0].runs)
    if spectrum is None:
        return both[0], both[1] if len(both) > 1 else None
    own = (spectrum.variance_ratio[:first], spectrum.variance_ratio[first:])
    fitted_runs, *heldout = [
        replace(each, spectrum=replace(spectrum, variance_ratio=ratio)) for each, ratio in zip(both, own, strict=False)
    ]
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
        wider = replace(
            wider,
            noise_freedom=freedom,
            estimated_noise=lines,
            stated_sigma=each.sigma,
            slow_bias=readings.slow_bias,
        )
        changed.append(wider if spectrum is None else _with_spectrum(wider, spectrum, first))
        first += len(each.names)
    return changed[0], changed[1] if len(changed) > 1 else None


def _applied(readings: Readings, found: Sequence[NoiseHypothesis]) -> tuple[Readings, tuple[Array, ...]]:
    """Return readings with noise effects, and the noise that these estimate sample by sample, of every run."""
    lines = _estimated_noise(readings, found)
    left = readings.residual
    if lines:
        left = [residual - noise for residual, noise in zip(readings.residual, lines, strict=True)]
    readings = replace(readings, residual=left, sigma=_widened(readings.sigma, found))
    walking = next((each.finding.slow_bias for each in found if each.walks), None)
    return readings if walking is None else _refitted(replace(readings, slow_bias=walking)), lines


def _refitted(readings: Readings) -> Readings:
    """Return readings against the model as it fits in their noise, linearised: beside a walk it had followed this."""
    white = [
        (readings.whitened(absorbed, run)[:, live], readings.whitened(residual, run)[:, live])
        for run, (absorbed, residual, live) in enumerate(
            zip(readings.absorbed, readings.residual, readings.live, strict=True)
        )
    ]
    columns = np.concatenate([absorbed.reshape(-1, absorbed.shape[-1]) for absorbed, _ in white])
    scale = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    change, *_ = np.linalg.lstsq(columns / scale, np.concatenate([left.ravel() for _, left in white]), rcond=None)
    pairs = zip(readings.absorbed, readings.residual, strict=True)
    return replace(readings, residual=[residual - absorbed @ (change / scale) for absorbed, residual in pairs])


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
