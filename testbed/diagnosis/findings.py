"""What follows from a diagnosis: sizes that would have been seen, look-alikes, parameters, inertia, residuals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.stats import chi2

from testbed.arrays import Array, Theta
from testbed.diagnosis.candidates import Screening
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import nominal_fit
from testbed.diagnosis.hypotheses import masking
from testbed.diagnosis.misfit import Misfit, misfit_of
from testbed.diagnosis.model import Fit, Placed
from testbed.diagnosis.probabilities import probabilities_of
from testbed.diagnosis.scatter import Scatter
from testbed.diagnosis.signatures import Signature, distinguishability, smallest_detectable
from testbed.diagnosis.state import Diagnosis, Gap, Step
from testbed.effects.contract import NamedEffect, Quantity
from testbed.errors import InputError

INERTIA = "inertia"
"""The effect that is always in the model."""
SIGNIFICANT = 0.01
"""Chance at which the inertia is said to differ from the nominal one."""
ALIKE = 0.2
"""Sine of the angle between two effects below which they are called look-alikes: 2 % of one's power is its own."""


@dataclass(frozen=True, kw_only=True)
class Detectable:
    """The smallest size of an effect that these data would have shown.

    Attributes:
        placed: effect and component.
        multiple: of the typical size; infinite where this motion does not show the effect at all.
        smallest: the effect's parameters at that size, as they are reported; empty where infinite.
        typical: at their typical size.
    """

    placed: Placed
    multiple: float
    smallest: tuple[Quantity, ...]
    typical: tuple[Quantity, ...]

    @property
    def seen_when_typical(self) -> bool:
        """Whether the effect would have been found at its typical size."""
        return self.multiple <= 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Addition:
    """An effect that was added to the model, of whichever kind.

    Attributes:
        effect: which.
        component: where.
        quantities: its parameters, as the final model has them.
        probability: that it, or what is not told from it, is there, among all that it was compared with.
        look_alikes: what the data do not tell from it.
        before: gap without it.
        after: gap with it; those on the gyro's noise close what the others leave together.
        fit: the model that it was added to; the final one for effects on the gyro's noise.
    """

    effect: NamedEffect
    component: str
    quantities: tuple[Quantity, ...]
    probability: float
    look_alikes: tuple[Placed | Scatter, ...]
    before: Gap
    after: Gap
    fit: Fit


@dataclass(frozen=True, kw_only=True, eq=False)
class InertiaChange:
    """How the estimated inertia differs from the nominal one.

    Attributes:
        difference: θ̂ - θ, kg·m².
        std: of it, kg·m².
        p_value: of a difference as large if there were none (Wald test of all six parameters).
    """

    difference: Theta
    std: Theta
    p_value: float

    @property
    def significant(self) -> bool:
        """Whether it differs by more than chance."""
        return self.p_value < SIGNIFICANT


def first_screening(diagnosis: Diagnosis) -> Screening | None:
    """Return the hypotheses against the baseline; None where they were not looked at yet."""
    return diagnosis.steps[0].screening if diagnosis.steps else diagnosis.remaining


def shown_signatures(screening: Screening | None) -> tuple[Signature, ...]:
    """Return the signatures that a reader is shown: the inertia is in every model already."""
    if screening is None:
        return ()
    return tuple(each for each in screening.signatures if each.placed.effect.id != INERTIA)


def detectable_sizes(diagnosis: Diagnosis) -> tuple[Detectable, ...]:
    """Return the smallest detectable size of every effect, in the order in which effects are listed."""
    screening = first_screening(diagnosis)
    if screening is None:
        return ()
    return tuple(_detectable(each, screening.tested) for each in shown_signatures(screening))


def _detectable(signature: Signature, tested: int) -> Detectable:
    effect = signature.placed.effect
    absent = np.array([parameter.absent for parameter in effect.parameters])
    typical = np.array([parameter.typical for parameter in effect.parameters])
    multiple = smallest_detectable(signature, tested)
    none = np.zeros(len(absent))
    smallest = effect.quantities(absent + multiple * (typical - absent), none) if np.isfinite(multiple) else ()
    return Detectable(
        placed=signature.placed, multiple=multiple, smallest=smallest, typical=effect.quantities(typical, none)
    )


def masked(diagnosis: Diagnosis) -> tuple[tuple[Placed, Placed], ...]:
    """Return the hypotheses that were not asked of beside an effect in the final model, each with that effect."""
    screening, present = first_screening(diagnosis), diagnosis.model.placed
    candidates = [] if screening is None else [each.placed for each in screening.signatures]
    pairs = [(each, masking(each, present)) for each in candidates]
    return tuple((candidate, by) for candidate, by in pairs if by is not None)


