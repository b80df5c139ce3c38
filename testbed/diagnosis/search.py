"""Forward and backward steps: which effects are in the model, and what is known with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from testbed.arrays import Vectors3
from testbed.diagnosis.candidates import Candidate, Screening
from testbed.diagnosis.data import Runs
from testbed.diagnosis.evidence import Prior
from testbed.diagnosis.fitting import fitted, fitted_initial_rates, refit
from testbed.diagnosis.gyro_errors import all_corrected
from testbed.diagnosis.hypotheses import without
from testbed.diagnosis.misfit import heldout_misfit_of, misfit_of
from testbed.diagnosis.model import Fit, Placed
from testbed.diagnosis.screening import refitted, screened, with_candidate
from testbed.diagnosis.state import Diagnosis, Gap, Step

MOST_EFFECTS = 3
_UNSEEN = 0.01
"""Of the gyro's noise: by less do its errors differ between two fits of one model."""


@dataclass(frozen=True, kw_only=True)
class Search:
    """Forward and backward steps among the hypotheses.

    Attributes:
        testable: all of them.
        progress: told what is being done.
        known: screenings so far, by the effects in the model; steps back come to the same model again.
    """

    testable: tuple[Placed, ...]
    progress: Callable[[str], None]
    known: dict[tuple[str, ...], tuple[Runs, Screening]] = field(default_factory=dict)

    def screened(self, state: Diagnosis) -> Screening:
        """Compare all hypotheses with the present model."""
        key = tuple(placed.key for placed in state.model.placed)
        runs, screening = self.known.get(key, (None, None))
        if runs is None or screening is None or not _is_told_alike(runs, state.runs):
            others = without(self.testable, state.model.placed)
            screening = screened(state.runs, state.heldout, state.model, others, self.progress)
            self.known[key] = (state.runs, screening)
        return screening

    def reconsidered(self, state: Diagnosis) -> Diagnosis:
        """Ask of the earlier effects, with the newest in the model, whether they still stand, until nothing changes."""
        for _ in range(MOST_EFFECTS):
            changed = self._once_reconsidered(state)
            if changed is state:
                break
            state = changed
        return state

    def _once_reconsidered(self, state: Diagnosis) -> Diagnosis:
        """Return the diagnosis without the first effect that does not stand, or with what does better in its place."""
        for index, step in enumerate(state.steps[:-1]):
            kept = [other.placed for other in (*state.steps[:index], *state.steps[index + 1 :])]
            less = with_model(state, _less(state, kept))
            screening = with_candidate(less.runs, less.heldout, less.model, self.screened(less), step.placed)
            chosen = screening.chosen
            if chosen is None:
                return self._rebuilt(state, kept)
            if chosen.placed.key != step.placed.key:
                return with_effect(self._rebuilt(state, kept), chosen, screening)
        return state

    def _rebuilt(self, state: Diagnosis, placed: Sequence[Placed]) -> Diagnosis:
        """Return a diagnosis with just these effects, added to the baseline one after the other."""
        model = fitted(state.runs, [], state.baseline.theta, [])
        rebuilt = with_model(replace(state, steps=()), model)
        screening = state.steps[0].screening
        for each in placed:
            candidate = refitted(rebuilt.runs, rebuilt.heldout, rebuilt.model, screening, each)
            rebuilt = with_effect(rebuilt, candidate, screening)
            screening = self.screened(rebuilt) if each is not placed[-1] else screening
        return rebuilt


def _less(state: Diagnosis, kept: Sequence[Placed]) -> Fit:
    """Return a model with but some of its effects, fitted from where it stands."""
    values = dict(zip([each.key for each in state.model.placed], state.model.values.effects, strict=True))
    return fitted(state.runs, kept, state.model.theta, [values[each.key][0] for each in kept])


def _is_told_alike(one: Runs, other: Runs) -> bool:
    """Return whether two sets of the same runs are told the same noise and, but for rounding, the same gyro errors."""
    if not np.array_equal(one.sigma, other.sigma) or len(one.told) != len(other.told):
        return False
    both = list(zip(one.grid.runs, other.grid.runs, strict=True))
    errors = all(_is_nearly(run.gyro_error, twin.gyro_error, run.gyro_noise) for run, twin in both)
    told = zip(one.told, other.told, one.grid.runs, strict=False)  # of every run, or of none
    return errors and all(_is_nearly(mine, theirs, run.gyro_noise) for mine, theirs, run in told)


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
    step = Step(candidate=chosen, screening=screening, before=state.gap, after=after.gap)
    return replace(after, steps=(*state.steps, step))


def with_model(state: Diagnosis, model: Fit) -> Diagnosis:
    """Take over a model, and what it knows of the gyro's errors; the gimbals' channels are then predicted anew."""
    runs, heldout = all_corrected(state.runs, state.heldout, model)
    model = refit(runs, model)
    return replace(state, runs=runs, heldout=heldout, model=model, gap=gap_of(runs, model, heldout))


def gap_of(runs: Runs, fit: Fit, heldout: Runs | None) -> Gap:
    """Return what a model leaves.

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
