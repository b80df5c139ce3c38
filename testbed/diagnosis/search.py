"""The search for the effects that are in the model: all hypotheses screened, steps forward and back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import isinf, log

import numpy as np
from scipy.special import logsumexp

from testbed.arrays import Vectors3
from testbed.diagnosis.candidates import Candidate, Screening, accepted
from testbed.diagnosis.control_loop import shows_the_loop
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import all_corrected, fitted, fitted_initial_rates, in_torque_noise, refit
from testbed.diagnosis.misfit import Prior, heldout_misfit_of, log_evidence, misfit_of
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.p_values import largest_log_odds, log_p_value
from testbed.diagnosis.screening import (
    held_out_evidence,
    p_value_of_all,
    refitted,
    scan_count_of,
    screened,
)
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis, Gap, Step
from testbed.diagnosis.testable import without
from testbed.diagnosis.torque_shapes import evidence_of_any
from testbed.diagnosis.touches import touching_by_residual, without_common_touch
from testbed.errors import InputError


def odds_together(
    without: tuple[Runs | None, Fit], within: tuple[Runs | None, Fit], tested: int, effects: Sequence[Candidate]
) -> float:
    """Return twice the logarithm of the posterior odds of several effects together against none.

    It is not the sum of their log odds when they were added: each was compared with the model of that step.

    Args:
        without: the model without them, and the held-out runs as it knows them; None where there are none.
        within: the model with them, fitted to the same runs, and likewise.
        tested: number of hypotheses.
        effects: as they were added.
    """
    gain = without[1].deviance - within[1].deviance + _held_out_gain(without, within)
    return gain - penalty_of(effects, tested)


def penalty_of(effects: Sequence[Candidate], tested: int) -> float:
    """Return by how much effects have to explain more than nothing: for their sizes and starts, and as one of many."""
    return sum(each.size_penalty + 2.0 * (log(tested) + each.trials_penalty) for each in effects)


def _held_out_gain(without: tuple[Runs | None, Fit], within: tuple[Runs | None, Fit]) -> float:
    """Return by how much the evidence of held-out runs is larger within a model than without its effects."""
    return held_out_evidence(*within) - log_evidence(*without)


def log_odds_of_all(state: Diagnosis, bare: Diagnosis) -> float:
    """Return twice the logarithm of the odds of all effects in the model together against the nominal one."""
    effects, tested = [step.candidate for step in state.steps], state.steps[0].screening.tested
    return odds_together((bare.heldout, bare.model), (state.heldout, state.model), tested, effects)


def log_odds_of_class(state: Diagnosis) -> float:
    """Return the same, summed over the equivalence class of the first effect."""
    first = state.steps[0]
    further = [each.log_bayes_factor - first.candidate.log_bayes_factor for each in first.screening.close]
    return state.explained + 2.0 * float(logsumexp(0.5 * np.array(further)))


def odds_of_unmodelled(state: Diagnosis, screening: Screening) -> float:
    """Return twice the logarithm of the odds of an unmodelled torque beside a model, against none.

    Args:
        state: with the shapes of its residual tested.
        screening: whose hypotheses it is one of.
    """
    return evidence_of_any(state.shapes, screening.tested, screening.prior_odds.unmodelled)


def with_candidate(state: Diagnosis, screening: Screening, placed: Hypothesis, known: Fit) -> Screening:
    """Return a screening of a model with one hypothesis among those that were refitted.

    The same screening if an effect in the model confounds the hypothesis, so that it was not tested.

    Args:
        state: the model.
        screening: of the hypotheses against it.
        placed: the hypothesis.
        known: the model with it, as in `refitted`.
    """
    if not screening.tests(placed):
        return screening
    candidate = refitted(state.runs, state.heldout, state.model, screening, placed, known)
    if candidate is None or candidate.cancels or candidate in screening.candidates:
        return screening
    others = [each for each in screening.candidates if each.placed.key != placed.key]
    return replace(screening, candidates=tuple(sorted((*others, candidate), key=lambda each: -each.log_bayes_factor)))


_UNSEEN = 0.01
"""Of the gyro's noise: by less do its errors differ between two fits of one model, which end within 1e-3 of χ²; a
screening is taken over where they do. A hundredth of sigma changes χ² by 1e-4 a sample."""


@dataclass(frozen=True, kw_only=True)
class Search:
    """Forward and backward steps among the hypotheses.

    Attributes:
        testable: all of them.
        progress: called with what is being done.
        in_own_noise: what a diagnosis becomes in the noise that its model leaves.
        most: effects that are added at most.
        known: screenings so far, by the effects in the model; steps back come to the same model again.
    """

    testable: tuple[Hypothesis, ...]
    progress: Callable[[str], None]
    in_own_noise: Callable[[Diagnosis], Diagnosis]
    most: int = SETTINGS.most_effects
    known: dict[tuple[str, ...], tuple[Runs, Screening]] = field(default_factory=dict)

    def has_room(self, state: Diagnosis) -> bool:
        """Return whether another effect may be added."""
        of_loop = shows_the_loop(state.runs, state.model)
        return len(state.steps) < (SETTINGS.most_effects_of_loop if of_loop else self.most)

    def screened(self, state: Diagnosis) -> Screening:
        """Compare all hypotheses with the present model; what is probable is tested in the noise that it leaves."""
        screening = self._tested_in_own_noise(state, self.compared(state))
        return without_common_touch(state.runs, state.model, screening)

    def compared(self, state: Diagnosis) -> Screening:
        """Compare all hypotheses with the present model, in its noise."""
        key = tuple(placed.key for placed in state.model.placed)
        runs, screening = self.known.get(key, (None, None))
        if runs is None or screening is None or not _has_equal_noise(runs, state.runs):
            others = touching_by_residual(state.runs, state.model, without(self.testable, state.model.placed))
            screening = screened(state.runs, state.heldout, state.model, others, self.progress)
            self.known[key] = (state.runs, screening)
        return screening

    def reconsidered(self, state: Diagnosis) -> Diagnosis:
        """Test every earlier effect again, with the newest in the model, until nothing changes."""
        for _ in range(SETTINGS.most_effects):
            try:
                changed = self._once_reconsidered(state)
            except InputError:  # without one of them the motion runs away: each is needed
                break
            if changed is state:
                break
            state = changed
        return self._with_own_classes(state)

    def _once_reconsidered(self, state: Diagnosis) -> Diagnosis:
        """Return the diagnosis without the first effect that does not stand, or with what does better in its place."""
        for index, step in enumerate(state.steps[:-1]):
            less, screening = self._compared_without(state, index)
            screening = self._tested_in_own_noise(less, screening)
            chosen = accepted(screening)
            kept = [other.placed for other in (*state.steps[:index], *state.steps[index + 1 :])]
            if chosen is None:
                return self._rebuilt(state, kept)
            if chosen.placed.key != step.placed.key:
                return with_effect(self._rebuilt(state, kept), chosen, screening)
        return state

    def _compared_without(self, state: Diagnosis, index: int) -> tuple[Diagnosis, Screening]:
        """Return the diagnosis without an effect, and the hypotheses against all others that are in the model."""
        kept = [other.placed for other in (*state.steps[:index], *state.steps[index + 1 :])]
        less = with_model(state, _less(state, kept))
        return less, with_candidate(less, self.compared(less), state.steps[index].placed, state.model)

    def standing(self, state: Diagnosis) -> Diagnosis:
        """Return the diagnosis without an effect that does not stand out of its noise; the same one where all do.

        Effects are found in noise of which the fastest part of the residual tells; this one is known from all of it,
        and stays as it is. The newest effect is tested first. Where another one would stand in its place it stays, as
        something is there; beside a bias that walks the other one takes it, as the first may have been that walk.
        """
        for index, step in reversed(list(enumerate(state.steps))):
            kept = [other.placed for other in (*state.steps[:index], *state.steps[index + 1 :])]
            less = with_model(state, _less(state, kept))
            if accepted(_again(less, step)) is not None:
                continue
            chosen = accepted(screening := self.compared(less))
            if chosen is None:
                return replace(self._rebuilt(state, kept), remaining=screening)
            if state.walks:
                return with_effect(self._rebuilt(state, kept), chosen, screening)
        return state

    def _tested_in_own_noise(self, state: Diagnosis, screening: Screening) -> Screening:
        """Return a screening in which what is probable but not significant is tested in the noise that it leaves.

        What a model lacks may pass for a colour of the noise, whose slow part is then hardly known. The noise of an F
        test is what the larger model leaves.
        """
        if isinf(state.runs.noise_freedom) or state.runs.known_in_part:
            return screening
        candidates = [
            self._in_its_noise(state, each, screening.tested)
            if screening.odds(each) > 0.0 and not each.significant
            else each
            for each in screening.candidates
        ]
        return replace(screening, candidates=tuple(sorted(candidates, key=lambda each: -each.log_bayes_factor)))

    def _in_its_noise(self, state: Diagnosis, candidate: Candidate, tested: int) -> Candidate:
        """Return a candidate with its p-value in the noise that the model with it leaves, if it can be fitted there.

        If it is not significant then, its evidence is at most what its own p-value allows, that of one test: evidence
        takes the noise for known.
        """
        try:
            alone, starts, heldout_gain = self._test_in_its_noise(state, candidate)
        except (InputError, np.linalg.LinAlgError):  # in that noise the motion runs away
            again, of_one_test = candidate, candidate.p_value / tested
        else:
            again = replace(candidate, p_value=p_value_of_all(alone, tested * starts, heldout_gain))
            of_one_test = p_value_of_all(alone, starts, heldout_gain)
        if again.significant:
            return again
        return replace(again, log_bayes_factor=min(again.log_bayes_factor, largest_log_odds(of_one_test)))

    def _test_in_its_noise(self, state: Diagnosis, candidate: Candidate) -> tuple[float, int, float]:
        """Return the logarithm of a candidate's p-value of one test, its starts, and what held-out runs gain."""
        larger = self.in_own_noise(with_model(state, candidate.fit))
        smaller = with_model(larger, _less(larger, state.model.placed[len(state.baseline.placed) :]))
        gain = max(smaller.model.chi_square - larger.model.chi_square, 0.0)
        alone = log_p_value(gain, max(candidate.rank, 1), larger.runs.noise_freedom)
        without, within = (smaller.heldout, smaller.model), (larger.heldout, larger.model)
        heldout_gain = _held_out_gain(without, within) if candidate.placed.effect.recurs else 0.0
        return alone, scan_count_of(larger.runs, candidate.placed), heldout_gain

    def _rebuilt(self, state: Diagnosis, placed: Sequence[Hypothesis]) -> Diagnosis:
        """Return a diagnosis with just these effects, added to the baseline one after the other."""
        bare = state.baseline
        model = fitted(state.runs, bare.placed, bare.theta, [value[0] for value in bare.values.effects])
        rebuilt = with_model(replace(state, steps=()), model)
        first = state.steps[0]
        # With a class of its own it was compared beside all others (`_with_own_classes`).
        beside_none = len(first.candidate.fit.placed) == len(bare.placed) + 1
        screening = first.screening if beside_none else self.compared(rebuilt)
        for each in placed:
            if not screening.tests(each):  # it was found later than these
                screening = self.compared(rebuilt)
            if not screening.tests(each):  # those before it confound it
                continue
            candidate = refitted(rebuilt.runs, rebuilt.heldout, rebuilt.model, screening, each)
            if candidate is None:
                continue
            rebuilt = with_effect(rebuilt, candidate, screening)
            screening = self.compared(rebuilt) if each is not placed[-1] else screening
        return rebuilt

    def _with_own_classes(self, state: Diagnosis) -> Diagnosis:
        """Return a diagnosis in which no effect has the class of another, which was the best one when it was added."""
        for index, step in enumerate(state.steps):
            if not any(other.key == step.candidate.key for other in step.screening.close):
                state = self._classed(state, index)
        return state

    def classed_anew(self, state: Diagnosis) -> Diagnosis:
        """Return a diagnosis in which every effect has its class in the present noise."""
        for index in range(len(state.steps)):
            state = self._classed(state, index)
        return state

    def _classed(self, state: Diagnosis, index: int) -> Diagnosis:
        """Return a diagnosis in which an effect has the class of what explains as much beside all others in the model.

        As it is where the motion runs away without it, or the effect is not among what is promising.
        """
        step = state.steps[index]
        try:
            _, screening = self._compared_without(state, index)
        except InputError:
            return state
        found = next((each for each in screening.candidates if each.key == step.candidate.key), None)
        if found is None:
            return state
        own = replace(step, candidate=found, screening=screening)
        return replace(state, steps=(*state.steps[:index], own, *state.steps[index + 1 :]))