def distances(signatures: tuple[Signature, ...]) -> Array:
    """Return how well every two effects can be told apart, shape (E, E): 0 for aliases, 1 for strangers."""
    apart = np.zeros((len(signatures), len(signatures)))
    for one, other in combinations(range(len(signatures)), 2):
        apart[one, other] = apart[other, one] = distinguishability(signatures[one], signatures[other])
    return apart


def pairs_alike(diagnosis: Diagnosis) -> tuple[tuple[Placed, Placed, float], ...]:
    """Return the effects that these data hardly tell apart, the closest first, with their distance."""
    shown = tuple(each for each in shown_signatures(first_screening(diagnosis)) if each.rank)
    apart = distances(shown)
    pairs = [
        (shown[one].placed, shown[other].placed, float(apart[one, other]))
        for one, other in combinations(range(len(shown)), 2)
        if apart[one, other] < ALIKE
    ]
    return tuple(sorted(pairs, key=lambda pair: pair[2]))


def quantities_of(fit: Fit, placed: Placed) -> tuple[Quantity, ...]:
    """Return an effect's parameters with their standard errors, as a model has them."""
    own = fit.own(placed)
    return placed.effect.quantities(fit.effect_values[own], stds_of(fit)[6:][own])


def stds_of(fit: Fit) -> Array:
    """Return the standard errors of (θ, effects), shape (C,); infinite where the data say nothing."""
    try:
        variance = np.diag(fit.covariance)
    except np.linalg.LinAlgError:
        return np.full(6 + len(fit.effect_values), np.inf)
    return np.sqrt(np.where(variance > 0.0, variance, np.inf))


def additions(diagnosis: Diagnosis) -> tuple[Addition, ...]:
    """Return all effects that were added, in the order of `Diagnosis.added`."""
    return tuple(addition_of(diagnosis, each) for each in diagnosis.added)


def addition_of(diagnosis: Diagnosis, added: Step | Scatter) -> Addition:
    """Return one of the effects that were added."""
    if isinstance(added, Scatter):
        before = diagnosis.steps[-1].after if diagnosis.steps else diagnosis.gap_before
        after = diagnosis.gap
        quantities = added.effect.quantities(added.finding.values, added.finding.std)
        probability, fit = added.probability, diagnosis.model
    else:
        before, after = added.before, added.after
        quantities = quantities_of(diagnosis.model, added.placed)
        probability, fit = _step_probability(diagnosis, added), added.candidate.fit
    return Addition(
        effect=added.effect,
        component=added.component,
        quantities=quantities,
        probability=probability,
        look_alikes=added.look_alikes,
        before=before,
        after=after,
        fit=fit,
    )


def _step_probability(diagnosis: Diagnosis, step: Step) -> float:
    unlisted = diagnosis.unlisted_beside_steps if step is diagnosis.steps[0] else -np.inf
    probabilities = probabilities_of(step.screening, unlisted)
    members = (step.placed, *step.look_alikes)
    return sum(probabilities.get(each.key, 0.0) for each in members)


def noise_notices(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return what there is to say of a noise that is stated larger than it is; a smaller one is an effect."""
    if not diagnosis.noise.overstated:
        return ()
    ratio = float(np.sqrt(np.mean(diagnosis.noise.ratio**2)))
    return (
        f"the gyro's noise is stated too large: the samples show {ratio:.2f} times as much; effects have to be larger "
        "than they need to be to be found: state gyro_noise_rad_s as it is",
    )


def inertia_change(diagnosis: Diagnosis) -> InertiaChange:
    """Return how the inertia of the final model differs from the nominal one."""
    difference = diagnosis.model.theta - diagnosis.nominal_theta
    std = stds_of(diagnosis.model)[:6]
    statistic = 0.0
    if np.isfinite(std).all():
        statistic = float(difference @ np.linalg.solve(diagnosis.model.covariance[:6, :6], difference))
    return InertiaChange(difference=difference, std=std, p_value=float(chi2.sf(statistic, 6)))


def nominal_gap(diagnosis: Diagnosis) -> Gap:
    """Return the gap of the nominal inertia, only initial rates fitted; infinite where its motion runs away."""
    fit, misfit = _nominal_gap(diagnosis.runs, diagnosis.nominal_theta)
    heldout, heldout_misfit = np.nan, None
    if diagnosis.heldout is not None:
        heldout, heldout_misfit = _nominal_gap(diagnosis.heldout, diagnosis.nominal_theta)
    return Gap(fit=fit, heldout=heldout, misfit=misfit, heldout_misfit=heldout_misfit)


def _nominal_gap(runs: Runs, theta: Theta) -> tuple[float, Misfit | None]:
    try:
        fit = nominal_fit(runs, theta)
    except InputError:
        return np.inf, None
    only_initial = replace(fit, jacobian=fit.jacobian[:, 6:])  # the inertia is not fitted here
    return fit.root_mean_square, misfit_of(runs, only_initial)
