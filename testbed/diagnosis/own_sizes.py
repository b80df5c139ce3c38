"""Whether what a model lacks is that one of its effects has another size in each run, as friction in cold and warm.

A drag that differs by a fifth from flight to flight leaves a residual that a contact or an inertial torque explains in
part; a run in which something hangs on the platform leaves what a noisier gyro explains. So no effect is named where
sizes, or an inertia, of every run's own explain more than that effect does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from testbed.arrays import Array, Indices
from testbed.diagnosis.candidates import Candidate, Screening, accepted
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.latent import goodness
from testbed.diagnosis.model import Hypothesis, independent
from testbed.diagnosis.run_agreement import Seen, determined_inverse, seen_by_record
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis, OwnSizes


def with_own_sizes(state: Diagnosis, screening: Screening) -> tuple[Diagnosis, Candidate | None]:
    """Return the effect to add; none where an effect in the model, or the inertia, differs between runs more probably.

    Not where the effect leaves nothing, nor where own sizes leave as much as they explain.

    Args:
        state: the model, which then says so.
        screening: of the hypotheses against it.
    """
    chosen = accepted(screening)
    if chosen is None or goodness(chosen.fit, state.runs.noise_freedom) > SETTINGS.unexplained_p_value:
        return state, chosen  # with it nothing is left that could differ
    differing = _most_probable(state)
    if differing is None or differing.odds <= screening.odds(chosen):
        return state, chosen
    return replace(state, differing=differing), None


def _most_probable(state: Diagnosis) -> OwnSizes | None:
    model, runs = state.model, state.runs
    # Columns of one run are no other's; over windows the inertia is as stated, and each is a part of a record.
    if runs.known_in_part or not all(each.effect.recurs for each in model.placed):
        return None
    seen, left = seen_by_record(runs, model), model.chi_square - model.freedom
    if state.heldout is not None:
        others = fitted_initial_rates(state.heldout, model)
        seen |= seen_by_record(state.heldout, others)
        left += others.chi_square - others.freedom
    if len(seen) < 2:
        return None
    inertia = np.full(6, SETTINGS.inertia_scatter * runs.mean_moment(model.theta))
    found = [_own_sizes(None, seen, np.arange(6), inertia)]
    for step in state.steps:
        own, parameters = model.own(step.placed), step.placed.effect.parameters
        sized = np.array([not each.scanned for each in parameters])
        away = model.effect_values[own] - np.array([each.absent for each in parameters])
        columns = 6 + np.arange(len(model.effect_values))[own][sized]
        found.append(_own_sizes(step.placed, seen, columns, SETTINGS.size_scatter * np.abs(away[sized])))
    most = max(found, key=lambda each: each.odds)
    return most if most.odds > SETTINGS.explained_by_own_sizes * left else None


def _own_sizes(placed: Hypothesis | None, seen: Mapping[str, Seen], own: Indices, scatter: Array) -> OwnSizes:
    """Return the posterior odds of own sizes in every run against one of all, even a priori; and where most is.

    Sizes in runs scatter normally about one that is free. Of deviations with the information I and the slope s,
    2 ln B = sᵀ (I + T⁻²)⁻¹ s - ln det(1 + T² I) (Savage-Dickey, as `trims.log_odds_of_own_trims`).

    Args:
        placed: the effect; None of the inertia.
        seen: what every record says, by name.
        own: which of the model's parameters deviate.
        scatter: their standard deviations T.
    """
    own, scatter = own[scatter > 0.0], scatter[scatter > 0.0]
    information, slope = _of_deviations(list(seen.values()), own)
    loose = np.tile(scatter, len(seen))
    information, slope = independent(loose[:, None] * information * loose, loose * slope)
    inner = np.eye(len(slope)) + information
    away = np.linalg.solve(inner, slope)
    most = np.square(away).reshape(len(seen), -1).sum(axis=1).argmax()
    return OwnSizes(
        placed=placed, odds=float(slope @ away) - float(np.linalg.slogdet(inner)[1]), record=list(seen)[most]
    )


def _of_deviations(seen: Sequence[Seen], own: Indices) -> tuple[Array, Array]:
    """Return the information and the slope of parameters' deviations in every run, all that runs share projected out.

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
    return information, np.concatenate([each.slope[own] for each in seen]) - across @ inverse @ slope
