"""Rank the hypotheses that could be added to the present model: score tests of all, refits of the promising ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import exp, inf, log

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.candidates import MOST_REFITS, Candidate, Screening
from testbed.diagnosis.chance import log_chance, mean_over_places, scale_evidence
from testbed.diagnosis.data import Runs
from testbed.diagnosis.evidence import log_evidence
from testbed.diagnosis.fitting import fitted, refit
from testbed.diagnosis.gyro_errors import all_corrected
from testbed.diagnosis.model import Fit, Placed
from testbed.diagnosis.signatures import FAMILY_WISE_ERROR, Signature, signatures
from testbed.errors import InputError

_SHOWN = 0.2
"""Chance of the fitted runs' gain alone, without any correction, from which on they do not show an effect."""
_SHARES = (1.0, 0.1, 0.0)
"""Of the linearised solution, from which a refit starts one after the other until one comes near what it promised."""
_LOST = 30.0
"""By which a refit may fall short of the gain that the linearised effect promises, and is not started from less."""


def odds_together(
    without: tuple[Runs | None, Fit], within: tuple[Runs | None, Fit], tested: int, effects: Sequence[Candidate]
) -> float:
    """Return twice the logarithm of how much likelier several effects together are than nothing.

    What each took off when it was added does not add up to that: it was compared with what was in the model then.

    Args:
        without: the model without them, and the held-out runs as it knows them; None where there are none.
        within: the model with them, fitted to the same runs, and likewise.
        tested: number of hypotheses.
        effects: as they were added.
    """
    (before_heldout, before), (after_heldout, after) = without, within
    gain, rank = before.chi_square - after.chi_square, sum(each.rank for each in effects)
    carried = _held_out_evidence(after_heldout, after) - log_evidence(before_heldout, before)
    return scale_evidence(gain, rank) + carried - 2.0 * sum(log(tested) + each.looks for each in effects)


def screened(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    hypotheses: Sequence[Placed],
    progress: Callable[[str], None] = lambda _: None,
) -> Screening:
    """Test every hypothesis, and refit those that explain the most.

    Args:
        runs: that the model was fitted to.
        heldout: to verify on; None where there are none.
        fit: the present model.
        hypotheses: effects that are not in it.
        progress: told what is being refitted.
    """
    every = list(signatures(runs, fit, hypotheses))
    best = most_telling(every)
    tested = max(len(best), 1)
    order = sorted(best, key=lambda each: -_anywhere(runs, each, scale_evidence(each.score, each.rank)))
    promising = [each for each in order[:MOST_REFITS] if each.rank]
    candidates, without = [], log_evidence(heldout, fit)
    for signature in promising:
        progress(signature.placed.key)
        candidates.append(_candidate(runs, heldout, fit, signature, tested, without))
    return Screening(
        signatures=tuple(best),
        tested=tested,
        candidates=tuple(sorted(candidates, key=lambda candidate: -candidate.evidence)),
    )


def most_telling(every: Sequence[Signature]) -> list[Signature]:
    """Return each hypothesis at the start at which it explains the most, with its scores at the others.

    Args:
        every: hypotheses at all their starts.
    """
    by_key: dict[str, list[Signature]] = {}
    for signature in every:
        by_key.setdefault(signature.placed.key, []).append(signature)
    return [_best_of(starts) for starts in by_key.values()]


def _best_of(starts: Sequence[Signature]) -> Signature:
    best = max(starts, key=lambda each: each.score)
    return replace(best, elsewhere=tuple(each.score for each in starts if each is not best))


def refitted(runs: Runs, heldout: Runs | None, fit: Fit, screening: Screening, placed: Placed) -> Candidate:
    """Return one hypothesis of a screening, refitted whether it was promising or not; arguments as in `screened`."""
    for candidate in screening.candidates:
        if candidate.placed.key == placed.key:
            return candidate
    signature = next(each for each in screening.signatures if each.placed.key == placed.key)
    return _candidate(runs, heldout, fit, signature, screening.tested, log_evidence(heldout, fit))


def with_candidate(runs: Runs, heldout: Runs | None, fit: Fit, screening: Screening, placed: Placed) -> Screening:
    """Return a screening with one hypothesis among those that were refitted; arguments as in `refitted`.

    The same where it was not asked of, beside what masks it.
    """
    if all(each.placed.key != placed.key for each in screening.signatures):
        return screening
    candidate = refitted(runs, heldout, fit, screening, placed)
    if candidate in screening.candidates:
        return screening
    candidates = sorted((*screening.candidates, candidate), key=lambda each: -each.evidence)
    return replace(screening, candidates=tuple(candidates))


def _candidate(
    runs: Runs, heldout: Runs | None, fit: Fit, signature: Signature, tested: int, without: float
) -> Candidate:
    placed, model = signature.placed, _refitted(runs, fit, signature)
    told, heldout = all_corrected(runs, heldout, model)
    if told is not runs:  # what the gyro is off by, it is off in the gimbals' channels as well
        model = refit(told, model)
    gain = max(fit.chi_square - model.chi_square, 0.0)
    carried = _held_out_evidence(heldout, model) - without if placed.effect.recurs else 0.0
    here = scale_evidence(gain, signature.rank) + carried
    evidence = _anywhere(runs, signature, here)
    alone = log_chance(gain, max(signature.rank, 1), runs.noise_freedom)
    corrected = alone + log(tested * _places(runs, placed)) - 0.5 * carried
    together = max(corrected, alone + log(FAMILY_WISE_ERROR / _SHOWN))
    return Candidate(
        placed=placed,
        fit=model,
        gain=gain,
        rank=signature.rank,
        looks=0.5 * (here - evidence),
        carried=carried,
        evidence=evidence,
        by_run=np.array([float((part**2).sum()) for part in runs.by_run(model.residual)]),
        p_value=exp(min(together, 0.0)),
    )


def _places(runs: Runs, placed: Placed) -> int:
    return placed.effect.places(placed.component, runs.grid)


def _anywhere(runs: Runs, signature: Signature, here: float) -> float:
    """Return the evidence of a hypothesis wherever it was sought.

    Args:
        runs: that are fitted.
        signature: of the hypothesis.
        here: its evidence at the start that it is best at.
    """
    elsewhere = [scale_evidence(score, signature.rank) for score in signature.elsewhere]
    return mean_over_places(here, elsewhere, _places(runs, signature.placed))


def _held_out_evidence(heldout: Runs | None, fit: Fit) -> float:
    try:
        return log_evidence(heldout, fit)
    except InputError:  # what fits some runs and lets others run away is no platform
        return -inf


def _refitted(runs: Runs, fit: Fit, signature: Signature) -> Fit:
    """Search from the linearised solution, and from less of it where that leads nowhere: it may be of no body."""
    placed, starts = [*fit.placed, signature.placed], [value[0] for value in fit.values.effects]
    found: list[Fit] = []
    for share in _SHARES:
        try:
            found.append(fitted(runs, placed, fit.theta, [*starts, _guess(signature, share)]))
        except InputError:  # the motion runs away
            continue
        if fit.chi_square - found[-1].chi_square > signature.score - _LOST:
            break
    return min(found, key=lambda each: each.chi_square)


def _guess(signature: Signature, share: float) -> Array:
    """Return a share of the linearised solution, inside the bounds."""
    lower, upper = signature.placed.bounds
    return np.clip(signature.start + share * signature.step, lower, upper)
