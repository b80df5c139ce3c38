"""The diagnosis: is there a gap, what explains it, add it, and again until nothing is left or the rest is unknown."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from types import MappingProxyType

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.evidence import goodness, on_all_runs
from testbed.diagnosis.fitting import fitted, fitted_initial_rates
from testbed.diagnosis.gyro_errors import corrected
from testbed.diagnosis.hypotheses import hypotheses, without
from testbed.diagnosis.latent import latent_torque
from testbed.diagnosis.model import Fit, Placed
from testbed.diagnosis.noise import noise_level
from testbed.diagnosis.scatter import scatter_found, widened
from testbed.diagnosis.screening import Candidate, Screening, refitted, screened
from testbed.diagnosis.state import Diagnosis, Gap, Step
from testbed.diagnosis.torque_shapes import torque_shapes
from testbed.effects.contract import Effect, ReadingEffect

MOST_EFFECTS = 3


def diagnosed(
    runs: Runs,
    heldout: Runs | None,
    effects: Mapping[str, Effect],
    nominal_theta: Theta,
    progress: Callable[[str], None] = lambda _: None,
    reading_effects: Mapping[str, ReadingEffect] = MappingProxyType({}),
) -> Iterator[Diagnosis]:
    """Yield what is known after every stage; the last one is complete.

    Args:
        runs: to fit.
        heldout: to verify on, never fitted but for their initial rates.
        effects: by id.
        nominal_theta: to start from, kg·m².
        progress: told what is being done.
        reading_effects: those on the scatter of the gyro's samples, by id.

    Raises:
        InputError: the nominal motion leaves the finite numbers.
    """
    progress("baseline")
    first = fitted(runs, [], nominal_theta, [])
    noise = noise_level(runs, first)
    testable, untestable = hypotheses(runs, effects)
    gap = _gap(first, heldout)
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
    )
    stated = state

    def scattered(now: Diagnosis) -> Diagnosis:
        return _with_scatter(now, stated, reading_effects, len(testable))

    state = scattered(state)
    yield state
    search = _Search(testable=tuple(testable), progress=progress)
    while len(state.steps) < MOST_EFFECTS:
        screening = search.screened(state)
        state = replace(state, remaining=screening)
        if screening.chosen is None:
            break
        state = search.reconsidered(_with_effect(state, screening.chosen, screening))
        state = scattered(state)
        yield state
    progress("what is left")
    yield _concluded(state)


def _concluded(state: Diagnosis) -> Diagnosis:
    """Look at what is left, and take back effects that explain less than a torque does that no effect makes."""
    nominal = _refitted(state.runs, state.baseline)
    everything, fit = on_all_runs(state.runs, state.heldout, nominal)
    shapes = torque_shapes(everything, fit)
    state = replace(state, unlisted=shapes[0].evidence)
    if state.steps:
        if state.unlisted > sum(step.screening.odds(step.candidate) for step in state.steps):
            first = state.steps[0].screening
            back = _with_model(replace(state, steps=(), remaining=first), nominal)
            state = replace(back, taken_back=tuple(step.placed for step in state.steps))
        else:
            everything, fit = on_all_runs(state.runs, state.heldout, state.model)
            shapes = torque_shapes(everything, fit)
    return replace(
        state,
        latent=latent_torque(state.runs, state.model),
        shapes=shapes,
        goodness=goodness(fit, everything.noise_freedom),
        complete=True,
    )


@dataclass(frozen=True, kw_only=True)
class _Search:
    """Forward and backward steps among the hypotheses.

    Attributes:
        testable: all of them.
        progress: told what is being done.
    """

    testable: tuple[Placed, ...]
    progress: Callable[[str], None]

    def screened(self, state: Diagnosis) -> Screening:
        """Compare all hypotheses with the present model."""
        others = without(self.testable, state.model.placed)
        return screened(state.runs, state.heldout, state.model, others, self.progress)

    def reconsidered(self, state: Diagnosis) -> Diagnosis:
        """Ask of each earlier effect, with the newest in the model, whether it still stands or another does better."""
        for index, step in enumerate(state.steps[:-1]):
            less = self._rebuilt(state, [other.placed for other in (*state.steps[:index], *state.steps[index + 1 :])])
            screening = self.screened(less)
            chosen = screening.chosen
            if chosen is None:
                return less
            if chosen.placed.key != step.placed.key:
                return _with_effect(less, chosen, screening)
        return state

    def _rebuilt(self, state: Diagnosis, placed: Sequence[Placed]) -> Diagnosis:
        """Return a diagnosis with just these effects, added to the baseline one after the other."""
        model = fitted(state.runs, [], state.baseline.theta, [])
        rebuilt = _with_model(replace(state, steps=()), model)
        screening = state.steps[0].screening
        for each in placed:
            candidate = refitted(rebuilt.runs, rebuilt.heldout, rebuilt.model, screening, each)
            rebuilt = _with_effect(rebuilt, candidate, screening)
            screening = self.screened(rebuilt) if each is not placed[-1] else screening
        return rebuilt


def _with_effect(state: Diagnosis, chosen: Candidate, screening: Screening) -> Diagnosis:
    after = _with_model(state, chosen.fit)
    step = Step(candidate=chosen, screening=screening, before=state.gap, after=after.gap)
    return replace(after, steps=(*state.steps, step))


def _with_model(state: Diagnosis, model: Fit) -> Diagnosis:
    """Take over a model, and what it knows of the gyro's errors; the gimbals' channels are then predicted anew."""
    runs, heldout = corrected(state.runs, model), state.heldout
    if heldout is not None:
        heldout = corrected(heldout, fitted_initial_rates(heldout, model))
    model = _refitted(runs, model)
    return replace(state, runs=runs, heldout=heldout, model=model, gap=_gap(model, heldout))


def _with_scatter(state: Diagnosis, stated: Diagnosis, effects: Mapping[str, ReadingEffect], others: int) -> Diagnosis:
    """Tell the scatter anew from what the present model leaves: what looked like noise may have got a name."""
    runs, heldout = state.runs.with_sigma(stated.runs.sigma), state.heldout
    if heldout is not None and stated.heldout is not None:
        heldout = heldout.with_sigma(stated.heldout.sigma)
    model = _refitted(runs, state.model) if state.scatter else state.model
    found = scatter_found(runs, model, effects, others)
    if found:
        runs = runs.with_sigma(widened(runs.sigma, found))
        heldout = None if heldout is None else heldout.with_sigma(widened(heldout.sigma, found))
        model = _refitted(runs, model)
    return replace(state, runs=runs, heldout=heldout, model=model, gap=_gap(model, heldout), scatter=found)


def _refitted(runs: Runs, fit: Fit) -> Fit:
    return fitted(runs, fit.placed, fit.theta, [value[0] for value in fit.values.effects])


def _gap(fit: Fit, heldout: Runs | None) -> Gap:
    held = np.nan if heldout is None else _root_mean_square(fitted_initial_rates(heldout, fit))
    return Gap(fit=_root_mean_square(fit), heldout=held)


def _root_mean_square(fit: Fit) -> float:
    return sqrt(fit.chi_square / len(fit.residual))
