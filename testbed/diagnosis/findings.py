"""What a diagnosis found, as reports and files need it: what was added, what is in doubt, how the inertia differs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy

from testbed.arrays import Array, Covariance, Theta
from testbed.diagnosis.candidates import probabilities_of
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import nominal_fit
from testbed.diagnosis.misfit import Misfit, misfit_of
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis, Gap, Step
from testbed.effects.contract import PLAUSIBLE_PER_INERTIA, NamedEffect, Parameter, Quantity
from testbed.errors import InputError


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Addition:
    """An effect that was added to the model, of whichever kind.

    Attributes:
        effect: which.
        component: where.
        quantities: its parameters, as the final model has them.
        probability: posterior, of its equivalence class among all hypotheses that it was compared with.
        look_alikes: effects that the data cannot distinguish from it.
        before: gap without it.
        after: gap with it; those on the gyro's noise share one gap after the others.
        fit: the model that it was added to; the final one for effects on the gyro's noise.
        doubts: why the name is to be doubted in spite of its probability, a sentence each.
    """

    effect: NamedEffect
    component: str
    quantities: tuple[Quantity, ...]
    probability: float
    look_alikes: tuple[Hypothesis | NoiseHypothesis, ...]
    before: Gap
    after: Gap
    fit: Fit
    doubts: tuple[str, ...] = ()

    def __repr__(self) -> str:
        sizes = (f"{each.name} = {each.value:.4g} ± {each.std:.2g}" for each in self.quantities)
        return f"{self.effect.id}:{self.component} ({', '.join(sizes)}; probability {self.probability:.2f})"


@dataclass(frozen=True, kw_only=True, eq=False)
class InertiaChange:
    """How the estimated inertia differs from another one.

    Attributes:
        theta: the other one, θ, kg·m².
        difference: θ̂ - θ, kg·m²; NaN where the motion cannot show a parameter.
        std: of it, kg·m².
        p_value: of a difference as large if there were none (Wald test of all that are shown).
    """

    theta: Theta
    difference: Theta
    std: Theta
    p_value: float

    @property
    def significant(self) -> bool:
        """Whether it differs by more than chance."""
        return self.p_value < SETTINGS.inertia_p_value

    @property
    def sure(self) -> bool:
        """Whether it differs so much that something has changed."""
        return self.p_value < SETTINGS.changed_p_value


def quantities_of(runs: Runs, fit: Fit, placed: Hypothesis) -> tuple[Quantity, ...]:
    """Return an effect's parameters with their standard errors, as a model of runs has them."""
    own = fit.own(placed)
    hidden = hidden_parameters(fit, placed)
    errors = np.hypot(stds_of(fit)[6:][own], placed.effect.unresolved(runs.grid))
    every = placed.effect.quantities(fit.effect_values[own], errors)
    return tuple(quantity for quantity in every if quantity.name not in hidden)


def hidden_parameters(fit: Fit, placed: Hypothesis) -> frozenset[str]:
    """Return the names of an effect's parameters that no sample shows, such as those of axes that a bearing holds."""
    shown = fit.shown[6:][fit.own(placed)]
    names = (parameter.name for parameter in placed.effect.parameters)
    return frozenset(name for name, yes in zip(names, shown, strict=True) if not yes)


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


def addition_of(diagnosis: Diagnosis, added: Step | NoiseHypothesis) -> Addition:
    """Return one of the effects that were added."""
    if isinstance(added, NoiseHypothesis):
        before = diagnosis.steps[-1].after if diagnosis.steps else diagnosis.gap_before
        after = diagnosis.gap
        quantities = added.effect.quantities(added.finding.values, added.finding.std)
        doubts: tuple[str, ...] = ()
        probability, fit = added.probability, diagnosis.model
    else:
        before, after = added.before, added.after
        quantities = quantities_of(diagnosis.runs, diagnosis.model, added.placed)
        probability, fit = _step_probability(diagnosis, added), added.candidate.fit
        doubts = (*_doubts(diagnosis, added.placed), *_untested_words(diagnosis, added))
    return Addition(
        effect=added.effect,
        component=added.component,
        quantities=quantities,
        probability=probability,
        look_alikes=added.look_alikes,
        before=before,
        after=after,
        fit=fit,
        doubts=doubts,
    )


def _doubts(diagnosis: Diagnosis, placed: Hypothesis) -> Iterator[str]:
    """Yield which parameters of an effect in the model lie at a bound, or where no hardware has them."""
    model, effect = diagnosis.model, placed.effect
    values = model.effect_values[model.own(placed)]
    yield from _held_torque(diagnosis, effect, float(values[0]))
    for index, parameter in enumerate(effect.parameters):
        value = float(values[index])
        if parameter.lies_at_bound(value / parameter.growth_on(placed.moment)):
            yield f"{parameter.name} lies at {value:.3g}, where its search ends: the name is what came nearest"
            continue
        limit = passed_limit(value, *_plausible(parameter, diagnosis.runs.mean_moment(model.theta)))
        if limit is not None and effect.id in _LATE and abs(value) <= _slowest_interval(diagnosis.runs):
            continue  # a sample that is held until the next one is as late, whatever the rate
        if limit is not None:
            yield (
                f"{_in_words(effect, values, index, value)} is implausible, as hardware ends at "
                f"{_in_words(effect, values, index, limit)}: something else may be behind it"
            )


_LATE = {"actuator_delay": 1.0, "gyro_latency": 1.0, "telemetry_skew": -1.0}
"""Effects by which torques act later than they are recorded, with the sign of their parameter then."""
_HALF = 0.1
"""Share of half a sample's interval within which a delay is taken for it.

Source: chosen: ten times the standard error of a delay that was half of 20 ms (0.0099 to 0.0101 s)."""


