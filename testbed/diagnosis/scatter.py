"""Effects on how the gyro's samples scatter: tested on what a model leaves, and taken into the believed noise."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from testbed.arrays import Array, Vector3
from testbed.diagnosis.candidates import CLOSE
from testbed.diagnosis.chance import likelier_than_nothing, scale_evidence
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise import readings_of
from testbed.diagnosis.probabilities import normalized
from testbed.diagnosis.signatures import FAMILY_WISE_ERROR
from testbed.effects.reading_effect import Finding, ReadingEffect, Readings


@dataclass(frozen=True, kw_only=True, eq=False)
class Scatter:
    """A hypothesis on the scatter of the gyro's samples, and what these say of it.

    Attributes:
        effect: which.
        component: where.
        finding: its parameters, and how sure it is.
        tested: number of hypotheses, which share the family-wise error alike.
        look_alikes: what the samples do not tell from it.
        probability: that it, or one of these, is there, among all effects on the scatter and none.
    """

    effect: ReadingEffect
    component: str
    finding: Finding
    tested: int
    look_alikes: tuple[Scatter, ...] = ()
    probability: float = 0.0

    @property
    def key(self) -> str:
        """Unique name, e.g. `gyro_noise:x`."""
        return _key(self.effect, self.component)

    @property
    def gain(self) -> float:
        """Twice the logarithm of the likelihood ratio with and without it."""
        return self.finding.gain

    @property
    def evidence(self) -> float:
        """Twice the logarithm of by how much the effect makes the samples likelier (`scale_evidence`)."""
        return scale_evidence(self.gain, self.finding.freedom)

    @property
    def odds(self) -> float:
        """Twice the logarithm of how much likelier it is than nothing: each hypothesis is as likely beforehand."""
        return self.evidence - 2.0 * log(self.tested)

    @property
    def p_value(self) -> float:
        """Chance of what was seen without it, times the number of hypotheses (Bonferroni)."""
        return min(1.0, self.tested * self.finding.p_value)

    @property
    def present(self) -> bool:
        """Whether it is there by more than chance, at the family-wise error, and likelier than nothing."""
        return self.p_value < FAMILY_WISE_ERROR and self.odds > 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Scattering:
    """What the samples say of all hypotheses on their scatter.

    Attributes:
        told: every hypothesis against the stated noise, the one with the most evidence first.
        found: those that are there by more than chance, the clearest first, each told with those before it taken in.
    """

    told: tuple[Scatter, ...] = ()
    found: tuple[Scatter, ...] = ()


def scattering(
    runs: Runs, fit: Fit, effects: Mapping[str, ReadingEffect], others: int, *, white: bool = False
) -> Scattering:
    """Return what the samples say of the effects on their scatter, and which of them are there.

    Args:
        runs: with the noise that is stated.
        fit: of the present model to them.
        effects: by id.
        others: number of further hypotheses by which the family-wise error is divided.
        white: whether the fit is known to leave nothing but noise.
    """
    hypotheses = [(effect, component) for effect in effects.values() for component in effect.components]
    readings = replace(readings_of(runs, fit), white=white)
    tested = others + len(hypotheses)
    told = first = _told(readings, hypotheses, tested)
    found: list[Scatter] = []
    while present := [each for each in told if each.present]:
        best = _with_look_alikes(present[0], told)
        if not likelier_than_nothing(each.odds for each in (best, *best.look_alikes)):
            break
        found.append(best)
        taken = {each.key for each in found}
        hypotheses = [each for each in hypotheses if _key(*each) not in taken]
        told = _told(_without_what_is_told(readings, found), hypotheses, tested)
    return Scattering(told=first, found=tuple(found))


def believing(runs: Runs, fit: Fit, found: Sequence[Scatter]) -> Runs:
    """Return runs that hold what was found: less what it tells sample by sample, and with the noise of the rest.

    Args:
        runs: any of them, with the noise that is stated.
        fit: of the present model to them, or of their initial rates alone.
        found: effects that are there.
    """
    freedom = min([runs.noise_freedom, *(each.finding.noise_freedom for each in found)])
    wider = runs.with_sigma(_widened(runs.sigma, found))
    return replace(wider, noise_freedom=freedom, told=_told_of(readings_of(runs, fit), found))


def _told_of(readings: Readings, found: Sequence[Scatter]) -> tuple[Array, ...]:
    """Return what the effects that are there tell of these readings, shape (N, 3) of every run; empty where nothing."""
    lines = [each for each in found if each.finding.explained is not None]
    left = readings
    for each in lines:
        again = each.effect.found(each.component, left)
        left = left if again is None else _less(left, again)
    pairs = zip(readings.residual, left.residual, strict=True)
    return tuple(before - after for before, after in pairs) if lines else ()


def added_variance(found: Iterable[Scatter]) -> Vector3:
    """Return the variance that effects add to the readings of each axis, less what they tell sample by sample."""
    noisier = (each.finding.variance for each in found if each.finding.explained is None)
    return np.asarray(sum(noisier, np.zeros(3)))


def _widened(sigma: Array, found: Iterable[Scatter]) -> Array:
    return np.asarray(np.sqrt(sigma**2 + added_variance(found)))


def _told(readings: Readings, hypotheses: Sequence[tuple[ReadingEffect, str]], tested: int) -> tuple[Scatter, ...]:
    """Return what readings say of hypotheses, the one with the most evidence first."""
    findings = [(effect, component, effect.found(component, readings)) for effect, component in hypotheses]
    told = [
        Scatter(effect=effect, component=component, finding=finding, tested=tested)
        for effect, component, finding in findings
        if finding is not None
    ]
    return tuple(sorted(told, key=lambda each: -each.evidence))


def _with_look_alikes(best: Scatter, told: Sequence[Scatter]) -> Scatter:
    """Return a hypothesis with what is not told from it, and how probable the class is."""
    alike = tuple(each for each in told if each is not best and best.evidence - each.evidence < CLOSE)
    probability = normalized({each.key: each.odds for each in told})
    return replace(best, look_alikes=alike, probability=sum(probability[each.key] for each in (best, *alike)))


def _without_what_is_told(readings: Readings, found: Sequence[Scatter]) -> Readings:
    """Return readings less what was told sample by sample, and with a noise that has the rest of what was found."""
    for each in found:
        readings = _less(readings, each.finding)
    return replace(readings, sigma=_widened(readings.sigma, found))


def _less(readings: Readings, finding: Finding) -> Readings:
    if finding.explained is None:
        return readings
    residual = [left - told for left, told in zip(readings.residual, finding.explained, strict=True)]
    return replace(readings, residual=residual)


def _key(effect: ReadingEffect, component: str) -> str:
    return f"{effect.id}:{component}"
