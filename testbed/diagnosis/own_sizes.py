"""Whether what a model lacks is that one of its effects has another size in each run, as friction in cold and warm.

A drag that differs by a fifth from flight to flight leaves a residual that a contact or an inertial torque explains in
part; a run in which something hangs on the platform leaves what a noisier gyro explains. So no effect is named where
sizes, or an inertia, of every run's own explain more than that effect does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from testbed.arrays import Array, Indices
from testbed.diagnosis.candidates import Candidate, Screening, accepted
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.model import Fit, Hypothesis, independent
from testbed.diagnosis.p_values import p_value
from testbed.diagnosis.run_agreement import Seen, determined_inverse, seen_by_record
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis, OwnSizes


def with_own_sizes(state: Diagnosis, screening: Screening) -> tuple[Diagnosis, Candidate | None]:
    """Return the effect to add; none where an effect in the model, or the inertia, differs between runs more probably.

    Not where the effect leaves nothing that could differ, nor where own sizes leave as much as they explain.

    Args:
        state: the model, which then says so.
        screening: of the hypotheses against it.
    """
    chosen = accepted(screening)
    if chosen is None:
        return state, chosen
    explains_all = _explains_all(state, chosen)
    if explains_all and not any(_is_healthy(state, each) for each in state.model.placed):
        return state, chosen
    found = _every(state)
    healthy = [each for each in found if each.as_healthy]
    # What healthy records differ by is known to be there, however little of a residual it is.
    likely = healthy if healthy or explains_all else [each for each in found if each.explains_most]
    differing = max(likely, key=lambda each: each.odds, default=None)
    if differing is None or differing.odds <= screening.odds(chosen):
        return state, chosen
    return replace(state, differing=differing), None


def as_healthy_records_differ(state: Diagnosis) -> Diagnosis:
    """Return a diagnosis whose residual is what healthy records differ by as well, if it is; else the same.

    Args:
        state: with its residual tested.
    """
    return _differing_by(state, lambda each: each.as_healthy and each.odds > 0.0)


def saying_what_differs(state: Diagnosis) -> Diagnosis:
    """Return a complete diagnosis that says what differs from run to run, if that explains most of its residual.

    More, that is, than a torque of any shape; the verdict stays.

    Args:
        state: with its residual tested.
    """
    least = max((0.0, *(shape.evidence for shape in state.shapes)))
    return _differing_by(state, lambda each: each.explains_most and each.odds > least)


def _differing_by(state: Diagnosis, stands: Callable[[OwnSizes], bool]) -> Diagnosis:
    """Return a diagnosis that says what differs from run to run, if it left anything and something stands for it."""
    if state.differing is not None or not state.left_over:
        return state
    found = [each for each in _every(state) if stands(each)]
    return replace(state, differing=max(found, key=lambda each: each.odds)) if found else state


@dataclass(frozen=True, kw_only=True, eq=False)
class _Records:
    """What all records say of a model.

    Attributes:
        both: the fitted ones and those held out, with the model fitted to them.
    """

    both: Sequence[tuple[Runs, Fit]]

    @cached_property
    def seen(self) -> Mapping[str, Seen]:
        """By the name of each record."""
        return {name: each for runs, fit in self.both for name, each in seen_by_record(runs, fit).items()}

    @property
    def chi_square(self) -> float:
        """Of their residuals."""
        return sum(fit.chi_square for _, fit in self.both)

    @property
    def freedom(self) -> int:
        """Samples less parameters."""
        return sum(fit.freedom for _, fit in self.both)

    @staticmethod
    def of(state: Diagnosis, model: Fit) -> _Records:
        """Return it of the fitted records, and of those held out where all of a model's effects act in these."""
        both = [(state.runs, model)]
        if state.heldout is not None and all(each.effect.recurs for each in model.placed):
            both.append((state.heldout, fitted_initial_rates(state.heldout, model)))
        return _Records(both=both)


def _explains_all(state: Diagnosis, chosen: Candidate) -> bool:
    records = _Records.of(state, chosen.fit)
    chance = p_value(records.chi_square, records.freedom, state.runs.noise_freedom)
    return chance > SETTINGS.unexplained_p_value