def _less(state: Diagnosis, kept: Sequence[Hypothesis]) -> Fit:
    """Return a model with but some of its effects, fitted from where it stands."""
    values = dict(zip([each.key for each in state.model.placed], state.model.values.effects, strict=True))
    kept = [*state.baseline.placed, *kept]
    return fitted(state.runs, kept, state.model.theta, [values[each.key][0] for each in kept], state.model)


def _again(state: Diagnosis, step: Step) -> Screening:
    """Return the screening of an effect that is in the model no more, with it alone refitted in the present noise."""
    bare = replace(step.screening, candidates=())
    try:
        again = refitted(state.runs, state.heldout, state.model, bare, step.placed)
    except (InputError, np.linalg.LinAlgError):  # with it the motion runs away
        return bare
    return bare if again is None else replace(bare, candidates=(again,))


def _has_equal_noise(one: Runs, other: Runs) -> bool:
    """Return whether two sets of the same runs have the same noise and gyro errors, as near as nobody sees."""
    if np.abs(np.log(one.sigma / other.sigma)).max() > _UNSEEN or not _has_equal_color(one, other):
        return False
    if len(one.estimated_noise) != len(other.estimated_noise):
        return False
    if one.torque_noise is not other.torque_noise or one.slow_bias != other.slow_bias:
        return False
    both = list(zip(one.grid.runs, other.grid.runs, strict=True))
    errors = all(
        _is_nearly(run.gyro_error, twin.gyro_error, run.gyro_noise)
        and _is_nearly(run.reading_error, twin.reading_error, run.gyro_noise)
        for run, twin in both
    )
    estimated = zip(one.estimated_noise, other.estimated_noise, one.grid.runs, strict=False)  # of every run, or of none
    return errors and all(_is_nearly(mine, theirs, run.gyro_noise) for mine, theirs, run in estimated)


