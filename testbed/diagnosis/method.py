"""The method: from measured runs to what the model is missing.

`diagnosed` is the whole of it, in the order of docs/diagnosis.md. Formulas and sources stand at the functions that are
called here. Before it comes the gate (`reading.data_set_of`), after it the report (`findings`, `result`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log
from types import MappingProxyType

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.bias_walk import standing_beside_walk, with_bias_walk
from testbed.diagnosis.candidates import Candidate, Screening, accepted
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted, fitted_initial_rates, in_torque_noise, refit, starts_of
from testbed.diagnosis.formulas import may_follow_formulas, with_formulas
from testbed.diagnosis.latent import goodness, latent_torque, on_all_runs
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.noise import Residuals, noise_tests, with_noise_model
from testbed.diagnosis.noise_level import deviance, noise_level, readings_of
from testbed.diagnosis.own_effects import require_kept
from testbed.diagnosis.own_sizes import as_healthy_records_differ, saying_what_differs, with_own_sizes
from testbed.diagnosis.search import (
    Search,
    gap_of,
    log_odds_of_all,
    log_odds_of_class,
    odds_of_unmodelled,
    penalty_of,
    with_effect,
    with_model,
)
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.diagnosis.tachometers import distinct_from_tachometers, shown_beside_tachometers
from testbed.diagnosis.testable import hypotheses, without
from testbed.diagnosis.torque_shapes import no_better_than_together, torque_shapes
from testbed.diagnosis.trims import log_odds_of_own_trims, may_share_a_trim, with_one_trim
from testbed.effects.contract import Effect
from testbed.effects.noise_effect import NoiseEffect
from testbed.errors import InputError


def diagnosed(
    runs: Runs,
    heldout: Runs | None,
    effects: Mapping[str, Effect],
    nominal_theta: Theta,
    progress: Callable[[str], None] = lambda _: None,
    noise_effects: Mapping[str, NoiseEffect] = MappingProxyType({}),
    *,
    alone: bool = False,
    given: Sequence[Hypothesis] = (),
    most: int = SETTINGS.most_effects,
) -> Iterator[Diagnosis]:
    """Yield what is known after every stage; the last one is complete.

    Where torques are applied, the records have one trim of the actuators, until trims of their own are more probable
    than any effect; then all begins again with these (`Diagnosis.begins_again`).

    Args:
        runs: to fit.
        heldout: to verify on, never fitted but for their initial rates.
        effects: by id.
        nominal_theta: to start from, kg·m².
        progress: called with what is being tested.
        noise_effects: those on the scatter of the gyro's samples, by id.
        alone: whether all runs are of one record, which gets no name, as no other could verify it.
        given: effects that the nominal model has, as `Runs.belief` knows them.
        most: effects that are added at most.

    Raises:
        InputError: the nominal motion leaves the finite numbers.
    """
    task = _Task(
        effects=effects,
        nominal_theta=nominal_theta,
        progress=progress,
        noise_effects=noise_effects,
        alone=alone,
        given=tuple(given),
        most=most,
    )
    if may_share_a_trim(runs):
        for state in _with_given_up(task.stages(with_one_trim(runs), heldout and with_one_trim(heldout))):
            yield state
            if state.complete:
                return
        progress("a trim of each record")
    yield from _with_given_up(task.stages(runs, heldout))


def _with_given_up(stages: Iterable[Diagnosis]) -> Iterator[Diagnosis]:
    """Yield stages of one search; the last one knows which effects of earlier ones it neither names nor retracts."""
    added: dict[str, Hypothesis] = {}
    for state in stages:
        added |= {step.key: step.placed for step in state.steps}
        kept = {*state.step_keys, *(each.key for each in state.retracted)}
        gone = tuple(placed for key, placed in added.items() if key not in kept)
        yield replace(state, given_up=gone) if state.complete else state


@dataclass(frozen=True, kw_only=True)
class _Task:
    """What runs are tested for; attributes as the arguments of `diagnosed`."""

    effects: Mapping[str, Effect]
    nominal_theta: Theta
    progress: Callable[[str], None]
    noise_effects: Mapping[str, NoiseEffect]
    alone: bool
    given: tuple[Hypothesis, ...]
    most: int

    def stages(self, runs: Runs, heldout: Runs | None) -> Iterator[Diagnosis]:
        """Yield what is known after every stage; the last one is complete, unless the records have own trims."""
        effects, modes = shown_beside_tachometers(runs, self.effects, self.nominal_theta)
        testable, untestable = hypotheses(runs, effects, runs.mean_moment(self.nominal_theta))
        self.progress("baseline")
        noise_effects, hidden = distinct_from_tachometers(runs, {} if self.alone else self.noise_effects)
        first = replace(
            baseline(runs, heldout, self.nominal_theta, self.given),
            untestable=(*untestable, *modes, *hidden),
            alone=self.alone,
        )
        require_kept(runs, first.model, testable)
        noise = _NoiseStep(stated=first, effects=noise_effects, others=len(testable))
        state = noise.explained(first)
        yield state
        search = Search(
            testable=tuple(without(testable, self.given)),
            progress=self.progress,
            in_own_noise=noise.explained,
            most=self.most,
        )
        try:
            while search.has_room(state):
                # All are linearised, the most promising ones refitted and compared.
                screening = _without_cancelling(state, search.screened(state))
                state = replace(state, remaining=screening)
                if _trims_differ(state, screening, None if self.alone else accepted(screening)):
                    return
                state, chosen = (state, None) if self.alone else with_own_sizes(state, screening)
                larger = None if chosen is None else add(search, state, chosen, screening)
                if larger is None or _fits_worse(larger, state):  # what fits worse is no explanation
                    break
                state = noise.explained(larger)
                if _is_far_quieter(state, larger):
                    state = search.classed_anew(state)
                yield state
            self.progress("residual")
            state = with_bias_walk(check_residual(state, noise, search), search, noise.explained, _residual_tested)
            state = as_healthy_records_differ(state)
        except (InputError, np.linalg.LinAlgError) as error:  # the numbers leave a model that explained much: it stays
            yield replace(_ended_early(state, error), ended_early=True, complete=True)
            return
        try:
            if not self.alone and may_follow_formulas(state):
                named = with_formulas(state, search, noise.explained, _residual_tested)
                if named is not state:
                    state = with_bias_walk(named, search, noise.explained, _residual_tested, unnamed=state)
            state = saying_what_differs(state)
        except (InputError, np.linalg.LinAlgError) as error:  # the model without a formula has been tested
            state = _ended_early(state, error)
        yield replace(state, complete=True)


def _ended_early(state: Diagnosis, error: Exception) -> Diagnosis:
    return replace(state, notices=(*state.notices, f"the diagnosis ended early, with what it had: {error}"))


_CANCELLING = 2.0
"""Times its size from which on an effect has grown by what takes it away again.

