"""What a diagnosis found, as reports and files need it: additions, detectable sizes, agreement of runs.

Whether an effect has one size in all runs: what is missing acts alike in each; what stands in for it does not. The
final model is linearised, and the effect's parameters are freed in every run; all else stays shared, and is estimated
jointly. Of R runs and K parameters, χ² then falls by a χ² of K (R - 1) degrees of freedom if they agree; where the
residual exceeds the noise, it counts in units of the residual variance.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, groupby

import numpy as np
import scipy

from testbed.arrays import Array, Flags, Indices, Theta, Vector3
from testbed.diagnosis.candidates import Screening, p_value, probabilities_of
from testbed.diagnosis.data import Belief, Runs, Shown
from testbed.diagnosis.misfit import Misfit, misfit_of
from testbed.diagnosis.model import (
    Fit,
    Hypothesis,
    evaluated,
    fitted,
    fitted_initial_rates,
    nominal_fit,
    orthonormal,
    projected_out,
)
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.signatures import (
    Signature,
    answers_motion,
    confounding,
    distinguishability,
    signatures,
    smallest_detectable,
    without,
)
from testbed.diagnosis.state import Diagnosis, Gap, Step
from testbed.dynamics.inertia import slopes_of_log_ratio
from testbed.effects.contract import PLAUSIBLE_PER_INERTIA, NamedEffect, Parameter, Quantity
from testbed.effects.formula import ID as FORMULA
from testbed.errors import InputError

INERTIA = "inertia"
"""The effect that is always in the model."""
_UNDETERMINED = 1e-13
"""Share of the largest eigenvalue of a normal matrix, its columns scaled alike, below which a direction is not solved
for: above rounding, 1e-16 for each column."""


@dataclass(frozen=True, kw_only=True)
class Detectable:
    """The smallest size of an effect that these data would have shown.

    Attributes:
        placed: effect and component.
        multiple: of the typical size; infinite where this motion does not show the effect at all.
        smallest: the effect's parameters at that size, as they are reported; empty where infinite.
        typical: at their typical size.
        by_frequency: of an effect whose frequency is not known, the same at each that was looked at, about the axis
            that shows the least; multiple and smallest are then those of the frequency that shows the least.
        sized_by: names of the parameters that grow with its size, of an effect that has others, such as a frequency.
    """

    placed: Hypothesis
    multiple: float
    smallest: tuple[Quantity, ...]
    typical: tuple[Quantity, ...]
    by_frequency: tuple[Detectable, ...] = ()
    sized_by: frozenset[str] = frozenset()

    @property
    def seen_when_typical(self) -> bool:
        """Whether the effect would have been found at its typical size."""
        return self.multiple <= 1.0


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
    """How the estimated inertia differs from the nominal one.

    Attributes:
        difference: θ̂ - θ, kg·m²; NaN where the motion cannot show a parameter.
        std: of it, kg·m².
        p_value: of a difference as large if there were none (Wald test of all that are shown).
    """

    difference: Theta
    std: Theta
    p_value: float

    @property
    def significant(self) -> bool:
        """Whether it differs by more than chance."""
        return self.p_value < SETTINGS.inertia_p_value


def first_screening(diagnosis: Diagnosis) -> Screening | None:
    """Return the hypotheses against the baseline; None where they were not looked at yet."""
    return diagnosis.steps[0].screening if diagnosis.steps else diagnosis.remaining


def shown_signatures(screening: Screening | None) -> tuple[Signature, ...]:
    """Return the signatures that a reader is shown: the inertia is in every model already, and no list has formulas."""
    if screening is None:
        return ()
    return tuple(each for each in screening.signatures if each.placed.effect.id not in (INERTIA, FORMULA))


def detectable_sizes(diagnosis: Diagnosis) -> tuple[Detectable, ...]:
    """Return the smallest detectable size of every effect, in the order in which effects are listed."""
    screening = first_screening(diagnosis)
    if screening is None:
        return ()
    free = diagnosis.runs.grid.turns_freely
    return tuple(_detectable(each, screening.tested, free=free) for each in shown_signatures(screening))


def _detectable(signature: Signature, tested: int, *, free: bool) -> Detectable:
    if signature.reaches:
        return _over_frequencies(signature, tested)
    effect = signature.placed.effect
    absent = np.array([parameter.absent for parameter in effect.parameters])
    typical = np.array([parameter.typical for parameter in effect.parameters])
    multiple = smallest_detectable(signature, tested)
    none = np.zeros(len(absent))
    smallest = effect.quantities(absent + multiple * (typical - absent), none) if np.isfinite(multiple) else ()
    hidden = set() if free else _without_columns(signature)
    return Detectable(
        placed=signature.placed,
        multiple=multiple,
        smallest=tuple(each for each in smallest if each.name not in hidden),
        typical=tuple(each for each in effect.quantities(typical, none) if each.name not in hidden),
    )


def _over_frequencies(signature: Signature, tested: int) -> Detectable:
    """Return the size that is seen whatever the frequency, with the sizes that are seen at each."""
    placed, none = signature.placed, np.zeros(signature.placed.size)
    typical = placed.effect.quantities(np.array([each.typical for each in placed.effect.parameters]), none)
    sizes = []
    for _, axes in groupby(signature.reaches, key=lambda reach: float(reach.absent[0])):
        pairs = [(each.multiple(tested), each) for each in axes]
        shown = [pair for pair in pairs if np.isfinite(pair[0])]  # not axes that a bearing holds
        multiple, reach = max(shown or pairs, key=lambda pair: pair[0])
        smallest, twice = (
            placed.effect.quantities(reach.absent + times * multiple * reach.typical, none) for times in (1.0, 2.0)
        )
        sizes.append(
            Detectable(
                placed=placed,
                multiple=multiple,
                smallest=smallest if np.isfinite(multiple) else (),
                typical=typical,
                sized_by=frozenset(
                    one.name for one, other in zip(smallest, twice, strict=True) if one.value != other.value
                ),
            )
        )
    worst = max(sizes, key=lambda size: size.multiple)
    return replace(worst, by_frequency=tuple(sizes))


def _without_columns(signature: Signature) -> set[str]:
    """Return the names of an effect's parameters that change nothing about the axes about which a rig turns."""
    lengths = np.linalg.norm(signature.columns, axis=0)
    pairs = zip(signature.placed.effect.parameters, lengths, strict=True)
    return {parameter.name for parameter, length in pairs if length == 0.0 and not parameter.scanned}


