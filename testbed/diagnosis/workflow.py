"""The diagnosis: is there a gap, what explains it, add it, and again until nothing is left or the rest is unknown."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from types import MappingProxyType
from typing import Literal

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.evidence import goodness, on_all_runs
from testbed.diagnosis.hypotheses import Untestable, hypotheses, without
from testbed.diagnosis.latent import LatentTorque, latent_torque
from testbed.diagnosis.model import Fit, Placed, fitted, fitted_initial_rates
from testbed.diagnosis.noise import NoiseLevel, noise_level
from testbed.diagnosis.probabilities import by_class, probabilities_of
from testbed.diagnosis.scatter import Scatter, scatter_found, widened
from testbed.diagnosis.screening import Candidate, Screening, refitted, screened
from testbed.diagnosis.torque_shapes import TorqueShape, surest, torque_shapes
from testbed.effects.contract import Effect, ReadingEffect

MOST_EFFECTS = 3
UNEXPLAINED = 0.01
"""Below this probability of a χ² as large, or of a latent torque, the model is not the whole truth."""

Verdict = Literal["none", "named", "ambiguous", "unexplained"]


@dataclass(frozen=True, kw_only=True)
class Gap:
    """Root mean square of the whitened residual: 1 is the noise floor.

    Attributes:
        fit: of the runs that are fitted.
        heldout: of those that are not, only their initial rates fitted; NaN where there are none.
    """

    fit: float
    heldout: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """An effect that was added to the model.

    Attributes:
        candidate: the effect, and the model with it.
        screening: all that it was compared with.
        before: gap without it.
        after: gap with it.
    """

    candidate: Candidate
    screening: Screening
    before: Gap
    after: Gap

    @property
    def placed(self) -> Placed:
        """Effect and component."""
        return self.candidate.placed

    @property
    def look_alikes(self) -> tuple[Placed, ...]:
        """What the data do not tell from it."""
        return tuple(other.placed for other in self.screening.close if other.placed.key != self.placed.key)


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """What is known so far.

    Attributes:
        runs: that were fitted.
        heldout: that were not; None where there are none.
        nominal_theta: the nominal model's inertia, kg·m².
        baseline: the nominal model with inertia and initial rates re-estimated.
        model: with all effects added.
        gap_before: of the baseline.
        gap: of the model.
        noise: the gyro's noise against what is stated.
        scatter: effects on how the gyro's samples scatter, told anew with every model; the runs believe them.
        steps: effects in the order in which they were added.
        taken_back: effects that were added, and explain less than a torque does that no effect makes.
        remaining: the hypotheses against the final model; None until they were looked at.
        latent: torque that the final model leaves; None until it was looked at.
        shapes: of torques that no effect makes, against the final model, the one with the most evidence first.
        unlisted: the largest evidence of such a torque against the baseline.
        goodness: chance of a gyro residual of all runs as large as the final model's, if nothing is missing.
        untestable: effects for which a channel is missing.
        complete: whether the diagnosis came to its end.
    """

    runs: Runs
    heldout: Runs | None
    nominal_theta: Theta
    baseline: Fit
    model: Fit
    gap_before: Gap
    gap: Gap
    noise: NoiseLevel
    scatter: tuple[Scatter, ...] = ()
    steps: tuple[Step, ...] = ()
    taken_back: tuple[Placed, ...] = ()
    remaining: Screening | None = None
    latent: LatentTorque | None = None
    shapes: tuple[TorqueShape, ...] = ()
    unlisted: float = -inf
    goodness: float = 1.0
    untestable: tuple[Untestable, ...] = ()
    complete: bool = False

    @property
    def left_over(self) -> bool:
        """Whether the model leaves more than noise."""
        chances = [self.goodness, *(shape.p_value for shape in self.shapes)]
        if self.latent is not None:
            chances.append(self.latent.p_value)
        return min(chances) < UNEXPLAINED

    @property
    def shape_left(self) -> TorqueShape | None:
        """The torque of no effect that is left by more than chance; None where there is none."""
        shape = surest(self.shapes)
        return shape if shape is not None and shape.p_value < UNEXPLAINED else None

    @property
    def verdict(self) -> Verdict:
        """The answer in a word."""
        if self.left_over:
            return "unexplained"
        if not self.steps:
            return "named" if self.scatter else "none"
        return "ambiguous" if self.steps[0].look_alikes else "named"

    @property
    def unlisted_beside_steps(self) -> float:
        """Evidence of a torque of no effect, less what further effects explain beside the first one."""
        return self.unlisted - sum(step.screening.odds(step.candidate) for step in self.steps[1:])

    @property
    def probabilities(self) -> Mapping[str, float]:
        """Of none, of every class that is in question, and of something unknown."""
        screening = self.steps[0].screening if self.steps else self.remaining
        probabilities = probabilities_of(screening, self.unlisted_beside_steps)
        return by_class(probabilities, screening) if self.steps else probabilities


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
            back = replace(state, steps=(), remaining=first, model=nominal, gap=_gap(nominal, state.heldout))
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
        runs, heldout = state.runs, state.heldout
        model = fitted(runs, [], state.baseline.theta, [])
        rebuilt = replace(state, model=model, gap=_gap(model, heldout), steps=())
        screening = state.steps[0].screening
        for each in placed:
            candidate = refitted(runs, heldout, rebuilt.model, screening, each)
            rebuilt = _with_effect(rebuilt, candidate, screening)
            screening = self.screened(rebuilt) if each is not placed[-1] else screening
        return rebuilt


def _with_effect(state: Diagnosis, chosen: Candidate, screening: Screening) -> Diagnosis:
    after = _gap(chosen.fit, state.heldout)
    step = Step(candidate=chosen, screening=screening, before=state.gap, after=after)
    return replace(state, model=chosen.fit, gap=after, steps=(*state.steps, step))


def _with_scatter(state: Diagnosis, stated: Diagnosis, effects: Mapping[str, ReadingEffect], others: int) -> Diagnosis:
    """Tell the scatter anew from what the present model leaves: what looked like noise may have got a name."""
    model = state.model if state.runs is stated.runs else _refitted(stated.runs, state.model)
    found = scatter_found(stated.runs, model, effects, others)
    runs, heldout = stated.runs, stated.heldout
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
