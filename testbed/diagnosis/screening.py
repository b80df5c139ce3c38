"""Hypotheses compared with the present model: all linearised, the most promising ones refitted."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import exp, inf, isnan, log

import numpy as np

from testbed.arrays import Array, Covariance, Theta
from testbed.diagnosis.belief import Shown
from testbed.diagnosis.candidates import Candidate, Screening, implausibility, mean_over_scan
from testbed.diagnosis.control_loop import shows_the_loop
from testbed.diagnosis.data import Runs
from testbed.diagnosis.descent import ROUGHLY
from testbed.diagnosis.errors_in_variables import taken_out
from testbed.diagnosis.fitting import all_corrected, fitted, in_torque_noise, refit
from testbed.diagnosis.misfit import log_evidence
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.p_values import log_p_value
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.short_runs import start_of_short_runs
from testbed.diagnosis.signatures import Signature, Start, reach_of, signatures
from testbed.diagnosis.size_prior import SizePrior
from testbed.dynamics.inertia import inertia_of
from testbed.errors import InputError
from testbed.prediction.grid import Grid

_SHARES = (1.0, 0.1, 0.0)
"""Of the linearised solution, from which a refit starts one after the other until one comes near what it promised: all
of it, a tenth, none. Of effects of eight detectable sizes the whole may be of no body: a mode left a platform without
inertia (seed 1, 2 of 6 such modes), and is named from a tenth."""
_LOST = 30.0
"""Of χ², by which a refit may fall short of the gain that the linearised effect promises, and is not started from less:
five times what decides between hypotheses. Of 126 refits of effects without a scan (cases 9 and 12 of 14 of seed 90817)
none falls short by more than 1.9: what falls short by 30 has lost its way."""

_LOST_SHARE = 0.3
"""Share of the promised gain, over windows of torque that is known in part, by which a refit may fall short as well:
what is promised there are hundreds, which is far from linear, and each refit takes seconds."""

_FAR = 100.0
"""Times the noise's variance beyond which a residual may be that of quite another motion: a search that lost its way
then begins from what fits short parts of the runs (`short_runs`).

