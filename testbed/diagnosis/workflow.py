"""The diagnosis: is there a gap, what explains it, add it, and again until nothing is left or the rest is unknown."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import sqrt
from types import MappingProxyType
from typing import Literal

import numpy as np
from scipy.stats import chi2

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.hypotheses import Untestable, hypotheses, without
from testbed.diagnosis.latent import LatentTorque, latent_torque
from testbed.diagnosis.model import Fit, Placed, fitted, fitted_initial_rates
from testbed.diagnosis.noise import NoiseLevel, noise_level
from testbed.diagnosis.probabilities import probabilities_of
from testbed.diagnosis.scatter import Scatter, scatter_found, widened
from testbed.diagnosis.screening import Candidate, Screening, screened
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
        remaining: the hypotheses against the final model; None until they were looked at.
        latent: torque that the final model leaves; None until it was looked at.
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
    remaining: Screening | None = None
    latent: LatentTorque | None = None
    untestable: tuple[Untestable, ...] = ()
    complete: bool = False

    @property
    def left_over(self) -> bool:
        """Whether the model leaves more than noise."""
        goodness = float(chi2.sf(self.model.chi_square, self.model.freedom))
        latent = self.latent is not None and self.latent.p_value < UNEXPLAINED
        return goodness < UNEXPLAINED or latent

    @property
    def verdict(self) -> Verdict:
        """The answer in a word."""
        if self.left_over:
            return "unexplained"
        if not self.steps:
            return "named" if self.scatter else "none"
        return "ambiguous" if self.steps[0].look_alikes else "named"

    @property
    def probabilities(self) -> Mapping[str, float]:
        """Of none, of every class that is in question, and of something unknown."""
        return probabilities_of(self.steps[0].screening if self.steps else self.remaining, self.latent)


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
    while len(state.steps) < MOST_EFFECTS:
        screening = screened(state.runs, state.model, without(testable, state.model.placed), progress)
        state = replace(state, remaining=screening)
        chosen = _chosen(state, screening)
        if chosen is None:
            break
        state = scattered(_with_effect(state, chosen, screening))
        yield state
    progress("what is left")
    yield replace(state, latent=latent_torque(state.runs, state.model), complete=True)


def _chosen(state: Diagnosis, screening: Screening) -> Candidate | None:
    """Return the best candidate that is there by more than chance and does not make held-out runs worse."""
    for candidate in screening.candidates:
        if candidate.significant and candidate.bic < 0.0:
            held_out = _gap(candidate.fit, state.heldout).heldout
            if not held_out > state.gap.heldout:  # also true where there are no held-out runs
                return candidate
    return None


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
    return Gap(
        fit=sqrt(fit.chi_square / len(fit.residual)),
        heldout=np.nan if heldout is None else _heldout_gap(heldout, fit),
    )


def _heldout_gap(heldout: Runs, fit: Fit) -> float:
    verified = fitted_initial_rates(heldout, fit)
    return sqrt(verified.chi_square / len(verified.residual))
