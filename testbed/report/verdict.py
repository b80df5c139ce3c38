"""The verdict on a run, in one sentence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import scipy

from testbed.arrays import Theta
from testbed.assembly.estimators import UNCERTAINTY_KEYS
from testbed.campaign.statistics import CampaignStatistics, EstimatorStatistics
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.estimation.agreement import REFUSED
from testbed.estimation.answer import Answer
from testbed.report.frame.blocks import Notice
from testbed.report.sections.inertias import Inertias
from testbed.report.wording import BAND, estimator_name, figures, listed

_LEADING = ("output_error", "iv_momentum", "iv", "ls")
"""Estimators in the order in which a verdict speaks of them: the most efficient first."""
BIASED = "ls"
"""Least squares is there as the baseline: noise biases it, and that does not speak against a flight."""
_CONFIDENCE = 0.95
MOSTLY_CONSIDERED = 2.0
"""Standard deviation, noise and considered quantities together, over that by noise alone, from which a verdict states
what the rest comes from. Source: formula, at 2 the rest is three quarters of the variance."""
ALL_BUT_CONSIDERED = 10.0
"""The same ratio, from which an interval says what was assumed of those quantities and nothing of the flight: in doubt.
Source: chosen, an order of magnitude; noise is then less than a hundredth of the variance."""
_LARGE_SHARE = 0.25
"""Share of the variance from which a further quantity is named. Source: chosen, so that two or three are."""


def flight_verdict(inertias: Inertias, doubts: Sequence[str] = ()) -> Notice:
    """Return the verdict on a completed flight: how many bands cover the truth, and how near the bound the best is.

    Args:
        inertias: estimates, truth and bound.
        doubts: what else speaks against the estimates.
    """
    if not inertias.by_name:
        return Notice(tone="bad", text="The flight was completed, but no estimator gave an estimate.")
    judged = [name for name in inertias.by_name if name != BIASED] or [*inertias.by_name]
    off = [name for name in judged if _error_p_value(inertias, name) < REFUSED]
    expected = "" if doubts and not off else _as_expected(off)
    text = f"The flight was completed; {_coverage(inertias, judged)}{expected}{_distance_to_bound(inertias)}."
    text += considered_words(inertias)
    if off or doubts or _is_assumed(inertias):
        return Notice(tone="warn", text=f"{text} {_doubtful(doubts)}".strip())
    return Notice(tone="good", text=text)


def diverged_verdict() -> Notice:
    """Return the verdict on a flight that did not reach its end."""
    text = "The simulation diverged and nothing was estimated; what was recorded until then follows."
    return Notice(tone="bad", text=text)


def measured_verdict(inertias: Inertias, source: str, doubts: Sequence[str] = ()) -> Notice:
    """Return the verdict on measured records: how certain the most efficient estimator is.

    Args:
        inertias: of the only record, or of all of them combined.
        source: how many records these are, for people.
        doubts: what speaks against the estimates.
    """
    best = leading_estimator(inertias.by_name)
    estimate = inertias.by_name[best]
    text = (
        f"The inertia was estimated from {source}; {estimator_name(best)} states an uncertainty of "
        f"{_span(estimate.std)} kg·m² (one standard deviation), {_span(estimate.noise_std)} of it by noise."
    )
    text += considered_words(inertias)
    if doubts or _is_assumed(inertias):
        return Notice(tone="warn", text=f"{text} {_doubtful(doubts)}".strip())
    return Notice(tone="good", text=text)


def campaign_verdict(statistics: CampaignStatistics) -> Notice:
    """Return the verdict on a campaign: coverage, scatter and bias of the most efficient estimator, as of a single run.

    Not of the one with the least squared error of this campaign: where the model is wrong, it is the one that shows it
    the least.
    """
    if not statistics.estimators:
        return Notice(tone="bad", text="No estimator gave two estimates: there is no scatter to speak of.")
    best = leading_estimator(statistics.estimators)
    of = statistics.estimators[best]
    shares = " to ".join(dict.fromkeys(f"{100.0 * share:.0f}" for share in (of.coverage.min(), of.coverage.max())))
    text = f"Of {of.runs} runs, the 95 % intervals of {estimator_name(best)} hold the truth in {shares} %; "
    if np.isfinite([of.scatter_over_bound, of.bias_in_standard_errors]).all():
        text += (
            f"its scatter is {_span(of.scatter_over_bound, 3)} times the Cramér-Rao bound, its largest bias "
            f"{figures(np.abs(of.bias_in_standard_errors).max(), 2)} standard errors."
        )
    else:
        text += "without noise nothing is said of its scatter and bias."
    against = [*_campaign_doubts(of), *([f"{statistics.failed} runs failed."] if statistics.failed else [])]
    return Notice(tone="warn" if against else "good", text=" ".join([text, *against]))


def considered_words(inertias: Inertias) -> str:
    """Return a sentence on what makes the uncertainty larger than noise does; empty where it is mostly noise.

    Args:
        inertias: estimates; the leading one's uncertainty is explained.
    """
    best = leading_estimator(inertias.by_name)
    estimate = inertias.by_name[best]
    shares = _considered_shares(estimate)
    if not shares:
        return ""
    first, *others = sorted(shares, key=lambda kind: -shares[kind])
    named = [first, *(kind for kind in others if shares[kind] >= _LARGE_SHARE)]
    parts = listed(f"{100 * shares[kind]:.0f} % from estimation.uncertainty.{UNCERTAINTY_KEYS[kind]}" for kind in named)
    largest = figures((_considered_std(estimate) / estimate.noise_std).max())
    assumed = " The intervals are those of what was assumed, hardly of this flight." if _is_assumed(inertias) else ""
    return (
        f" This is up to {largest} times what the gyro's noise makes: of the variance, in the mean of the parameters, "
        f"{parts}; state there what is known of it.{assumed}"
    )


def _is_assumed(inertias: Inertias) -> bool:
    """Return whether the leading estimator's interval is all but that of considered quantities."""
    estimate = inertias.by_name[leading_estimator(inertias.by_name)]
    return bool((_considered_std(estimate) > ALL_BUT_CONSIDERED * estimate.noise_std).any())