Source: chosen; ten standard deviations of each sample."""

_HOPELESS = 0.0
"""Linearised evidence up to which a hypothesis is not refitted: among forty it takes 7.4 to be as probable as none. Of
500 refits from below it (the first 120 cases of seed 9203), 11 % of the time, none came to more than 3.9."""


def screened(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    hypotheses: Sequence[Hypothesis],
    progress: Callable[[str], None] = lambda _: None,
) -> Screening:
    """Test every hypothesis, and refit those that explain the most.

    Args:
        runs: that the model was fitted to.
        heldout: to verify on; None where there are none.
        fit: the present model.
        hypotheses: effects that are not in it.
        progress: called with what is being refitted.
    """
    every = list(signatures(runs, fit, hypotheses))
    best = most_telling(every)
    tested, moment = max(len(best), 1), runs.mean_moment(fit.theta)
    linearised = {each.placed.key: _linearised_evidence(runs, each, moment) for each in best}
    order = sorted(best, key=lambda each: -linearised[each.placed.key])
    hopeful = [each for each in order[1 : SETTINGS.most_refits] if linearised[each.placed.key] > _HOPELESS]
    promising = [each for each in (*order[:1], *hopeful) if each.rank]  # the first one also: it came nearest
    candidates, aside, cancelling, without = [], [], [], log_evidence(heldout, fit)
    for signature in promising:
        progress(signature.placed.key)
        candidate = _candidate(runs, heldout, fit, signature, tested, without)
        if candidate is None:
            aside.append(signature.placed)
        elif candidate.cancels:
            cancelling.append(signature.placed)
        else:
            candidates.append(candidate)
    return Screening(
        signatures=tuple(best),
        tested=tested,
        candidates=tuple(sorted(candidates, key=lambda candidate: -candidate.log_bayes_factor)),
        linearised={key: each for key, each in linearised.items() if key not in {one.placed.key for one in promising}},
        set_aside=tuple(aside),
        cancelling=tuple(cancelling),
        prior_odds=runs.prior_odds,
    )


def most_telling(every: Sequence[Signature]) -> list[Signature]:
    """Return each hypothesis at the start at which it explains the most, with what is said at the others.

    Args:
        every: hypotheses at all their starts.
    """
    by_key: dict[str, list[Signature]] = {}
    for signature in every:
        by_key.setdefault(signature.placed.key, []).append(signature)
    return [_best_of(starts) for starts in by_key.values()]


def _best_of(starts: Sequence[Signature]) -> Signature:
    best = max(starts, key=lambda each: each.score)
    reaches = tuple(map(reach_of, starts)) if best.placed.effect.scans_frequencies else ()
    return replace(best, elsewhere=tuple(each.here for each in starts if each is not best), reaches=reaches)


def refitted(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    screening: Screening,
    placed: Hypothesis,
    known: Fit | None = None,
) -> Candidate | None:
    """Return one hypothesis of a screening, refitted whether it was promising or not.

    None where no motion of a body can be fitted with it.

    Args:
        runs: as in `screened`, like the held-out ones and the fit.
        heldout: see there.
        fit: see there.
        screening: of the hypotheses.
        placed: the hypothesis.
        known: the model with it that was found before; a search that ends far from as good begins from there again.
    """
    signature = next(each for each in screening.signatures if each.placed.key == placed.key)
    candidate = next((each for each in screening.candidates if each.placed.key == placed.key), None)
    if candidate is None:
        candidate = _candidate(runs, heldout, fit, signature, screening.tested, log_evidence(heldout, fit))
    if known is None or (candidate is not None and candidate.fit.deviance < known.deviance + _LOST):
        return candidate
    return _candidate(runs, heldout, fit, signature, screening.tested, log_evidence(heldout, fit), known)


def _candidate(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    signature: Signature,
    tested: int,
    without: float,
    known: Fit | None = None,
) -> Candidate | None:
    placed = signature.placed
    try:
        runs, model = (
            (runs, _refitted(runs, fit, signature)) if known is None else _from_known(runs, fit, known, placed)
        )
        own_runs, heldout = all_corrected(runs, heldout, model)
        if own_runs is not runs:  # what the gyro is off by, it is off in the gimbals' channels as well
            model = refit(own_runs, model)
        in_own = in_torque_noise(own_runs, heldout, model)
    except (InputError, np.linalg.LinAlgError):  # with it the motion runs away: it does not explain these runs
        return None
    if not shows_the_loop(in_own[0], in_own[2]):  # else its noise is no better known than the nominal model's
        own_runs, heldout, model = in_own
    if not _is_of_a_body(model):
        return None
    gain, size_evidence = _evidence_of_refit(runs, fit, model, signature)
    fall = fit.deviance - model.deviance
    heldout_gain = verified = held_out_evidence(heldout, model) - without if placed.effect.recurs else 0.0
    if heldout_gain > 0.0:  # what explains nothing of the fitted runs is verified on none
        heldout_gain *= gain / fall if fall > 0.0 else 0.0
    nothing_new = 0.0 if _shown_of(runs, placed) is None else fall + verified - gain - heldout_gain
    here = size_evidence + heldout_gain
    if isnan(here):  # held-out runs have no density with it: it does not explain these runs
        return None
    evidence = _anywhere(runs, signature, here, runs.mean_moment(fit.theta))
    alone = log_p_value(gain, max(signature.rank, 1), runs.noise_freedom)
    return Candidate(
        placed=placed,
        fit=model,
        chi_square_reduction=gain,
        rank=signature.rank,
        trials_penalty=0.5 * (here - evidence),
        size_penalty=gain - size_evidence,
        heldout_log_likelihood_gain=heldout_gain,
        log_bayes_factor=evidence - implausibility(model) + implausibility(fit),
        by_run=own_runs.noise_deviance + [float((part**2).sum()) for part in runs.by_run(model.residual)],
        p_value=p_value_of_all(alone, tested * scan_count_of(runs, placed), heldout_gain),
        nothing_new=nothing_new,
    )


def p_value_of_all(alone: float, tests: int, heldout_gain: float) -> float:
    """Return the p-value of a candidate.

    Args:
        alone: its logarithm by the fitted runs, of one test.
        tests: number of hypotheses, times that of its start values.
        heldout_gain: twice the logarithm of the held-out likelihood ratio.
    """
    corrected = alone + log(tests) - 0.5 * heldout_gain
    together = max(corrected, alone + log(SETTINGS.family_wise_error / SETTINGS.fitted_runs_p_value))
    return exp(min(together, 0.0))


def _evidence_of_refit(runs: Runs, fit: Fit, model: Fit, signature: Signature) -> tuple[float, float]:
    """Return by how much a hypothesis reduces the deviance beyond what healthy records show, and the evidence of that.

    Less what of the telemetry's noise it takes out of the prediction.

    Args:
        runs: that are fitted.
        fit: without the hypothesis.
        model: with it.
        signature: of the hypothesis, at the start of its search.
    """
    placed, gain = signature.placed, max(fit.deviance - model.deviance - taken_out(runs, fit, model), 0.0)
    columns, own = model.signature_of(placed), model.effect_values[model.own(placed)]
    values = own - [each.absent for each in placed.effect.parameters]
    information, slope = columns.T @ columns, columns.T @ model.residual
    prior, known = SizePrior.of(placed.effect, signature.start, runs.mean_moment(fit.theta)), _known_of(runs, placed)
    if known is None:
        return gain, prior.evidence_of_fit(gain, values, information, slope)
    left, new = _left(known.spread, information), values - known.mean
    gain *= _share(information, values, left, new)
    return gain, prior.evidence_of_fit(gain, new, left, np.zeros(len(new)))


def _evidence_at(runs: Runs, signature: Signature, start: Start, moment: float) -> float:
    """Return the evidence of a hypothesis linearised at a start, beyond what healthy records differ by.

    What they show in the mean was fitted, and is not compared with a linearisation where the effect is absent.
    """
    prior = SizePrior.of(signature.placed.effect, start.values, moment)
    known = _known_of(runs, signature.placed)
    if known is None:
        return prior.evidence(start.information, start.slope)
    left = _left(known.spread, start.information)
    gain = start.score * _share(start.information, start.step, left, start.step)
    return prior.evidence_of_fit(gain, start.step, left, np.zeros(len(left)))


def _share(information: Array, values: Array, left: Array, new: Array) -> float:
    """Return the Wald statistic of what is new over that of all, between 0 and 1."""
    whole = float(values @ information @ values)
    return min(float(new @ left @ new) / whole, 1.0) if whole > 0.0 else 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class _Known:
    """What an effect's parameters are without it: mean, shape (K,), and covariance, shape (K, K), from its absence."""

    mean: Array
    spread: Covariance


