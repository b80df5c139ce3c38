"""The search for the effects that are in the model: all hypotheses screened, steps forward and back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import exp, inf, isinf, log

import numpy as np
from scipy.special import logsumexp

from testbed.arrays import Array, Vectors3
from testbed.diagnosis.candidates import (
    Candidate,
    Screening,
    SizePrior,
    accepted,
    largest_log_odds,
    log_p_value,
    mean_over_scan,
)
from testbed.diagnosis.data import Runs, Shown
from testbed.diagnosis.misfit import Prior, heldout_misfit_of, log_evidence, misfit_of
from testbed.diagnosis.model import (
    Fit,
    Hypothesis,
    all_corrected,
    fitted,
    fitted_initial_rates,
    in_torque_noise,
    refit,
)
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.signatures import Signature, Start, reach_of, signatures, without
from testbed.diagnosis.state import Diagnosis, Gap, Step
from testbed.dynamics.inertia import inertia_of
from testbed.effects.actuator_gain import ActuatorGain
from testbed.errors import InputError

_SHARES = (1.0, 0.1, 0.0)
"""Of the linearised solution, from which a refit starts one after the other until one comes near what it promised: all
of it, a tenth, none. Of effects of eight detectable sizes the whole may be of no body: a mode left a platform without
inertia (seed 1, 2 of 6 such modes), and is named from a tenth."""
_LOST = 30.0
"""Of χ², by which a refit may fall short of the gain that the linearised effect promises, and is not started from less:
five times what decides between hypotheses. Of 126 refits of effects without a scan (cases 9 and 12 of 14 of seed 90817)
none falls short by more than 1.9: what falls short by 30 has lost its way."""

_LOST_SHARE = 0.3
"""Share of the promised gain, over windows of torque that is known in part, by which a refit may fall short as well:
what is promised there are hundreds, which is far from linear, and each refit takes seconds."""


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
    (before_heldout, before), (after_heldout, after) = without, within
    gain = before.deviance - after.deviance - sum(each.size_penalty for each in effects)
    heldout_gain = _held_out_evidence(after_heldout, after) - log_evidence(before_heldout, before)
    return gain + heldout_gain - 2.0 * sum(log(tested) + each.trials_penalty for each in effects)


def log_odds_of_all(state: Diagnosis, bare: Diagnosis) -> float:
    """Return twice the logarithm of the odds of all effects in the model together against the nominal one."""
    effects, tested = [step.candidate for step in state.steps], state.steps[0].screening.tested
    return odds_together((bare.heldout, bare.model), (state.heldout, state.model), tested, effects)


def log_odds_of_class(state: Diagnosis) -> float:
    """Return the same, summed over the equivalence class of the first effect."""
    first = state.steps[0]
    further = [each.log_bayes_factor - first.candidate.log_bayes_factor for each in first.screening.close]
    return state.explained + 2.0 * float(logsumexp(0.5 * np.array(further)))


def screened(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    hypotheses: Sequence[Hypothesis],
    progress: Callable[[str], None] = lambda _: None,
    least: float = -inf,
) -> Screening:
    """Test every hypothesis, and refit those that explain the most.

    Args:
        runs: that the model was fitted to.
        heldout: to verify on; None where there are none.
        fit: the present model.
        hypotheses: effects that are not in it.
        progress: called with what is being refitted.
        least: linearised evidence of those that are refitted.
    """
    every = list(signatures(runs, fit, hypotheses))
    best = most_telling(every)
    tested, moment = max(len(best), 1), runs.mean_moment(fit.theta)
    linearised = {each.placed.key: _linearised_evidence(runs, each, moment) for each in best}
    order = sorted(best, key=lambda each: -linearised[each.placed.key])
    promising = [each for each in order[: SETTINGS.most_refits] if each.rank and linearised[each.placed.key] > least]
    candidates, aside, without = [], [], log_evidence(heldout, fit)
    for signature in promising:
        progress(signature.placed.key)
        candidate = _candidate(runs, heldout, fit, signature, tested, without)
        if candidate is None:
            aside.append(signature.placed)
        else:
            candidates.append(candidate)
    return Screening(
        signatures=tuple(best),
        tested=tested,
        candidates=tuple(sorted(candidates, key=lambda candidate: -candidate.log_bayes_factor)),
        linearised={key: each for key, each in linearised.items() if key not in {one.placed.key for one in promising}},
        set_aside=tuple(aside),
        prior_odds=runs.prior_odds,
    )


def most_telling(every: Sequence[Signature]) -> list[Signature]:
    """Return each hypothesis at the start at which it explains the most, with what is said at the others.

    Args:
        every: hypotheses at all their starts.
    """
    by_key: dict[str, list[Signature]] = {}
    for signature in every:
        by_key.setdefault(signature.placed.key, []).append(signature)
    return [_best_of(starts) for starts in by_key.values()]


def _best_of(starts: Sequence[Signature]) -> Signature:
    best = max(starts, key=lambda each: each.score)
    reaches = tuple(map(reach_of, starts)) if best.placed.effect.scans_frequencies else ()
    return replace(best, elsewhere=tuple(each.here for each in starts if each is not best), reaches=reaches)


def refitted(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    screening: Screening,
    placed: Hypothesis,
    known: Fit | None = None,
) -> Candidate | None:
    """Return one hypothesis of a screening, refitted whether it was promising or not.

    None where no motion of a body can be fitted with it.

    Args:
        runs: as in `screened`, like the held-out ones and the fit.
        heldout: see there.
        fit: see there.
        screening: of the hypotheses.
        placed: the hypothesis.
        known: the model with it that was found before; a search that ends far from as good begins from there again.
    """
    signature = next(each for each in screening.signatures if each.placed.key == placed.key)
    candidate = next((each for each in screening.candidates if each.placed.key == placed.key), None)
    if candidate is None:
        candidate = _candidate(runs, heldout, fit, signature, screening.tested, log_evidence(heldout, fit))
    if known is None or (candidate is not None and candidate.fit.deviance < known.deviance + _LOST):
        return candidate
    return _candidate(runs, heldout, fit, signature, screening.tested, log_evidence(heldout, fit), known)


def with_candidate(state: Diagnosis, screening: Screening, placed: Hypothesis, known: Fit) -> Screening:
    """Return a screening of a model with one hypothesis among those that were refitted.

    The same screening if an effect in the model confounds the hypothesis, so that it was not tested.

    Args:
        state: the model.
        screening: of the hypotheses against it.
        placed: the hypothesis.
        known: the model with it, as in `refitted`.
    """
    if all(each.placed.key != placed.key for each in screening.signatures):
        return screening
    candidate = refitted(state.runs, state.heldout, state.model, screening, placed, known)
    if candidate is None or candidate in screening.candidates:
        return screening
    others = [each for each in screening.candidates if each.placed.key != placed.key]
    return replace(screening, candidates=tuple(sorted((*others, candidate), key=lambda each: -each.log_bayes_factor)))


def _candidate(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    signature: Signature,
    tested: int,
    without: float,
    known: Fit | None = None,
) -> Candidate | None:
    placed = signature.placed
    try:
        runs, model = (
            (runs, _refitted(runs, fit, signature)) if known is None else _from_known(runs, fit, known, placed)
        )
        own_runs, heldout = all_corrected(runs, heldout, model)
        if own_runs is not runs:  # what the gyro is off by, it is off in the gimbals' channels as well
            model = refit(own_runs, model)
        in_own = in_torque_noise(own_runs, heldout, model)
    except (InputError, np.linalg.LinAlgError):  # with it the motion runs away: it does not explain these runs
        return None
    if not _shows_the_loop(in_own[0], in_own[2]):  # else its noise is no better known than the nominal model's
        own_runs, heldout, model = in_own
    if not _is_of_a_body(model):
        return None
    gain, size_evidence = _evidence_of_refit(runs, fit, model, signature)
    heldout_gain = _held_out_evidence(heldout, model) - without if placed.effect.recurs else 0.0
    if heldout_gain > 0.0 and fit.deviance > model.deviance:
        heldout_gain *= gain / (fit.deviance - model.deviance)
    here = size_evidence + heldout_gain
    evidence = _anywhere(runs, signature, here, runs.mean_moment(fit.theta))
    alone = log_p_value(gain, max(signature.rank, 1), runs.noise_freedom)
    return Candidate(
        placed=placed,
        fit=model,
        chi_square_reduction=gain,
        rank=signature.rank,
        trials_penalty=0.5 * (here - evidence),
        size_penalty=gain - size_evidence,
        heldout_log_likelihood_gain=heldout_gain,
        log_bayes_factor=evidence,
        by_run=own_runs.noise_deviance + [float((part**2).sum()) for part in runs.by_run(model.residual)],
        p_value=_p_value_of_all(alone, tested * _scan_count(runs, placed), heldout_gain),
    )


def _p_value_of_all(alone: float, tests: int, heldout_gain: float) -> float:
    """Return the p-value of a candidate.

    Args:
        alone: its logarithm by the fitted runs, of one test.
        tests: number of hypotheses, times that of its start values.
        heldout_gain: twice the logarithm of the held-out likelihood ratio.
    """
    corrected = alone + log(tests) - 0.5 * heldout_gain
    together = max(corrected, alone + log(SETTINGS.family_wise_error / SETTINGS.fitted_runs_p_value))
    return exp(min(together, 0.0))


def _evidence_of_refit(runs: Runs, fit: Fit, model: Fit, signature: Signature) -> tuple[float, float]:
    """Return by how much a hypothesis reduces the deviance beyond what healthy records show, and the evidence of that.

    Args:
        runs: that are fitted.
        fit: without the hypothesis.
        model: with it.
        signature: of the hypothesis, at the start of its search.
    """
    placed, gain = signature.placed, max(fit.deviance - model.deviance, 0.0)
    columns, own = model.signature_of(placed), model.effect_values[model.own(placed)]
    values = own - [each.absent for each in placed.effect.parameters]
    information, slope = columns.T @ columns, columns.T @ model.residual
    prior, shown = SizePrior.of(placed.effect, signature.start, runs.mean_moment(fit.theta)), _shown_of(runs, placed)
    if runs.belief is None or shown is None:
        return gain, prior.evidence_of_fit(gain, values, information, slope)
    left, new = runs.belief.left(shown, information, len(runs.record_names)), values - shown.mean
    gain *= _share(information, values, left, new)
    return gain, prior.evidence_of_fit(gain, new, left, np.zeros(len(new)))


def _evidence_at(runs: Runs, signature: Signature, start: Start, moment: float) -> float:
    """Return the evidence of a hypothesis linearised at a start, beyond what healthy records differ by.

    What they show in the mean was fitted, and is not compared with a linearisation where the effect is absent.
    """
    prior = SizePrior.of(signature.placed.effect, start.values, moment)
    shown = _shown_of(runs, signature.placed)
    if runs.belief is None or shown is None:
        return prior.evidence(start.information, start.slope)
    left = runs.belief.left(shown, start.information, len(runs.record_names))
    gain = start.score * _share(start.information, start.step, left, start.step)
    return prior.evidence_of_fit(gain, start.step, left, np.zeros(len(left)))


def _share(information: Array, values: Array, left: Array, new: Array) -> float:
    """Return the Wald statistic of what is new over that of all, between 0 and 1."""
    whole = float(values @ information @ values)
    return min(float(new @ left @ new) / whole, 1.0) if whole > 0.0 else 1.0


def _shown_of(runs: Runs, placed: Hypothesis) -> Shown | None:
    return None if runs.belief is None else runs.belief.shown_of(placed.key)


def _is_of_a_body(model: Fit) -> bool:
    """Return whether every axis of a model has an inertia."""
    return bool(np.linalg.eigvalsh(inertia_of(model.theta))[0] > 0.0)


def _scan_count(runs: Runs, placed: Hypothesis) -> int:
    return placed.effect.scan_count(placed.component, runs.grid)


def _linearised_evidence(runs: Runs, signature: Signature, moment: float) -> float:
    """Return the evidence of a hypothesis by its linearisation alone."""
    return _anywhere(runs, signature, _evidence_at(runs, signature, signature.here, moment), moment)


def _anywhere(runs: Runs, signature: Signature, here: float, moment: float) -> float:
    """Return the evidence of a hypothesis, averaged over the start values of its scan.

    Args:
        runs: that are fitted.
        signature: of the hypothesis.
        here: its evidence at the start that it is best at.
        moment: mean moment of inertia, kg·m².
    """
    elsewhere = [_evidence_at(runs, signature, start, moment) for start in signature.elsewhere]
    return mean_over_scan(here, elsewhere, _scan_count(runs, signature.placed))


def _held_out_evidence(heldout: Runs | None, fit: Fit) -> float:
    try:
        return log_evidence(heldout, fit)
    except InputError:  # what fits some runs and lets others run away is no platform
        return -inf


def _refitted(runs: Runs, fit: Fit, signature: Signature) -> Fit:
    """Search from the linearised solution, and from less of it where that leads nowhere: it may be of no body."""
    placed, starts = [*fit.placed, signature.placed], [value[0] for value in fit.values.effects]
    found: list[Fit] = []
    for start in _starts(runs, signature):
        try:
            found.append(fitted(runs, placed, fit.theta, [*starts, start]))
        except InputError:  # the motion runs away
            continue
        lost = _LOST if runs.belief is None else max(_LOST, _LOST_SHARE * signature.score)
        if fit.chi_square - found[-1].chi_square > signature.score - lost:
            break
    if not found:
        raise InputError(f"with {signature.placed.key} the motion runs away")
    return min(found, key=lambda each: each.chi_square)


def _from_known(runs: Runs, fit: Fit, known: Fit, placed: Hypothesis) -> tuple[Runs, Fit]:
    """Return runs in the noise of a model that was found before, and the same effects fitted to them from there."""
    values = dict(zip([each.key for each in known.placed], known.values.effects, strict=True))
    effects = [*fit.placed, placed]
    runs = replace(runs, torque_noise=known.torque_noise)
    return runs, fitted(runs, effects, known.theta, [values[each.key][0] for each in effects])


def _starts(runs: Runs, signature: Signature) -> Iterator[Array]:
    """Yield where to begin a search, inside the bounds: where healthy records have the effect, if they show it."""
    lower, upper = signature.placed.bounds
    shown = _shown_of(runs, signature.placed)
    if shown is not None:
        yield np.clip(shown.mean + [each.absent for each in signature.placed.effect.parameters], lower, upper)
    for share in _SHARES:
        yield np.clip(signature.start + share * signature.step, lower, upper)


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
        least: evidence of a linearised hypothesis from which on it is refitted.
        known: screenings so far, by the effects in the model; steps back come to the same model again.
    """

    testable: tuple[Hypothesis, ...]
    progress: Callable[[str], None]
    in_own_noise: Callable[[Diagnosis], Diagnosis]
    least: float = -inf
    known: dict[tuple[str, ...], tuple[Runs, Screening]] = field(default_factory=dict)

    def has_room(self, state: Diagnosis) -> bool:
        """Return whether another effect may be added."""
        of_loop = _shows_the_loop(state.runs, state.model)
        return len(state.steps) < (SETTINGS.most_effects_of_loop if of_loop else SETTINGS.most_effects)

    def screened(self, state: Diagnosis) -> Screening:
        """Compare all hypotheses with the present model."""
        key = tuple(placed.key for placed in state.model.placed)
        runs, screening = self.known.get(key, (None, None))
        if runs is None or screening is None or not _has_equal_noise(runs, state.runs):
            others = without(self.testable, state.model.placed)
            screening = screened(state.runs, state.heldout, state.model, others, self.progress, self.least)
            screening = self._tested_in_own_noise(state, screening)
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
        return state

    def _once_reconsidered(self, state: Diagnosis) -> Diagnosis:
        """Return the diagnosis without the first effect that does not stand, or with what does better in its place."""
        for index, step in enumerate(state.steps[:-1]):
            kept = [other.placed for other in (*state.steps[:index], *state.steps[index + 1 :])]
            less = with_model(state, _less(state, kept))
            screening = with_candidate(less, self.screened(less), step.placed, state.model)
            screening = self._tested_in_own_noise(less, screening)
            chosen = accepted(screening)
            if chosen is None:
                return self._rebuilt(state, kept)
            if chosen.placed.key != step.placed.key:
                return with_effect(self._rebuilt(state, kept), chosen, screening)
        return state

    def standing(self, state: Diagnosis) -> Diagnosis:
        """Return the diagnosis without an effect that does not stand out of its noise; the same one where all do.

        Effects are found in noise of which the fastest part of the residual tells; this one is known from all of it.
        The newest effect is tested first.
        """
        for index, step in reversed(list(enumerate(state.steps))):
            kept = [other.placed for other in (*state.steps[:index], *state.steps[index + 1 :])]
            less = with_model(state, _less(state, kept))
            again = self._tested_in_own_noise(less, _again(less, step))
            if accepted(again) is None and accepted(screening := self.screened(less)) is None:
                return replace(self._rebuilt(state, kept), remaining=screening)
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
        """Return a candidate with its p-value in the noise that the model leaves which has it.

        If that is not significant either, its odds are at most what the p-value allows: evidence takes the noise for
        known.
        """
        larger = self.in_own_noise(with_model(state, candidate.fit))
        kept = state.model.placed[len(state.baseline.placed) :]
        smaller = with_model(larger, _less(larger, kept))
        gain = max(smaller.model.chi_square - larger.model.chi_square, 0.0)
        alone = log_p_value(gain, max(candidate.rank, 1), larger.runs.noise_freedom)
        tests = tested * _scan_count(larger.runs, candidate.placed)
        again = replace(candidate, p_value=_p_value_of_all(alone, tests, candidate.heldout_log_likelihood_gain))
        if again.significant:
            return again
        most = largest_log_odds(again.p_value) + 2.0 * log(tested)
        return replace(again, log_bayes_factor=min(again.log_bayes_factor, most))

    def _rebuilt(self, state: Diagnosis, placed: Sequence[Hypothesis]) -> Diagnosis:
        """Return a diagnosis with just these effects, added to the baseline one after the other."""
        bare = state.baseline
        model = fitted(state.runs, bare.placed, bare.theta, [value[0] for value in bare.values.effects])
        rebuilt = with_model(replace(state, steps=()), model)
        screening = state.steps[0].screening
        for each in placed:
            if all(other.placed.key != each.key for other in screening.signatures):  # it was found later than these
                screening = self.screened(rebuilt)
            candidate = refitted(rebuilt.runs, rebuilt.heldout, rebuilt.model, screening, each)
            if candidate is None:
                continue
            rebuilt = with_effect(rebuilt, candidate, screening)
            screening = self.screened(rebuilt) if each is not placed[-1] else screening
        return rebuilt


def _shows_the_loop(runs: Runs, model: Fit) -> bool:
    """Return whether commands explain so little of the motion that records show the controller's answer to it.

    The geometric mean over the axes counts: about one axis an effect may still be missing.
    """
    gains = [each for each in model.placed if each.given and isinstance(each.effect, ActuatorGain)]
    if not runs.known_in_part or not gains:
        return False
    logarithms = model.effect_values[model.own(gains[0])]
    return not gains[0].effect.parameters[0].is_plausible(float(logarithms.mean()))


def _less(state: Diagnosis, kept: Sequence[Hypothesis]) -> Fit:
    """Return a model with but some of its effects, fitted from where it stands."""
    values = dict(zip([each.key for each in state.model.placed], state.model.values.effects, strict=True))
    kept = [*state.baseline.placed, *kept]
    return fitted(state.runs, kept, state.model.theta, [values[each.key][0] for each in kept])


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
    if one.torque_noise is not other.torque_noise:
        return False
    both = list(zip(one.grid.runs, other.grid.runs, strict=True))
    errors = all(_is_nearly(run.gyro_error, twin.gyro_error, run.gyro_noise) for run, twin in both)
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