def confounded(diagnosis: Diagnosis) -> tuple[tuple[Hypothesis, Hypothesis], ...]:
    """Return the hypotheses that were not tested, each with the effect in the final model that confounds it."""
    screening, present = first_screening(diagnosis), diagnosis.model.placed
    candidates = [] if screening is None else [each.placed for each in screening.signatures]
    pairs = [(each, confounding(each, present)) for each in candidates]
    return tuple((candidate, by) for candidate, by in pairs if by is not None)


def distances(signatures: tuple[Signature, ...]) -> Array:
    """Return how distinguishable every two effects are, shape (E, E): 0 for aliases, 1 for orthogonal signatures."""
    apart = np.zeros((len(signatures), len(signatures)))
    for one, other in combinations(range(len(signatures)), 2):
        apart[one, other] = apart[other, one] = distinguishability(signatures[one], signatures[other])
    return apart


def pairs_alike(diagnosis: Diagnosis) -> tuple[tuple[Hypothesis, Hypothesis, float], ...]:
    """Return the effects that these data hardly distinguish, the closest first, with their distance."""
    shown = tuple(each for each in shown_signatures(first_screening(diagnosis)) if each.rank)
    apart = distances(shown)
    pairs = [
        (shown[one].placed, shown[other].placed, float(apart[one, other]))
        for one, other in combinations(range(len(shown)), 2)
        if apart[one, other] < SETTINGS.confounded_sine
    ]
    return tuple(sorted(pairs, key=lambda pair: pair[2]))