def _known_of(runs: Runs, placed: Hypothesis) -> _Known | None:
    """Return what healthy records show of an effect, and what of it these do not resolve; None where it is absent."""
    shown, blur = _shown_of(runs, placed), blur_of(placed, runs.grid)
    if shown is None or runs.belief is None:
        return _Known(mean=np.zeros(len(blur)), spread=np.diag(blur**2)) if blur.any() else None
    return _Known(mean=shown.mean, spread=runs.belief.spread_of(shown, len(runs.record_names)) + np.diag(blur**2))


def blur_of(placed: Hypothesis, grid: Grid) -> Array:
    """Return the standard deviations by which parameters seem to be there though the effect is absent, shape (K,)."""
    effect = placed.effect
    return np.where([each.name == effect.instant for each in effect.parameters], 0.0, effect.unresolved(grid))


def _left(spread: Covariance, information: Array) -> Array:
    """Return the information on what is new of an effect's parameters, shape (K, K): N⁻¹ grows by the spread."""
    left = information @ np.linalg.inv(np.eye(len(spread)) + spread @ information)
    return np.asarray(0.5 * (left + left.T))


def _shown_of(runs: Runs, placed: Hypothesis) -> Shown | None:
    return None if runs.belief is None else runs.belief.shown_of(placed.key)