def leading_estimator(by_name: Iterable[str]) -> str:
    """Return the most efficient of some estimators."""
    names = set(by_name)
    return next(name for name in _LEADING if name in names)


def _considered_shares(estimate: Answer) -> dict[str, float]:
    """Return each kind's share of the variance without the spread, mean of the parameters; none where noise leads."""
    std = _considered_std(estimate)
    if not (std > MOSTLY_CONSIDERED * estimate.noise_std).any():
        return {}
    return {kind: float(np.mean(of / std**2)) for kind, of in estimate.considered_variance.items()}


def _considered_std(estimate: Answer) -> Theta:
    """Return the standard deviation by noise and considered quantities, without the spread, shape (6,), kg·m²."""
    return np.asarray(np.sqrt(estimate.noise_std**2 + (estimate.considered**2).sum(axis=1)))


def _campaign_doubts(of: EstimatorStatistics) -> Iterator[str]:
    hits = np.rint(of.coverage * of.runs)
    if np.any(scipy.stats.binom.cdf(hits, of.runs, _CONFIDENCE) < REFUSED):
        yield "They hold it in fewer runs than 95 % allows by chance: the stated uncertainty is too small."
    if is_biased(of):
        yield "The bias is more than chance."
    if of.std.all() and (wider := float((of.claimed_std / of.std).max())) > ALL_BUT_CONSIDERED:
        yield (
            f"They are up to {figures(wider, 2)} times as wide as the estimates scatter: those of what was assumed, "
            "hardly of these flights."
        )


def is_biased(of: EstimatorStatistics) -> bool:
    """Return whether chance hardly makes the largest of an estimator's biases, by their own scatter (Student's t)."""
    if not of.std.all():  # runs that do not scatter say nothing of chance
        return False
    p_values = 2.0 * scipy.stats.t.sf(np.abs(of.bias_in_standard_errors), of.runs - 1)
    return bool(len(p_values) * p_values.min() < REFUSED)


def _error_p_value(inertias: Inertias, name: str) -> float:
    """Return the chance of an error as large, if an estimator's covariance is right."""
    estimate = inertias.by_name[name]
    error = estimate.theta - inertias.origin
    return float(scipy.stats.chi2.sf(float(error @ np.linalg.solve(estimate.total_covariance, error)), len(error)))


def _coverage(inertias: Inertias, judged: Sequence[str]) -> str:
    misses = dict(_misses(inertias, judged))
    total = len(PARAMETER_NAMES) * len(judged)
    missed = sum(len(names) for names in misses.values())
    aside = "" if len(judged) == len(inertias.by_name) else f" ({estimator_name(BIASED)} aside)"
    if not missed:
        return f"all {total} of the estimators' 95 % bands{aside} cover the truth"
    where = "; ".join(f"{estimator_name(name)} misses {listed(names)}" for name, names in misses.items())
    return f"{total - missed} of the estimators' {total} 95 % bands{aside} cover the truth ({where})"


def _as_expected(off: Sequence[str]) -> str:
    if not off:
        return ", as chance has it"
    return f", and {listed(map(estimator_name, off))} {'is' if len(off) == 1 else 'are'} off by more than chance"


def _distance_to_bound(inertias: Inertias) -> str:
    if inertias.bound_std is None or not inertias.bound_std.all():  # without noise there is none
        return ""
    best = leading_estimator(inertias.by_name)
    ratio = inertias.by_name[best].std / inertias.bound_std
    return f"; {estimator_name(best)} states {_span(ratio, 3)} times the Cramér-Rao bound"


def _doubtful(doubts: Sequence[str]) -> str:
    if not doubts:
        return ""
    return f"Do not rely on it yet: {len(doubts)} finding{'s' * (len(doubts) > 1)} below put it in doubt."


def _span(values: Theta, digits: int = 2) -> str:
    least, most = figures(values.min(), digits), figures(values.max(), digits)
    return least if least == most else f"{least} to {most}"


def _misses(inertias: Inertias, judged: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    for name in judged:
        outside = np.abs(inertias.ratio(name)) > BAND
        if outside.any():
            yield name, [parameter for parameter, out in zip(PARAMETER_NAMES, outside, strict=True) if out]