Source: chosen: what is really there beside an effect that is confused with it has had a share of its size, so that it
shrinks; where only one was hidden it grew to five times and more (cases 142 and 188 of seed 6841)."""


def _without_cancelling(state: Diagnosis, screening: Screening) -> Screening:
    """Return hypotheses without those that take away what makes an effect grow with which they are confused.

    A late gyro of another shape than a low-pass is one of 14 ms, less telemetry that is late by 12.
    """
    kept = tuple(each for each in screening.candidates if not _cancels(state, each))
    return screening if len(kept) == len(screening.candidates) else replace(screening, candidates=kept)


def _cancels(state: Diagnosis, candidate: Candidate) -> bool:
    for step in state.steps:
        if candidate.key in {each.key for each in step.screening.close}:
            parameters = step.placed.effect.parameters
            sized = np.array([not each.scanned for each in parameters])
            absent = np.array([each.absent for each in parameters])
            before, after = (
                np.linalg.norm((fit.effect_values[fit.own(step.placed)] - absent)[sized])
                for fit in (state.model, candidate.fit)
            )
            if after > _CANCELLING * before:
                return True
    return False


def _trims_differ(state: Diagnosis, screening: Screening, chosen: Candidate | None) -> bool:
    """Return whether trims of their own explain records that share one better than the effect does that is chosen."""
    if not state.runs.trim_group:
        return False
    best = 0.0 if chosen is None else max(screening.odds(chosen), 0.0)
    return log_odds_of_own_trims(state.runs, state.model) > best


def baseline(runs: Runs, heldout: Runs | None, nominal_theta: Theta, given: Sequence[Hypothesis] = ()) -> Diagnosis:
    """Fit the nominal model: θ = J (6) and each run's initial rate by output error, ω integrated from the telemetry.

    J and the initial rates stay free in every later model, so that no effect is credited with what they can do. The
    misfit beyond noise of this model is what has to be explained.
    """
    model = fitted(runs, given, nominal_theta, starts_of(runs, given))
    gap = gap_of(runs, model, heldout)
    runs, heldout, model = in_torque_noise(runs, heldout, model)
    return Diagnosis(
        runs=runs,
        heldout=heldout,
        nominal_theta=nominal_theta,
        baseline=model,
        model=model,
        gap_before=gap,
        gap=gap_of(runs, model, heldout),
        noise=noise_level(readings_of(runs, model)),
    )


_QUIETER = 1.5
"""Times less noise than before from which on classes are compared anew.

