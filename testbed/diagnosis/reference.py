"""What healthy records show of a platform, which the nominal model of suspect ones takes over."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbed.arrays import Array, Covariance, Indices, Theta, Vector3
from testbed.diagnosis.belief import Belief, Shown
from testbed.diagnosis.control_loop import acts_steadily, shows_the_loop, with_mean_thrust
from testbed.diagnosis.data import Runs
from testbed.diagnosis.detectable import first_screening
from testbed.diagnosis.fitting import fitted, fitted_initial_rates, refit
from testbed.diagnosis.model import UNDETERMINED, Fit, Hypothesis, evaluated, orthonormal
from testbed.diagnosis.run_agreement import Seen, determined_inverse, rows_of_runs, seen_by_record
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.signatures import Signature, signatures
from testbed.diagnosis.state import Diagnosis
from testbed.diagnosis.testable import without
from testbed.diagnosis.trims import with_own_trims
from testbed.dynamics.inertia import slopes_of_log_ratio
from testbed.errors import InputError


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
    runs, model = with_own_trims(diagnosis.runs, diagnosis.model)
    heldout = diagnosis.heldout and replace(diagnosis.heldout, trim_group=())
    of_loop = shows_the_loop(runs, model)
    if of_loop:
        runs, heldout = with_mean_thrust(runs), heldout and with_mean_thrust(heldout)
        model = without_trims_by_name(runs, refit(runs, model))
    diagnosis = replace(diagnosis, runs=runs, model=model, heldout=heldout)
    others = None if heldout is None else fitted_initial_rates(heldout, model)
    seen = seen_by_record(diagnosis.runs, model)
    if heldout is not None and others is not None:
        seen |= seen_by_record(heldout, others)
    if len(seen) < SETTINGS.fewest_reference_records:
        raise InputError(
            f"the reference holds too few records ({', '.join(seen)}): {SETTINGS.fewest_reference_records} or more "
            "healthy ones are needed to tell how much the platform differs from one to the next"
        )
    prior = model.belief or _no_belief(diagnosis.nominal_theta)
    given = tuple(replace(each, given=True) for each in model.placed if each.effect.recurs)
    scatter, effect_std = _scatter_of(seen, model, prior)
    inertia_std = float(np.clip(scatter, SETTINGS.least_reference_scatter, SETTINGS.inertia_uncertainty))
    kept = [model.own(each) for each in model.placed if each.effect.recurs]
    effects = [(each.key, model.effect_values[own], effect_std[own]) for each, own in zip(given, kept, strict=True)]
    trims = model.trims
    if heldout is not None and others is not None:
        trims = np.concatenate([trims, others.trims])
    count = len(trims)
    belief = replace(
        prior,
        log_ratio=prior.log_ratio_of(model.theta),
        log_ratio_std=min(inertia_std, prior.log_ratio_std),
        trim=trims.mean(axis=0) if count else prior.trim,
        trim_std=trims.std(axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / count) if count else prior.trim_std,
        effects=tuple(effects),
        noise=tuple((each.key, *each.size) for each in diagnosis.scatter),
        common=_common_covariance(model, prior),
        of_loop=of_loop,
    )
    shown = tuple(_shown_of_others(diagnosis, belief)) if runs.known_in_part else ()
    belief = replace(belief, others=shown, records=len(seen), scatter=scatter, torque_noise=diagnosis.runs.torque_noise)
    return Reference(
        belief=belief,
        given=given,
        sigma=np.sqrt(np.mean(diagnosis.runs.sigma**2, axis=0)),
        noise_freedom=diagnosis.runs.noise_freedom,
        records=tuple(seen),
    )


def without_trims_by_name(runs: Runs, model: Fit) -> Fit:
    """Return a model without the effects that no sample shows beside the records' trims, which take over what they did.

    Under a mean thrust a weak motor is a constant torque. Taken over as what nothing is known of, it would explain
    whatever torque is new in suspect records.
    """
    kept = [each for each in model.placed if _is_seen(model, each)]
    if len(kept) == len(model.placed):
        return model
    return fitted(runs, kept, model.theta, [model.effect_values[model.own(each)] for each in kept], model)


def _is_seen(model: Fit, placed: Hypothesis) -> bool:
    """Return whether the samples show an effect beside all else that is fitted, by more than rounding."""
    alone = model.jacobian[:, 6:][:, model.own(placed)]
    return float(np.sum(model.signature_of(placed) ** 2)) > UNDETERMINED * float(np.sum(alone**2))


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
    if screening is None:
        return
    runs = replace(diagnosis.runs, belief=belief)
    fit = evaluated(runs, diagnosis.model.placed, diagnosis.model.values)
    others = [
        each.placed
        for each in screening.signatures
        if not belief.of_loop or acts_steadily(each.placed.effect, runs.grid)
    ]
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
        beside = fitted(
            runs, [*fit.placed, placed], fit.theta, [*(value[0] for value in fit.values.effects), start], fit
        )
    except InputError:  # the motion runs away: what is known is that it is absent
        columns, residual, mean = signature.columns, fit.residual, np.zeros(len(absent))
    else:
        columns, residual = beside.signature_of(placed), beside.residual
        mean = beside.effect_values[beside.own(placed)] - absent
    ratio, in_one = _explained_of_noise(columns, residual, rows)
    return Shown(key=placed.key, mean=mean, covariance=determined_inverse(columns.T @ columns), scatter=in_one), ratio


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
        covariances.append(determined_inverse(columns[own].T @ columns[own]))
    return explained / max(directions, 1), np.asarray(np.median(covariances, axis=0))


def _rows_of_records(runs: Runs, count: int) -> list[Indices]:
    """Return which numbers of a residual, of so many, are of each record: its windows' samples, its trim's belief."""
    by_run = list(rows_of_runs(runs))
    trims = count - 3 * len(runs.record_names)
    return [
        np.concatenate(
            [*(by_run[run] for run in np.flatnonzero(runs.record_of == number)), trims + 3 * number + np.arange(3)]
        )
        for number in range(len(runs.record_names))
    ]


def _common_covariance(model: Fit, prior: Belief) -> Covariance:
    """Return that of U and of the parameters of all effects that recur, shape (6 + K, 6 + K)."""
    kept = np.concatenate([np.full(6, True), *(np.full(each.size, each.effect.recurs) for each in model.placed)])
    turn, own = np.linalg.inv(_slopes_by_logarithm(model, prior)), model.covariance
    unseen = (SETTINGS.inertia_uncertainty * model.theta[:3].mean()) ** 2  # about axes that a bearing holds
    covariance = turn @ np.where(np.isinf(own), unseen, own) @ turn.T
    return np.asarray(covariance[np.ix_(kept, kept)])


def _slopes_by_logarithm(model: Fit, prior: Belief) -> Array:
    """Return what (θ, effects) change by with (U, effects), shape (C, C)."""
    slopes = np.eye(6 + len(model.effect_values))
    slopes[:6, :6] = slopes_of_log_ratio(prior.log_ratio_of(model.theta), prior.nominal, np.eye(3))
    return slopes


def _no_belief(theta: Theta) -> Belief:
    std, unknown = SETTINGS.inertia_uncertainty, np.full(3, np.inf)
    reach = SETTINGS.inertia_reach * std
    return Belief(
        nominal_theta=theta, log_ratio=np.zeros(6), log_ratio_std=std, reach=reach, trim=np.zeros(3), trim_std=unknown
    )


def _scatter_of(seen: Mapping[str, Seen], model: Fit, prior: Belief) -> tuple[float, Array]:
    """Return by how much U and every effect's parameters differ from record to record, beyond what noise makes of them.

    Each with the uncertainty of the fit itself: what differs less than that is not known better.
    """
    turn = _slopes_by_logarithm(model, prior)
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
    return float(np.sqrt(between[:3].mean())), np.sqrt(between[6:] + own)
