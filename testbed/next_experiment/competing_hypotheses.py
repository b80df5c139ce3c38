"""The models that a diagnosis could not choose among, and which of them have to be distinguished.

Two kinds: effects whose refits explain the data alike, each of which could be the truth; and effects that these data
cannot show because a changed inertia imitates them, each against the model without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from math import sqrt

import numpy as np

from testbed.diagnosis.candidates import Candidate
from testbed.diagnosis.detectable import INERTIA, first_screening, hidden_by_inertia
from testbed.diagnosis.findings import inertia_change
from testbed.diagnosis.fitting import fitted, fitted_initial_rates
from testbed.diagnosis.model import Fit, Hypothesis, evaluated
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.signatures import required_shift
from testbed.diagnosis.state import Diagnosis
from testbed.next_experiment.distance import Contrast, contrast

MOST_MODELS = 5
"""Competing models of which every two are compared, the named one among them: 20 pairs, each with derivatives of every
flight; a further model would add ten."""
_QUANTILE = 1.645
"""Of the normal distribution at 95 %: how surely a flight is to distinguish the models. Convention."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CompetingHypothesis:
    """A model that the present data allow.

    Attributes:
        key: effect and component that make it differ, or `inertia`.
        fits: to the fitted runs; then to the held-out runs, only their initial rates, unless it acts in single runs.
        log_bayes_factor: of the model with its effect against the model without it.
    """

    key: str
    fits: tuple[Fit, ...]
    log_bayes_factor: float = 0.0

    @property
    def model(self) -> Fit:
        """Fitted to the fitted runs."""
        return self.fits[0]

    @property
    def common(self) -> int:
        """Parameters that all flights share."""
        return 6 + len(self.model.effect_values)


@dataclass(frozen=True, kw_only=True, eq=False)
class Pair:
    """A model that is taken as true, and a false one that is fitted to it.

    Attributes:
        truth: index of the model.
        imitator: likewise.
        wanted: distance in sigma, present and new data together, that distinguishes them in 95 of 100 cases.
    """

    truth: int
    imitator: int
    wanted: float


@dataclass(frozen=True, kw_only=True, eq=False)
class HypothesisPairs:
    """Competing models, and the pairs of them that have to be distinguished."""

    models: tuple[CompetingHypothesis, ...]
    pairs: tuple[Pair, ...]

    def keys(self, pair: Pair) -> tuple[str, str]:
        """Return what a pair's models are called."""
        return self.models[pair.truth].key, self.models[pair.imitator].key


def hypothesis_pairs_of(diagnosis: Diagnosis) -> HypothesisPairs | None:
    """Return the models that have to be distinguished; None where the diagnosis is unambiguous."""
    for index, step in enumerate(diagnosis.steps):
        if step.look_alikes:
            return _among_effects(diagnosis, index)
    return _against_inertia(diagnosis)


def present_contrast(truth: CompetingHypothesis, imitator: CompetingHypothesis) -> Contrast:
    """Return what the present data say of the difference between two competing models, F = 1."""
    of_roles = [
        contrast((own.residual - other.residual)[None], own.jacobian[None], imitator.common)
        for other, own in zip(truth.fits, imitator.fits, strict=False)
    ]
    return of_roles[0] if len(of_roles) == 1 else of_roles[0].with_(of_roles[1])


def _among_effects(diagnosis: Diagnosis, index: int) -> HypothesisPairs | None:
    """Return the effects of a step that the data cannot distinguish, each with all other effects of the model."""
    step = diagnosis.steps[index]
    others = [each for each in diagnosis.model.placed if each.key != step.placed.key]
    taken = {each.key for each in others}
    named = CompetingHypothesis(
        key=step.placed.key, fits=_fits(diagnosis, diagnosis.model), log_bayes_factor=step.candidate.log_bayes_factor
    )
    imitators = [
        CompetingHypothesis(
            key=candidate.placed.key,
            fits=_fits(diagnosis, _refitted(diagnosis, others, candidate)),
            log_bayes_factor=candidate.log_bayes_factor,
        )
        for candidate in step.screening.close
        if candidate.placed.key not in taken | {step.placed.key}
    ]
    models = (named, *imitators[: MOST_MODELS - 1])
    pairs = tuple(
        Pair(truth=one, imitator=other, wanted=_wanted(models[one], models[other]))
        for one, other in permutations(range(len(models)), 2)
    )
    return HypothesisPairs(models=models, pairs=pairs) if pairs else None


def _refitted(diagnosis: Diagnosis, others: Sequence[Hypothesis], candidate: Candidate) -> Fit:
    """Return the model with one effect in place of the one that was chosen; others are all that stay in it."""
    values = dict(zip((each.key for each in diagnosis.model.placed), diagnosis.model.values.effects, strict=True))
    starts = [*(values[each.key][0] for each in others), candidate.fit.values.effects[-1][0]]
    placed = [*others, candidate.placed]
    return fitted(diagnosis.runs, placed, candidate.fit.theta, starts)


def _fits(diagnosis: Diagnosis, model: Fit) -> tuple[Fit, ...]:
    """Return a model fitted to the fitted runs and to those held out, which say nothing of what happens once."""
    if diagnosis.heldout is None or not all(each.effect.recurs for each in model.placed):
        return (model,)
    return model, fitted_initial_rates(diagnosis.heldout, model)


def _wanted(truth: CompetingHypothesis, imitator: CompetingHypothesis) -> float:
    """Return the distance at which the imitator's evidence is `indistinguishable` or farther behind in 95 of 100 cases.

    The present data say what they say: what is ahead so far counts as it is. New data that add g to the square of the
    distance add g to the difference of evidence, with a standard deviation of 2 √g.
    """
    lacking = max(SETTINGS.indistinguishable - (truth.log_bayes_factor - imitator.log_bayes_factor), 0.0)
    gained = (_QUANTILE + sqrt(_QUANTILE**2 + lacking)) ** 2
    return sqrt(float(present_contrast(truth, imitator).distance[0]) ** 2 + gained)


def _against_inertia(diagnosis: Diagnosis) -> HypothesisPairs | None:
    """Return the effects that look like the inertia, which differs, and that these data would not show.

    Each at its typical size against the model without it, which takes it for inertia.
    """
    screening = first_screening(diagnosis)
    if screening is None or not inertia_change(diagnosis).significant:
        return None
    hidden = hidden_by_inertia(diagnosis)
    without = CompetingHypothesis(key=INERTIA, fits=_fits(diagnosis, diagnosis.model))
    shown = tuple(_typical(diagnosis, placed) for placed in hidden)
    pairs = tuple(
        Pair(truth=number, imitator=0, wanted=required_shift(placed.size, screening.tested))
        for number, placed in enumerate(hidden, start=1)
    )
    models = (without, *shown)
    hard = tuple(pair for pair in pairs if present_contrast(models[pair.truth], without).distance[0] < pair.wanted)
    return HypothesisPairs(models=models, pairs=hard) if hard else None


def _typical(diagnosis: Diagnosis, placed: Hypothesis) -> CompetingHypothesis:
    """Return the model with an effect of its typical size, all else as it is: what the imitator has to make up for."""
    size = np.array([[parameter.typical for parameter in placed.effect.parameters]])
    fits = []
    for fit, runs in zip(_fits(diagnosis, diagnosis.model), (diagnosis.runs, diagnosis.heldout), strict=False):
        assert runs is not None
        values = replace(fit.values, effects=(*fit.values.effects, size))
        fits.append(evaluated(runs, (*fit.placed, placed), values))
    return CompetingHypothesis(key=placed.key, fits=tuple(fits))