def quantities_of(fit: Fit, placed: Hypothesis) -> tuple[Quantity, ...]:
    """Return an effect's parameters with their standard errors, as a model has them."""
    own = fit.own(placed)
    hidden = _hidden_parameters(fit, placed)
    every = placed.effect.quantities(fit.effect_values[own], stds_of(fit)[6:][own])
    return tuple(quantity for quantity in every if quantity.name not in hidden)


def _hidden_parameters(fit: Fit, placed: Hypothesis) -> frozenset[str]:
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
        quantities = quantities_of(diagnosis.model, added.placed)
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
    for index, parameter in enumerate(effect.parameters):
        value = float(values[index])
        if parameter.lies_at_bound(value / parameter.growth_on(placed.moment)):
            yield f"{parameter.name} lies at {value:.3g}, where its search ends: the name is what came nearest"
            continue
        limit = passed_limit(value, *_plausible(parameter, diagnosis.runs.mean_moment(model.theta)))
        if limit is not None:
            yield (
                f"{_in_words(effect, values, index, value)} is implausible, as hardware ends at "
                f"{_in_words(effect, values, index, limit)}: something else may be behind it"
            )


def passed_limit(value: float, least: float, greatest: float) -> float | None:
    """Return which limit a value has passed; None where it lies between them."""
    return least if value < least else greatest if value > greatest else None


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
    """Return what there is to say of a noise that is stated larger than it is; a smaller one is an effect."""
    if not diagnosis.noise.overstated:
        return ()
    ratio = float(np.sqrt(np.nanmean(diagnosis.noise.ratio**2)))
    return (
        f"the gyro's noise is stated too large: the samples show {ratio:.2f} times as much; effects have to be larger "
        "than they need to be to be found: state gyro_noise_rad_s as it is",
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """What healthy records show, as the nominal model of others takes it.

    Attributes:
        belief: of the parameters, each as uncertain as they scatter from record to record.
        given: the effects that the healthy platform has.
        sigma: of the gyro, shape (3,), rad/s.
        noise_freedom: degrees of freedom with which it is known.
        records: names of the healthy records.
    """

    belief: Belief
    given: tuple[Hypothesis, ...]
    sigma: Vector3
    noise_freedom: float
    records: tuple[str, ...]


def reference_of(diagnosis: Diagnosis) -> Reference:
    """Return what a diagnosis of healthy records shows of the platform.

    Args:
        diagnosis: complete; its effects are taken for the platform's own.

    Raises:
        InputError: a single record, which does not show by how much the platform differs from flight to flight.
    """
    model, heldout = diagnosis.model, diagnosis.heldout
    others = None if heldout is None else fitted_initial_rates(heldout, model)
    seen = _by_record(diagnosis.runs, model)
    if heldout is not None and others is not None:
        seen |= _by_record(heldout, others)
    if len(seen) < SETTINGS.fewest_reference_records:
        raise InputError(
            f"the reference holds too few records ({', '.join(seen)}): {SETTINGS.fewest_reference_records} or more "
            "healthy ones are needed to tell how much the platform differs from one to the next"
        )
    prior = model.belief or _no_belief(diagnosis.nominal_theta)
    given = tuple(replace(each, given=True) for each in model.placed if each.effect.recurs)
    inertia_std, effect_std = _scatter_of(seen, model, prior)
    kept = [model.own(each) for each in model.placed if each.effect.recurs]
    effects = [(each.key, model.effect_values[own], effect_std[own]) for each, own in zip(given, kept, strict=True)]
    trims = _trims(diagnosis.runs, model)
    if heldout is not None and others is not None:
        trims = np.concatenate([trims, _trims(heldout, others)])
    count = len(trims)
    belief = replace(
        prior,
        log_ratio=prior.log_ratio_of(model.theta),
        log_ratio_std=min(inertia_std, prior.log_ratio_std),
        trim=trims.mean(axis=0) if count else prior.trim,
        trim_std=trims.std(axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / count) if count else prior.trim_std,
        effects=tuple(effects),
    )
    shown = tuple(_shown_of_others(diagnosis, belief))
    belief = replace(belief, others=shown, records=len(seen), torque_noise=diagnosis.runs.torque_noise)
    return Reference(
        belief=belief,
        given=given,
        sigma=np.sqrt(np.mean(diagnosis.runs.sigma**2, axis=0)),
        noise_freedom=diagnosis.runs.noise_freedom,
        records=tuple(seen),
    )


def _shown_of_others(diagnosis: Diagnosis, belief: Belief) -> Iterator[Shown]:
    """Yield what healthy records show of effects that are not in the model, and by how much they differ beyond noise.

    What a feedback, a pilot or draughts make of healthy flights looks like one effect in this record and like another
    in that: such names are as likely in suspect ones. What effects explain of single records over what they explain of
    noise is known badly of few records; half of what is taken is its mean over all effects (overdispersion: McCullagh
    and Nelder, "Generalized Linear Models" (1989), section 4.5).

    Args:
        diagnosis: of the healthy records.
        belief: what is known of their trims, beside which such effects are seen.
    """
    screening = first_screening(diagnosis)
    if screening is None or not diagnosis.runs.known_in_part:
        return
    runs = replace(diagnosis.runs, belief=belief)
    fit = evaluated(runs, diagnosis.model.placed, diagnosis.model.values)
    others = [each.placed for each in screening.signatures if not answers_motion(each.placed.effect)]
    best: dict[str, Signature] = {}
    for signature in signatures(runs, fit, without(others, fit.placed)):
        known = best.get(signature.placed.key)
        best[signature.placed.key] = signature if known is None or signature.score > known.score else known
    rows = _rows_of_records(runs, len(fit.residual))
    shown = [_shown_by_records(runs, fit, signature, rows) for signature in best.values()]
    usual = float(np.mean([ratio for _, ratio in shown]))
    for each, ratio in shown:
        yield replace(each, scatter=max(0.5 * (ratio + usual) - 1.0, 0.0) * each.scatter)


def _shown_by_records(runs: Runs, fit: Fit, signature: Signature, rows: Sequence[Indices]) -> tuple[Shown, float]:
    """Return what healthy records show of an effect, fitted as in suspect ones, and by how much they differ in it.

    The scatter is as yet the covariance in one record. Of the effect's χ² in single records, beyond what all of them
    show, it has to be multiplied by how many times that of noise it is, less one: the second number.
    """
    placed = signature.placed
    absent = np.array([each.absent for each in placed.effect.parameters])
    try:
        start = np.clip(signature.start + signature.step, *placed.bounds)
        beside = fitted(runs, [*fit.placed, placed], fit.theta, [*(value[0] for value in fit.values.effects), start])
    except InputError:  # the motion runs away: what is known is that it is absent
        columns, residual, mean = signature.columns, fit.residual, np.zeros(len(absent))
    else:
        columns, residual = beside.signature_of(placed), beside.residual
        mean = beside.effect_values[beside.own(placed)] - absent
    ratio, in_one = _explained_of_noise(columns, residual, rows)
    return Shown(key=placed.key, mean=mean, covariance=_inverse(columns.T @ columns), scatter=in_one), ratio


def _explained_of_noise(columns: Array, residual: Array, rows: Sequence[Indices]) -> tuple[float, Array]:
    """Return how many times the χ² of noise an effect explains of single records, and its covariance in one, (K, K).

    Args:
        columns: of its parameters, all else projected out, shape (samples, K).
        residual: shape (samples,).
        rows: which of the samples are of each record.
    """
    explained, directions, covariances = 0.0, 0, []
    for own in rows:
        basis = orthonormal(columns[own])
        explained += float(np.sum((basis.T @ residual[own]) ** 2))
        directions += basis.shape[1]
        covariances.append(_inverse(columns[own].T @ columns[own]))
    return explained / max(directions, 1), np.asarray(np.median(covariances, axis=0))


def _inverse(normal: Array) -> Array:
    """Return the inverse of a normal matrix where it is determined, zero elsewhere."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    scaled = np.linalg.pinv(normal * np.outer(scale, scale), rcond=_UNDETERMINED, hermitian=True)
    return np.asarray(scaled * np.outer(scale, scale))


def _rows_of_records(runs: Runs, count: int) -> list[Indices]:
    """Return which numbers of a residual, of so many, are of each record: its windows' samples, its trim's belief."""
    by_run = list(_rows_of(runs))
    trims = count - 3 * len(runs.record_names)
    return [
        np.concatenate(
            [*(by_run[run] for run in np.flatnonzero(runs.record_of == number)), trims + 3 * number + np.arange(3)]
        )
        for number in range(len(runs.record_names))
    ]


def _no_belief(theta: Theta) -> Belief:
    std, unknown = SETTINGS.inertia_uncertainty, np.full(3, np.inf)
    reach = SETTINGS.inertia_reach * std
    return Belief(
        nominal_theta=theta, log_ratio=np.zeros(6), log_ratio_std=std, reach=reach, trim=np.zeros(3), trim_std=unknown
    )


def _trims(runs: Runs, fit: Fit) -> Array:
    """Return the trim of every record, shape (records, 3), N·m; of none where trims are not free."""
    if fit.values.trim is None:
        return np.zeros((0, 3))
    return np.asarray(fit.values.trim[np.unique(runs.record_of, return_index=True)[1], 0])


def _scatter_of(seen: Mapping[str, _Seen], model: Fit, prior: Belief) -> tuple[float, Array]:
    """Return by how much U and every effect's parameters differ from record to record, beyond what noise makes of them.

    Each with the uncertainty of the fit itself: what differs less than that is not known better.
    """
    slopes = slopes_of_log_ratio(prior.log_ratio_of(model.theta), prior.nominal, np.eye(3))
    turn = np.eye(6 + len(model.effect_values))
    turn[:6, :6] = slopes
    typical = [abs(parameter.typical) for each in model.placed for parameter in each.effect.parameters]
    loose = np.concatenate(
        [np.full(6, SETTINGS.inertia_uncertainty), SETTINGS.run_by_run_looseness * np.array(typical)]
    )
    changes, variances = [], []
    for each in seen.values():
        covariance = np.linalg.inv(turn.T @ each.normal @ turn + np.diag(loose**-2.0))
        changes.append(covariance @ (turn.T @ each.slope))
        variances.append(np.diag(covariance))
    between = np.maximum(np.var(changes, axis=0, ddof=1) - np.mean(variances, axis=0), 0.0)
    together = turn.T @ sum(each.normal for each in seen.values()) @ turn + np.diag(loose**-2.0)
    # The effects' own uncertainty is that beside the inertia which is taken over with them.
    own = np.diag(np.linalg.inv(together[6:, 6:])) if typical else np.zeros(0)
    inertia_std = float(np.clip(np.sqrt(between[:3].mean()), SETTINGS.least_reference_scatter, loose[0]))
    return inertia_std, np.sqrt(between[6:] + own)


def model_notices(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return what there is to know of the model that is no effect.

    Trims, an inertia at its limit, what ran away, and formulas that explain as much.
    """
    return (
        *_trim_words(diagnosis),
        *_given_words(diagnosis),
        *_inertia_words(diagnosis),
        *_set_aside_words(diagnosis),
        *_rival_words(diagnosis),
    )


def _rival_words(diagnosis: Diagnosis) -> Iterator[str]:
    if diagnosis.rivals:
        yield (
            "torques by formulas, which no library lists, explain these records nearly as well as what is named: "
            f"{', '.join(diagnosis.rivals)}"
        )


def _trim_words(diagnosis: Diagnosis) -> Iterator[str]:
    trims = _trims(diagnosis.runs, diagnosis.model)
    if not len(trims):
        return
    pairs = zip(diagnosis.runs.record_names, trims, strict=True)
    shown = "; ".join(f"{name} ({', '.join(f'{value:.2g}' for value in each)})" for name, each in pairs)
    yield (
        "a constant torque of the actuators in body axes, their trim, is estimated for each record beside the initial "
        f"rates: {shown} N·m; by itself, a constant torque on the body cannot be distinguished from it"
    )


def _given_words(diagnosis: Diagnosis) -> Iterator[str]:
    for placed in diagnosis.model.placed:
        if placed.given:
            sizes = (
                f"{each.name} {each.value:.3g} ± {each.std:.2g}" for each in quantities_of(diagnosis.model, placed)
            )
            yield f"in the nominal model, and fitted with it: {placed.key}, {', '.join(sizes)}"


def _inertia_words(diagnosis: Diagnosis) -> Iterator[str]:
    belief = diagnosis.model.belief
    if belief is None:
        return
    if belief.reach < SETTINGS.least_reference_scatter:
        yield (
            "the inertia is taken as it is stated, and its interval says nothing: over windows only its ratio to the "
            "torque per command shows, and that has a factor of its own about each axis; platform.inertia_uncertainty "
            "lets it be estimated"
            if diagnosis.runs.known_in_part
            else 'the inertia is taken as it is stated: inertia = "known"'
        )
        return
    _, limits = belief.ways(diagnosis.model.theta)
    if limits.any():
        which = "larger" if limits.sum() > 0.0 else "smaller"
        yield (
            f"the records want a {which} inertia than a factor of {np.exp(belief.reach):.2g} from the nominal one, to "
            "which it is held: torque per command, or what turns the platform beside it, is not as stated; "
            "platform.inertia_uncertainty widens the limit"
        )


def _set_aside_words(diagnosis: Diagnosis) -> Iterator[str]:
    screenings = [step.screening for step in diagnosis.steps]
    last = [] if diagnosis.remaining is None else [diagnosis.remaining]
    keys = dict.fromkeys(each.key for screening in (*screenings, *last) for each in screening.set_aside)
    if keys:
        yield f"set aside, as no motion of a body could be fitted with it: {', '.join(keys)}"


def inertia_change(diagnosis: Diagnosis) -> InertiaChange:
    """Return how the inertia of the final model differs from the nominal one."""
    difference = diagnosis.model.theta - diagnosis.nominal_theta
    std = stds_of(diagnosis.model)[:6]
    shown = diagnosis.model.shown[:6]
    statistic = 0.0
    if shown.any() and np.isfinite(std[shown]).all():
        covariance = diagnosis.model.covariance[:6, :6][np.ix_(shown, shown)]
        statistic = float(difference[shown] @ np.linalg.solve(covariance, difference[shown]))
    difference = np.where(shown, difference, np.nan)
    return InertiaChange(
        difference=difference, std=std, p_value=float(scipy.stats.chi2.sf(statistic, max(int(shown.sum()), 1)))
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Agreement:
    """The size of an effect in every run by itself.

    Attributes:
        placed: the effect, which acts in every run.
        runs: names, the fitted ones first.
        heldout: which were held out, shape (R,).
        values: of the parameters in each run, shape (R, K).
        std: their standard errors, shape (R, K); infinite where a run does not show them.
        p_value: of sizes that differ as much, if there is but one.
        hidden: names of parameters that no sample shows, such as those of axes that a bearing holds.
    """

    placed: Hypothesis
    runs: tuple[str, ...]
    heldout: Flags
    values: Array
    std: Array
    p_value: float
    hidden: frozenset[str] = frozenset()

    @property
    def disagrees(self) -> bool:
        """Whether the sizes differ by more than chance."""
        return self.p_value < SETTINGS.disagreement_p_value

    def quantities(self, run: int) -> tuple[Quantity, ...]:
        """Return the effect as one run shows it."""
        every = self.placed.effect.quantities(self.values[run], self.std[run])
        return tuple(quantity for quantity in every if quantity.name not in self.hidden)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Seen:
    """What one record says of (θ, effects), its initial rates projected out: normal matrix (C, C) and slope (C,)."""

    normal: Array
    slope: Array


def agreements(diagnosis: Diagnosis) -> tuple[Agreement, ...]:
    """Return how the runs agree on every effect that acts in all of them; nothing where there is but one run."""
    model, heldout = diagnosis.model, diagnosis.heldout
    fitted = _by_record(diagnosis.runs, model)
    others = {} if heldout is None else _by_record(heldout, fitted_initial_rates(heldout, model))
    if not all(each.effect.recurs for each in model.placed) or len(fitted) + len(others) < 2:
        return ()
    names, seen = (*fitted, *others), (*fitted.values(), *others.values())
    held_out = np.arange(len(names)) >= len(fitted)
    return tuple(_agreement(diagnosis, step.placed, names, held_out, seen) for step in diagnosis.steps)


def _by_record(runs: Runs, fit: Fit) -> dict[str, _Seen]:
    """Return what every record says; windows of one record together."""
    seen: dict[str, _Seen] = {}
    common = 6 + len(fit.effect_values)
    for name, rows in zip(runs.windowed or runs.names, _rows_of(runs), strict=True):
        jacobian = fit.jacobian[rows]
        own = orthonormal(jacobian[:, common:][:, np.any(jacobian[:, common:] != 0.0, axis=0)])
        columns = projected_out(jacobian[:, :common], own)
        normal, slope = columns.T @ columns, columns.T @ fit.residual[rows]
        before = seen.get(name)
        seen[name] = _Seen(
            normal=normal if before is None else before.normal + normal,
            slope=slope if before is None else before.slope + slope,
        )
    return seen


def _rows_of(runs: Runs) -> Iterator[Indices]:
    """Yield which of the whitened numbers belong to each run, its gimbals' channels with its gyro's."""
    run_of_block = np.arange(len(runs.measured) + len(runs.inner)) % len(runs.measured)
    sizes = [*runs.sizes, *(block.size for block in runs.inner)]
    run_of_row = np.repeat(run_of_block, sizes)
    for run in range(len(runs.measured)):
        yield np.flatnonzero(run_of_row == run)


def _agreement(
    diagnosis: Diagnosis, placed: Hypothesis, names: Sequence[str], heldout: Flags, seen: Sequence[_Seen]
) -> Agreement:
    model = diagnosis.model
    own = np.arange(6 + len(model.effect_values))[6:][model.own(placed)]
    typical = np.abs([parameter.typical for parameter in placed.effect.parameters])
    loose = SETTINGS.run_by_run_looseness * typical
    change, std, apart = _freed(seen, own, loose)
    _, _, together = _freed(seen, own[:0], typical[:0])
    freed = int(model.shown[own].sum()) or placed.size
    freedom, spread = freed * (len(names) - 1), max(1.0, model.chi_square / model.freedom)
    return Agreement(
        placed=placed,
        runs=tuple(names),
        heldout=heldout,
        values=model.effect_values[model.own(placed)] + change,
        std=np.where(std > SETTINGS.run_by_run_uninformed * SETTINGS.run_by_run_looseness * typical, np.inf, std),
        p_value=p_value(max(apart - together, 0.0) / spread, freedom, diagnosis.runs.noise_freedom),
        hidden=_hidden_parameters(model, placed),
    )


def _freed(seen: Sequence[_Seen], own: Indices, loose: Array) -> tuple[Array, Array, float]:
    """Return the changes of freed parameters in every run and their standard errors, (R, K), and by how much χ² falls.

    Args:
        seen: what every record says.
        own: which of the parameters are freed, shape (K,).
        loose: standard deviations to which they are held, shape (K,).
    """
    count, freed = len(seen[0].slope), len(own)
    shared = np.setdiff1d(np.arange(count), own)
    order, size = np.concatenate([shared, own]), len(shared) + freed * len(seen)
    normal, slope = np.zeros((size, size)), np.zeros(size)
    for run, each in enumerate(seen):
        places = np.concatenate([np.arange(len(shared)), len(shared) + freed * run + np.arange(freed)])
        normal[np.ix_(places, places)] += each.normal[np.ix_(order, order)]
        slope[places] += each.slope[order]
    held = np.arange(len(shared), size)
    normal[held, held] += np.tile(loose**-2.0, len(seen))
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=_UNDETERMINED, hermitian=True) / np.outer(
        scale, scale
    )
    step, std = inverse @ slope, np.sqrt(np.diag(inverse))
    shape = (len(seen), freed)
    return step[held].reshape(shape), std[held].reshape(shape), float(slope @ step)