Source: chosen: evidence then counts more than twice. What a model lacks had passed for a colour of the noise: of a
CubeSat's drag 4 of the 1,250 by which it was ahead of another one were seen."""


def _is_far_quieter(state: Diagnosis, before: Diagnosis) -> bool:
    return bool(np.median(before.runs.sigma / state.runs.sigma) > _QUIETER)


def _fits_worse(larger: Diagnosis, state: Diagnosis) -> bool:
    if state.runs.known_in_part:
        return larger.model.deviance > state.model.deviance
    return larger.gap.fit > state.gap.fit


def add(search: Search, state: Diagnosis, chosen: Candidate, screening: Screening) -> Diagnosis:
    """Add an effect to the model, then test every earlier one again; a better one replaces it."""
    return search.reconsidered(with_effect(replace(state, remaining=None), chosen, screening))


def check_residual(
    state: Diagnosis, noise: _NoiseStep, search: Search, before: frozenset[tuple[str, ...]] = frozenset()
) -> Diagnosis:
    """Test the residual of the final model for unmodelled torques, and its χ².

    If all of the residual may be noise, all of it estimates the noise, twice as precisely as its fastest part. Effects
    that do not stand out of the noise so estimated are taken out; one that was not added as it fits worse, or gave way
    to an unmodelled torque, may be a colour of it. It ends where the same effects stand again as once before.
    """
    unnamed = state.unnamed
    state = _residual_tested(state) if unnamed else _retracted(state)
    if state.runs.known_in_part:  # all of the residual estimates the noise with every model
        return state
    noisier = _tested_in_noise_of_all(state, noise, search)
    if noisier.structure_left:
        # What all of the residual says of the noise is reported with it, though none of it explains the structure.
        return replace(state, noise_candidates=noisier.noise_candidates) if state.structure_left else noisier
    if state.structure_left and not _noise_is_more_probable(noisier, state):
        return state
    standing = search.standing(noisier)
    beside_walk = standing_beside_walk(standing, search, noise.explained, _residual_tested)
    if beside_walk is not None:
        return beside_walk
    if standing is not noisier and standing.step_keys not in before:
        before |= {noisier.step_keys, standing.step_keys}
        return check_residual(noise.explained(standing), noise, search, before)
    # Names beside which another was found have not been compared with an unmodelled torque yet.
    return check_residual(noisier, noise, search) if unnamed and noisier.steps else noisier


def _tested_in_noise_of_all(state: Diagnosis, noise: _NoiseStep, search: Search) -> Diagnosis:
    """Return a diagnosis in the noise that all of its residual shows, the residual tested in it if it is another."""
    noisier = noise.explained(state, white=True)
    gain = _deviance(state) - _deviance(noisier)
    if not (noisier.scatter or state.left_over or gain > SETTINGS.noise_of_all_gain):
        return noisier
    noisier = _residual_tested(noisier)
    if noisier.unnamed:  # so far by a screening in the noise that the fastest part shows
        noisier = replace(noisier, remaining=search.compared(noisier), retracted=())
    if noisier.steps or noisier.remaining is None:
        return noisier
    return replace(noisier, unmodelled=odds_of_unmodelled(noisier, noisier.remaining))


