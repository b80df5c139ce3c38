"""Rank the hypotheses that could be added to the present model: score tests of all, refits of the promising ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from scipy.stats import chi2

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, Placed, fitted
from testbed.diagnosis.signatures import FAMILY_WISE_ERROR, Signature, signatures

MOST_REFITS = 8
CLOSE = 6.0
"""Difference of BIC within which two hypotheses are not told apart."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """A hypothesis refitted together with all else in the model.

    Attributes:
        placed: effect and component.
        fit: the model with it.
        gain: χ² of the present model less that of this one.
        bic: of this model less that of the present one; negative is better.
        p_value: of the gain, times the number of hypotheses that were tested (Bonferroni).
    """

    placed: Placed
    fit: Fit
    gain: float
    bic: float
    p_value: float

    @property
    def significant(self) -> bool:
        """Whether it is there, at the family-wise error."""
        return self.p_value < FAMILY_WISE_ERROR


@dataclass(frozen=True, kw_only=True, eq=False)
class Screening:
    """All hypotheses against the present model.

    Attributes:
        signatures: of each hypothesis at its most telling start.
        tested: number of tests by which the family-wise error is divided.
        candidates: refitted ones, best BIC first.
    """

    signatures: tuple[Signature, ...]
    tested: int
    candidates: tuple[Candidate, ...]

    @property
    def close(self) -> tuple[Candidate, ...]:
        """Candidates that are not told apart from the best one."""
        best = self.candidates[0].bic if self.candidates else 0.0
        return tuple(candidate for candidate in self.candidates if candidate.bic - best < CLOSE)


def screened(
    runs: Runs, fit: Fit, hypotheses: Sequence[Placed], progress: Callable[[str], None] = lambda _: None
) -> Screening:
    """Test every hypothesis, and refit those that explain the most.

    Args:
        runs: that the model was fitted to.
        fit: the present model.
        hypotheses: effects that are not in it.
        progress: told what is being refitted.
    """
    every = list(signatures(runs, fit, hypotheses))
    tested = max(len(every), 1)
    best = _most_telling(every)
    samples = runs.samples
    order = sorted(best, key=lambda each: each.rank * log(samples) - each.score)
    promising = [each for each in order[:MOST_REFITS] if each.rank]
    candidates = []
    for signature in promising:
        progress(signature.placed.key)
        candidates.append(_refitted(runs, fit, signature, tested))
    return Screening(
        signatures=tuple(best),
        tested=tested,
        candidates=tuple(sorted(candidates, key=lambda candidate: candidate.bic)),
    )


def _most_telling(every: Sequence[Signature]) -> list[Signature]:
    """Return each hypothesis at the start at which it explains the most."""
    best: dict[str, Signature] = {}
    for signature in every:
        key = signature.placed.key
        if key not in best or signature.score > best[key].score:
            best[key] = signature
    return list(best.values())


def _refitted(runs: Runs, fit: Fit, signature: Signature, tested: int) -> Candidate:
    placed = signature.placed
    starts = [value[0] for value in fit.values.effects]
    model = fitted(runs, [*fit.placed, placed], fit.theta, [*starts, _first_guess(signature)])
    gain = fit.chi_square - model.chi_square
    return Candidate(
        placed=placed,
        fit=model,
        gain=gain,
        bic=signature.rank * log(runs.samples) - gain,
        p_value=min(1.0, tested * float(chi2.sf(max(gain, 0.0), signature.rank))),
    )


def _first_guess(signature: Signature) -> Array:
    """Return the linearised solution, inside the bounds."""
    lower, upper = signature.placed.bounds
    return np.clip(signature.start + signature.step, lower, upper)
