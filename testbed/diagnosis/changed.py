"""Effects that healthy records show and that are another size in suspect ones: what is new is that they have changed.

Held to what the healthy records show, such an effect leaves a misfit that others are named for; so it is no part of the
nominal model any more, and is tested for like all others, its whole size.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
import scipy

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted, starts_of
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.reference import Reference
from testbed.diagnosis.run_agreement import determined_inverse
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.signatures import signatures
from testbed.diagnosis.testable import hypotheses, without
from testbed.effects.contract import Effect
from testbed.errors import InputError


def without_changed(
    reference: Reference, runs: Runs, effects: Mapping[str, Effect], theta: Theta
) -> tuple[Reference, tuple[Hypothesis, ...]]:
    """Return a reference without the effects that runs do not have as it does, and these.

    Those alone whose change explains more than any other effect would, or as much: what is new pulls at all that is
    believed, and what looks like the change competes with it once its whole size is tested. Where records show a
    controller's answer to the motion, none has: that differs from flight to flight, by more than few records show.

    Args:
        reference: of healthy records.
        runs: the suspect ones, with what is believed by the reference.
        effects: the library, by id.
        theta: nominal inertia, shape (6,), kg·m².
    """
    changed: tuple[Hypothesis, ...] = ()
    while reference.given and not reference.belief.of_loop:
        worst = _most_changed(reference, replace(runs, belief=reference.belief), effects, theta)
        if worst is None:
            break
        reference, changed = _without(reference, worst), (*changed, worst)
    return reference, changed


def _most_changed(reference: Reference, runs: Runs, effects: Mapping[str, Effect], theta: Theta) -> Hypothesis | None:
    """Return the effect of a reference that has surely changed, and whose change explains the most; None of none."""
    try:
        fit = fitted(runs, reference.given, theta, starts_of(runs, reference.given))
    except InputError:  # the motion runs away: nothing is known of a change
        return None
    gained = {each: _freed(fit, reference, each) for each in reference.given}
    worst = max(gained, key=lambda each: gained[each])
    if scipy.stats.chi2.sf(gained[worst], worst.size) > SETTINGS.changed_p_value:
        return None
    testable, _ = hypotheses(runs, effects, runs.mean_moment(theta))
    others = signatures(runs, fit, without(testable, reference.given))
    most = max((each.score for each in others), default=0.0)
    return worst if gained[worst] > most - SETTINGS.indistinguishable else None


def _freed(fit: Fit, reference: Reference, placed: Hypothesis) -> float:
    """Return by how much χ² falls if an effect is not held to what is believed of it.

    With x the estimate, μ and S what is believed, P the estimate's covariance: (x - μ)ᵀ (S - P)⁻¹ (x - μ). Of what no
    sample shows, as about the axes that a bearing holds, P is S to rounding, and nothing is said.
    """
    mean, std = reference.belief.effect(placed.key)
    own = 6 + np.arange(len(fit.effect_values))[fit.own(placed)]
    shown = fit.shown[own]
    learned = np.diag(std[shown] ** 2) - determined_inverse(fit.normal)[np.ix_(own[shown], own[shown])]
    away = (fit.effect_values[fit.own(placed)] - mean)[shown]
    return float(away @ determined_inverse(learned) @ away)


def _without(reference: Reference, placed: Hypothesis) -> Reference:
    belief = reference.belief
    kept = [key != placed.key for key, mean, _ in belief.effects for _ in mean]
    rows = np.concatenate([np.full(6, True), np.array(kept, dtype=bool)])
    belief = replace(
        belief,
        effects=tuple(each for each in belief.effects if each[0] != placed.key),
        common=None if belief.common is None else belief.common[np.ix_(rows, rows)],
    )
    return replace(reference, belief=belief, given=tuple(each for each in reference.given if each.key != placed.key))


def changed_notices(reference: Reference, changed: Collection[Hypothesis]) -> list[str]:
    """Return what to say of effects that are not as healthy records show them.

    Args:
        reference: as the healthy records show it.
        changed: its effects that the suspect ones have otherwise.
    """
    notices = []
    for placed in changed:
        mean, std = reference.belief.effect(placed.key)
        sizes = ", ".join(
            f"{each.name} = {each.value:.3g} ± {each.std:.2g}" for each in placed.effect.quantities(mean, std)
        )
        notices.append(
            f"{placed.effect.id} ({placed.component}) is not as the reference has it ({sizes}): it is tested for anew, "
            "and its size below is the whole one"
        )
    return notices