def _has_equal_color(one: Runs, other: Runs) -> bool:
    if one.color is None or other.color is None:
        return one.color is other.color
    apart = (one.color.persistence - other.color.persistence, one.color.average - other.color.average)
    return float(np.abs(apart).max()) < _UNSEEN


def _is_nearly(one: Vectors3 | None, other: Vectors3 | None, noise: float) -> bool:
    if one is None or other is None:
        return one is other
    return bool(np.abs(one - other).max() < _UNSEEN * noise)


def with_effect(state: Diagnosis, chosen: Candidate, screening: Screening) -> Diagnosis:
    """Add an effect to the model.

    Args:
        state: what is known.
        chosen: the effect, refitted with all that is in the model.
        screening: in which it was compared.
    """
    after = with_model(state, chosen.fit)
    before = state.gap if after.model.torque_noise is None else _gap_in_noise_of(after, state.model)
    step = Step(candidate=chosen, screening=screening, before=before, after=after.gap)
    return replace(after, steps=(*state.steps, step))


def with_model(state: Diagnosis, model: Fit) -> Diagnosis:
    """Take over a model, and what it knows of the gyro's errors; the gimbals' channels are then predicted anew."""
    runs = replace(state.runs, torque_noise=model.torque_noise)
    heldout = state.heldout and replace(state.heldout, torque_noise=model.torque_noise)
    runs, heldout = all_corrected(runs, heldout, model)
    runs, heldout, model = in_torque_noise(runs, heldout, refit(runs, model))
    return replace(state, runs=runs, heldout=heldout, model=model, gap=gap_of(runs, model, heldout))


def _gap_in_noise_of(state: Diagnosis, model: Fit) -> Gap:
    """Return the gap of another model in the noise of this one: in noise of its own hardly any model has one."""
    return gap_of(state.runs, refit(state.runs, model), state.heldout)


def gap_of(runs: Runs, fit: Fit, heldout: Runs | None) -> Gap:
    """Return the gap of a model.

    Args:
        runs: that it was fitted to.
        fit: of the model.
        heldout: that were held out; None where there are none.
    """
    mine, misfit = fit.root_mean_square, misfit_of(runs, fit)
    if heldout is None:
        return Gap(fit=mine, heldout=np.nan, misfit=misfit, heldout_misfit=None)
    seen = fitted_initial_rates(heldout, fit)
    held = heldout_misfit_of(heldout, seen, Prior.of(fit))
    return Gap(fit=mine, heldout=seen.root_mean_square, misfit=misfit, heldout_misfit=held)