def _held_torque(diagnosis: Diagnosis, effect: NamedEffect, late: float) -> Iterator[str]:
    """Yield what a delay of half a sample may be: torques that are held until the next one."""
    run = diagnosis.runs.grid.runs[0]
    half = 0.5 * float(np.median(np.diff(run.actuator_time)))
    if diagnosis.runs.trimmed and abs(_LATE.get(effect.id, 0.0) * late - half) < _HALF * half:
        yield (
            f"{late:.3g} s is half of the time between two samples of applied_torque: a torque that is held until the "
            'next sample looks like this; [diagnosis] applied_torque = "held" says that it is'
        )


def passed_limit(value: float, least: float, greatest: float) -> float | None:
    """Return which limit a value has passed; None where it lies between them."""
    return least if value < least else greatest if value > greatest else None


def _slowest_interval(runs: Runs) -> float:
    """Return the longest usual interval between samples of any run, of the gyro or the actuators, s."""
    every = (time for run in runs.grid.runs for time in (run.gyro_time, run.actuator_time))
    return max(float(np.median(np.diff(time))) for time in every)


def _plausible(parameter: Parameter, moment: float) -> tuple[float, float]:
    """Return the least and greatest value that a parameter has in hardware; forces go with the platform's inertia."""
    share = PLAUSIBLE_PER_INERTIA.get(parameter.unit)
    if share is None:
        return parameter.plausible
    limit = share * moment if moment > 0.0 else np.inf
    return -limit, limit


def _in_words(effect: NamedEffect, values: Array, index: int, value: float) -> str:
    """Return a parameter's value as it is reported, such as a bandwidth for a time constant."""
    changed = values.copy()
    changed[index] = value
    parameter, quantities = effect.parameters[index], effect.quantities(changed, np.zeros(len(values)))
    if len(quantities) != len(values):
        return f"{parameter.name} = {value:.3g} {parameter.unit}".removesuffix(" 1")
    return f"{quantities[index].name} = {quantities[index].value:.3g} {quantities[index].unit}".removesuffix(" 1")


def _untested_words(diagnosis: Diagnosis, step: Step) -> Iterator[str]:
    """Yield which effects that these data cannot test would look like one that was added."""
    names = [each for each in diagnosis.untestable if each.keeps_share and each.looks_like(step.effect)]
    if names:
        said = ", ".join(f"{each.effect} (which needs {each.needs.replace('_', ' ')})" for each in names)
        yield f"these data cannot test {said}, which would look like it and keeps its share of the probability"


def doubt_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield why names are to be doubted."""
    for each in additions(diagnosis):
        yield from (f"{each.effect.id} ({each.component}): {doubt}" for doubt in each.doubts)


def _step_probability(diagnosis: Diagnosis, step: Step) -> float:
    unmodelled = diagnosis.unmodelled_beside_steps if step is diagnosis.steps[0] else -np.inf
    probabilities = probabilities_of(step.screening, unmodelled, diagnosis.untested(step.screening))
    members = (step.placed, *step.look_alikes)
    return sum(probabilities.get(each.key, 0.0) for each in members)


def noise_notices(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return what there is to say of a noise that is taken for larger than it is; a smaller one is an effect."""
    if not diagnosis.noise.overstated:
        return ()
    ratio = float(np.sqrt(np.nanmean(diagnosis.noise.ratio**2)))
    taken = (
        "the gyro's noise is stated too large"
        if diagnosis.runs.noise_stated
        else "the gyro's noise, which no record states, was taken from its fastest changes, and what the effects "
        "explain is among these"
    )
    return (
        f"{taken}: the samples show {ratio:.2f} times as much; effects have to be larger than they need to be to be "
        "found: state gyro_noise_rad_s beside the records as it is",
    )


def inertia_change(diagnosis: Diagnosis) -> InertiaChange:
    """Return how the inertia of the final model differs from the nominal one."""
    return _change_from(diagnosis, diagnosis.nominal_theta, np.zeros((6, 6)))


def changed_inertia(diagnosis: Diagnosis) -> InertiaChange | None:
    """Return how the inertia of the final model differs from that of healthy records; None without them."""
    belief = diagnosis.runs.belief
    healthy = None if belief is None else belief.healthy_inertia
    return None if healthy is None else _change_from(diagnosis, *healthy)


def _change_from(diagnosis: Diagnosis, theta: Theta, uncertain: Covariance) -> InertiaChange:
    """Return how the inertia of the final model differs from another one, which is known with a covariance."""
    difference = diagnosis.model.theta - theta
    std = np.sqrt(stds_of(diagnosis.model)[:6] ** 2 + np.diag(uncertain))
    shown = diagnosis.model.shown[:6]
    statistic = 0.0
    if shown.any() and np.isfinite(std[shown]).all():
        covariance = (diagnosis.model.covariance[:6, :6] + uncertain)[np.ix_(shown, shown)]
        statistic = float(difference[shown] @ np.linalg.solve(covariance, difference[shown]))
    difference = np.where(shown, difference, np.nan)
    return InertiaChange(
        theta=theta,
        difference=difference,
        std=std,
        p_value=float(scipy.stats.chi2.sf(statistic, max(int(shown.sum()), 1))),
    )


def nominal_gap(diagnosis: Diagnosis) -> Gap:
    """Return the gap of the nominal inertia, only initial rates fitted; infinite where its motion diverges."""
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
