"""The diagnosis: is there a gap, what explains it, add it, and again until nothing is left or the rest is unknown."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from scipy.special import logsumexp

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.evidence import goodness, on_all_runs
from testbed.diagnosis.latent import evidence_of_any, latent_torque, torque_shapes
from testbed.diagnosis.model import fitted, fitted_initial_rates, refit
from testbed.diagnosis.noise import believing, noise_level, scattering
from testbed.diagnosis.search import MOST_EFFECTS, Search, gap_of, odds_together, with_effect, with_model
from testbed.diagnosis.signatures import hypotheses
from testbed.diagnosis.state import Diagnosis
from testbed.effects.contract import Effect
from testbed.effects.reading_effect import ReadingEffect


def diagnosed(
    runs: Runs,
    heldout: Runs | None,
    effects: Mapping[str, Effect],
    nominal_theta: Theta,
    progress: Callable[[str], None] = lambda _: None,
    reading_effects: Mapping[str, ReadingEffect] = MappingProxyType({}),
    *,
    alone: bool = False,
) -> Iterator[Diagnosis]:
    """Yield what is known after every stage; the last one is complete.

    Args:
        runs: to fit.
        heldout: to verify on, never fitted but for their initial rates.
        effects: by id.
        nominal_theta: to start from, kg·m².
        progress: told what is being done.
        reading_effects: those on the scatter of the gyro's samples, by id.
        alone: whether all runs are of one record, which gets no name.

    Raises:
        InputError: the nominal motion leaves the finite numbers.
    """
    progress("baseline")
    first = fitted(runs, [], nominal_theta, [])
    noise = noise_level(runs, first)
    testable, untestable = hypotheses(runs, effects)
    gap = gap_of(runs, first, heldout)
    state = Diagnosis(
        runs=runs,
        heldout=heldout,
        nominal_theta=nominal_theta,
        baseline=first,
        model=first,
        gap_before=gap,
        gap=gap,
        noise=noise,
        untestable=tuple(untestable),
        alone=alone,
    )
    stated = state

    def scattered(now: Diagnosis, *, white: bool = False) -> Diagnosis:
        asked = {} if alone else reading_effects
        return _with_scatter(now, stated, asked, len(testable), white=white)

    state = scattered(state)
    yield state
    search = Search(testable=tuple(testable), progress=progress)
    while len(state.steps) < MOST_EFFECTS:
        screening = search.screened(state)
        state = replace(state, remaining=screening)
        if screening.chosen is None or alone:
            break
        state = search.reconsidered(with_effect(replace(state, remaining=None), screening.chosen, screening))
        state = scattered(state)
        yield state
    if not state.unnamed:
        progress("what is left")
        state = _left_over(state)
        noisier = scattered(state, white=True)
        if noisier.scatter:
            noisier = _looked_over(noisier)
        state = state if noisier.structure_left else noisier
    yield replace(state, complete=True)


def _left_over(state: Diagnosis) -> Diagnosis:
    """Look at what is left, and take back effects that explain less than a torque does that no effect makes."""
    screening = state.steps[0].screening if state.steps else state.remaining
    assert screening is not None
    bare = _looked_over(with_model(state, state.baseline) if state.steps else state)
    bare = replace(bare, steps=(), remaining=screening, unlisted=evidence_of_any(bare.shapes, screening.tested))
    if not state.steps:
        return bare
    state = replace(state, unlisted=bare.unlisted, explained=_odds(state, bare))
    if state.unlisted > _odds_of_class(state):
        return replace(bare, taken_back=tuple(step.placed for step in state.steps))
    return replace(_looked_over(state), latent_before=bare.latent)


def _looked_over(state: Diagnosis) -> Diagnosis:
    """Ask what the final model leaves: of torques, and whether it is as large as noise makes it."""
    everything, fit = on_all_runs(state.runs, state.heldout, state.model)
    return replace(
        state,
        latent=latent_torque(state.runs, state.model),
        shapes=torque_shapes(everything, fit),
        goodness=goodness(fit, everything.noise_freedom),
    )


def _odds(state: Diagnosis, bare: Diagnosis) -> float:
    """Return the odds of all effects in the model together against the nominal one."""
    effects, tested = [step.candidate for step in state.steps], state.steps[0].screening.tested
    return odds_together((bare.heldout, bare.model), (state.heldout, state.model), tested, effects)


def _odds_of_class(state: Diagnosis) -> float:
    """Return the odds of all effects together, whichever of those it is that the first one is not told from."""
    first = state.steps[0]
    further = [each.evidence - first.candidate.evidence for each in first.screening.close]
    return state.explained + 2.0 * float(logsumexp(0.5 * np.array(further)))


def _with_scatter(
    state: Diagnosis, stated: Diagnosis, effects: Mapping[str, ReadingEffect], others: int, *, white: bool
) -> Diagnosis:
    """Tell the scatter anew from what the present model leaves: what looked like noise may have got a name."""
    runs, heldout, model = state.runs, state.heldout, state.model
    if state.scatter:
        runs = _with_noise_of(stated.runs, runs)
        if heldout is not None and stated.heldout is not None:
            heldout = _with_noise_of(stated.heldout, heldout)
        model = refit(runs, model)
    said = scattering(runs, model, effects, others, white=white)
    found = said.found
    if found:
        heldout = None if heldout is None else believing(heldout, fitted_initial_rates(heldout, model), found)
        runs = believing(runs, model, found)
        model = refit(runs, model)
    asked = state.asked if state.steps else said.told
    gap = gap_of(runs, model, heldout)
    return replace(state, runs=runs, heldout=heldout, model=model, gap=gap, asked=asked, scatter=found)


def _with_noise_of(stated: Runs, runs: Runs) -> Runs:
    return replace(runs, sigma=stated.sigma, noise_freedom=stated.noise_freedom, told=stated.told)