def _retracted(state: Diagnosis) -> Diagnosis:
    """Test the residual; retract all effects if an unmodelled torque is clearly more probable.

    Such a torque stands against the whole class of names that are indistinguishable from the first one. Alone it cannot
    explain more than effects and torque together.
    """
    screening = state.steps[0].screening if state.steps else state.remaining
    assert screening is not None
    bare = _residual_tested(with_model(state, state.baseline) if state.steps else state)
    unmodelled = odds_of_unmodelled(bare, screening)
    differing = bare.differing if not state.steps and bare.differing_odds > unmodelled else None
    bare = replace(bare, steps=(), remaining=screening, differing=differing, unmodelled=unmodelled)
    if not state.steps:
        return bare
    tested = _residual_tested(state)
    explained = log_odds_of_all(state, bare)
    by_effects = explained + penalty_of([step.candidate for step in state.steps], screening.tested)
    shapes = no_better_than_together(bare.shapes, tested.shapes, by_effects)
    unmodelled = odds_of_unmodelled(replace(bare, shapes=shapes), screening)
    tested = replace(tested, unmodelled=unmodelled, explained=explained)
    if tested.unmodelled > log_odds_of_class(tested) + state.differing_odds + 2.0 * log(SETTINGS.retraction_odds):
        return replace(bare, retracted=tuple(step.placed for step in state.steps))
    return replace(tested, latent_before=bare.latent)


def _noise_is_more_probable(noisier: Diagnosis, state: Diagnosis) -> bool:
    """Return whether noise of another level and colour explains a residual's structure better than a torque does.

    By how much more probable it makes the samples, against the posterior odds of a torque of known shape or of sizes of
    every run's own, or against how much more probable a torque that walks makes them. Noise with a slow part has as
    much power at some frequencies as a hum, but spread over all near it.
    """
    screening = state.remaining or state.steps[0].screening
    walking = 0.0 if state.latent is None else state.latent.likelihood_ratio
    otherwise = max(odds_of_unmodelled(state, screening), walking, state.differing_odds)
    return _deviance(state) - _deviance(noisier) > otherwise


def _deviance(state: Diagnosis) -> float:
    """Return that of the samples of all runs."""
    fitted_runs = deviance(state.runs, state.model)
    if state.heldout is None:
        return fitted_runs
    seen = fitted_initial_rates(state.heldout, state.model)
    return fitted_runs + deviance(state.heldout, seen, first=6 + len(seen.effect_values))


def _residual_tested(state: Diagnosis) -> Diagnosis:
    """Test the residual of all runs for a torque of any shape, for torques of known shapes, and for its size."""
    everything, fit = on_all_runs(state.runs, state.heldout, state.model)
    return replace(
        state,
        latent=latent_torque(state.runs, state.model),
        shapes=torque_shapes(everything, fit),
        goodness=goodness(fit, everything.noise_freedom),
    )


@dataclass(frozen=True, kw_only=True)
class _NoiseStep:
    """The noise, explained anew with every model, as what looked like noise may have got a name.

    Attributes:
        stated: the baseline, whose runs have the noise that is stated.
        effects: on the scatter of the gyro's samples, by id.
        others: number of hypotheses on the motion, which share the prior with them.
    """

    stated: Diagnosis
    effects: Mapping[str, NoiseEffect]
    others: int

    def explained(self, state: Diagnosis, *, white: bool = False) -> Diagnosis:
        """Return the diagnosis with the noise that its residual shows: all of it if white, else its fastest part."""
        runs, heldout, model = state.runs, state.heldout, state.model
        if runs.known_in_part:  # the noise is the torque's as well, and was estimated with the model
            return state
        runs = replace(runs.as_stated(), noise_freedom=self.stated.runs.noise_freedom)
        if state.runs.stated_sigma is not None:
            model = refit(runs, model)
        if heldout is not None:
            heldout = replace(heldout.as_stated(), noise_freedom=self.stated.runs.noise_freedom)
        seen = None if heldout is None else fitted_initial_rates(heldout, model)
        residuals = Residuals(runs=runs, fit=model, heldout=heldout, seen=seen, white=white)
        scatter = noise_tests(residuals, self.effects, self.others)
        runs, heldout = with_noise_model(residuals, scatter.found)
        model = refit(runs, model)
        return replace(
            state,
            runs=runs,
            heldout=heldout,
            model=model,
            gap=gap_of(runs, model, heldout),
            noise=state.noise if state.steps else scatter.level,
            noise_candidates=state.noise_candidates if state.steps else scatter.tested,
            scatter=scatter.found,
        )