def _is_of_a_body(model: Fit) -> bool:
    """Return whether every axis of a model has an inertia."""
    return bool(np.linalg.eigvalsh(inertia_of(model.theta))[0] > 0.0)


def scan_count_of(runs: Runs, placed: Hypothesis) -> int:
    """Return by how many start values of its scan a hypothesis multiplies the chance of a large reduction.

    Args:
        runs: that are fitted.
        placed: the hypothesis.
    """
    return placed.effect.scan_count(placed.component, runs.grid)


def _linearised_evidence(runs: Runs, signature: Signature, moment: float) -> float:
    """Return the evidence of a hypothesis by its linearisation alone."""
    return _anywhere(runs, signature, _evidence_at(runs, signature, signature.here, moment), moment)


def _anywhere(runs: Runs, signature: Signature, here: float, moment: float) -> float:
    """Return the evidence of a hypothesis, averaged over the start values of its scan.

    Args:
        runs: that are fitted.
        signature: of the hypothesis.
        here: its evidence at the start that it is best at.
        moment: mean moment of inertia, kg·m².
    """
    elsewhere = [_evidence_at(runs, signature, start, moment) for start in signature.elsewhere]
    return mean_over_scan(here, elsewhere, scan_count_of(runs, signature.placed))


def held_out_evidence(heldout: Runs | None, fit: Fit) -> float:
    """Return the evidence of held-out runs; minus infinity where their motion runs away with the model.

    Args:
        heldout: None where there are none.
        fit: to the others.
    """
    try:
        return log_evidence(heldout, fit)
    except InputError:  # what fits some runs and lets others run away is no platform
        return -inf


def _refitted(runs: Runs, fit: Fit, signature: Signature) -> Fit:
    """Search from the linearised solution, and from less of it where that leads nowhere: it may be of no body."""
    found: list[Fit] = []
    for theta, starts in _begun(runs, fit, signature):
        try:
            found.append(fitted(runs, [*fit.placed, signature.placed], theta, starts, fit, ROUGHLY))
        except InputError:  # the motion runs away
            continue
        lost = _LOST if runs.belief is None else max(_LOST, _LOST_SHARE * signature.score)
        if fit.chi_square - found[-1].chi_square > signature.score - lost:
            break
    if not found:
        raise InputError(f"with {signature.placed.key} the motion runs away")
    return min(found, key=lambda each: each.chi_square)


def _begun(runs: Runs, fit: Fit, signature: Signature) -> Iterator[tuple[Theta, list[Array]]]:
    """Yield inertia and effects from which to search, one after the other until one comes near what was promised."""
    effects, (first, *others) = [value[0] for value in fit.values.effects], list(_starts(runs, signature))
    yield fit.theta, [*effects, first]
    if fit.chi_square > _FAR * fit.freedom:
        short = start_of_short_runs(runs, fit, [*fit.placed, signature.placed], [*effects, first])
        if short is not None:
            yield short
    for start in others:
        yield fit.theta, [*effects, start]


def _from_known(runs: Runs, fit: Fit, known: Fit, placed: Hypothesis) -> tuple[Runs, Fit]:
    """Return runs in the noise of a model that was found before, and the same effects fitted to them from there."""
    values = dict(zip([each.key for each in known.placed], known.values.effects, strict=True))
    effects = [*fit.placed, placed]
    runs = replace(runs, torque_noise=known.torque_noise)
    return runs, fitted(runs, effects, known.theta, [values[each.key][0] for each in effects], known, ROUGHLY)


def _starts(runs: Runs, signature: Signature) -> Iterator[Array]:
    """Yield where to begin a search, inside the bounds: where healthy records have the effect, if they show it."""
    lower, upper = signature.placed.bounds
    shown = _shown_of(runs, signature.placed)
    if shown is not None:
        yield np.clip(shown.mean + [each.absent for each in signature.placed.effect.parameters], lower, upper)
    for share in _SHARES:
        yield np.clip(signature.start + share * signature.step, lower, upper)