def _every(state: Diagnosis) -> list[OwnSizes]:
    """Return what may differ from run to run: the inertia, and each effect in the model."""
    model, runs = state.model, state.runs
    # Columns of one run are no other's; over windows the inertia is as stated, and each is a part of a record.
    if runs.known_in_part or not all(each.effect.recurs for each in model.placed):
        return []
    records = _Records.of(state, model)
    if len(records.seen) < 2:
        return []
    inertia = np.full(6, SETTINGS.inertia_scatter * runs.mean_moment(model.theta))
    found = [_own_sizes(state, None, records, np.arange(6), inertia)]
    for placed in model.placed:
        own, sized = model.own(placed), np.array([not each.scanned for each in placed.effect.parameters])
        columns = 6 + np.arange(len(model.effect_values))[own][sized]
        found.append(_own_sizes(state, placed, records, columns, _scatter_of(state, placed)[sized]))
    return found


def _scatter_of(state: Diagnosis, placed: Hypothesis) -> Array:
    """Return the standard deviations by which an effect's parameters differ from run to run, where they do."""
    if _is_healthy(state, placed) and state.runs.belief is not None:
        return state.runs.belief.effect(placed.key)[1]
    absent = np.array([each.absent for each in placed.effect.parameters])
    return np.asarray(SETTINGS.size_scatter * np.abs(state.model.effect_values[state.model.own(placed)] - absent))


def _is_healthy(state: Diagnosis, placed: Hypothesis) -> bool:
    """Return whether healthy records have an effect, and show by how much it differs from one to the next."""
    belief = state.runs.belief
    return placed.given and belief is not None and belief.records > 0


def _own_sizes(
    state: Diagnosis, placed: Hypothesis | None, records: _Records, own: Indices, scatter: Array
) -> OwnSizes:
    """Return the posterior odds of own sizes in every run against one of all, even a priori; and where most is.

    Sizes in runs scatter normally about one that is free. Of deviations with the information I and the slope s,
    2 ln B = sᵀ (I + T⁻²)⁻¹ s - ln det(1 + T² I) (Savage-Dickey, as `trims.log_odds_of_own_trims`).

    Args:
        state: the model.
        placed: the effect; None of the inertia.
        records: what these say.
        own: which of the model's parameters deviate.
        scatter: their standard deviations T.
    """
    own, scatter = own[scatter > 0.0], scatter[scatter > 0.0]
    information, slope, shared = _of_deviations(list(records.seen.values()), own)
    loose = np.tile(scatter, len(records.seen))
    information, slope = independent(loose[:, None] * information * loose, loose * slope)
    inner = np.eye(len(slope)) + information
    away = np.linalg.solve(inner, slope)
    gain, most = float(slope @ away), np.square(away).reshape(len(records.seen), -1).sum(axis=1).argmax()
    chance = p_value(records.chi_square - gain - shared, records.freedom, state.runs.noise_freedom)
    healthy, odds = placed is not None and _is_healthy(state, placed), gain - float(np.linalg.slogdet(inner)[1])
    return OwnSizes(
        placed=placed,
        odds=odds,
        record=list(records.seen)[most],
        explains_most=odds > SETTINGS.explained_by_own_sizes * (records.chi_square - records.freedom),
        as_healthy=healthy and chance > SETTINGS.unexplained_p_value,
    )


def _of_deviations(seen: Sequence[Seen], own: Indices) -> tuple[Array, Array, float]:
    """Return the information and the slope of parameters' deviations in every run, all that runs share projected out.

    And by how much χ² falls by what they share, as the model was fitted to some of them alone.

    Args:
        seen: what every record says of C parameters.
        own: which K of them deviate.
    """
    shared = sum((each.normal for each in seen), np.zeros_like(seen[0].normal))
    slope = sum((each.slope for each in seen), np.zeros_like(seen[0].slope))
    inverse = determined_inverse(shared)
    across = np.concatenate([each.normal[own] for each in seen])
    information = -across @ inverse @ across.T
    for run, each in enumerate(seen):
        rows = slice(run * len(own), (run + 1) * len(own))
        information[rows, rows] += each.normal[np.ix_(own, own)]
    own_slope = np.concatenate([each.slope[own] for each in seen]) - across @ inverse @ slope
    return information, own_slope, float(slope @ inverse @ slope)
