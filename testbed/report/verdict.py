"""The run's answer in one plain sentence."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.campaign.statistics import CampaignStatistics, EstimatorStatistics
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.report.frame.blocks import Notice
from testbed.report.sections.inertias import Inertias
from testbed.report.wording import BAND, estimator_name, figures, listed


def flight_verdict(inertias: Inertias) -> Notice:
    """Return the verdict on a completed flight: the closest estimator, its largest error, and the bands."""
    if not inertias.by_name:
        return Notice(tone="bad", text="The flight was completed, but no estimator gave an estimate.")
    best = _closest(inertias)
    ratio = np.abs(inertias.ratio(best))
    worst = int(np.argmax(ratio))
    text = (
        f"The flight was completed; closest to the true inertia is the estimate by {estimator_name(best)}: its largest "
        f"error is {figures(ratio[worst], 2)} standard deviations (in {PARAMETER_NAMES[worst]}), "
        f"and {_coverage(inertias)}."
    )
    return Notice(tone="good", text=text)


def diverged_verdict() -> Notice:
    """Return the verdict on a flight that did not reach its end."""
    text = "The simulation diverged and nothing was estimated; what was recorded until then follows."
    return Notice(tone="bad", text=text)


def measured_verdict(inertias: Inertias, records: int) -> Notice:
    """Return the verdict on measured records: the most certain estimator and how certain it is.

    Args:
        inertias: of the only record, or of all of them combined.
        records: how many there are.
    """
    best = inertias.most_certain
    std = inertias.by_name[best].std
    source = "one record" if records == 1 else f"{records} records"
    text = (
        f"The inertia was estimated from {source}; {estimator_name(best)} states the smallest uncertainty, "
        f"{figures(std.min(), 2)} to {figures(std.max(), 2)} kg·m² (one standard deviation)."
    )
    return Notice(tone="good", text=text)


def campaign_verdict(statistics: CampaignStatistics) -> Notice:
    """Return the verdict on a campaign: the estimator with the smallest errors, how near the bound, how honest."""
    if not statistics.estimators:
        return Notice(tone="bad", text="No estimator gave two estimates: there is no scatter to speak of.")
    best = min(statistics.estimators, key=lambda name: _mean_square_error(statistics.estimators[name]))
    of = statistics.estimators[best]
    text = (
        f"Closest to the truth over {of.runs} runs is {estimator_name(best)}: its scatter is "
        f"{figures(of.scatter_over_bound.min(), 3)} to {figures(of.scatter_over_bound.max(), 3)} times the Cramér-Rao "
        f"bound, its largest bias {figures(np.abs(of.bias_in_standard_errors).max(), 2)} standard errors, and its 95 % "
        f"intervals hold the truth in {100.0 * of.coverage.min():.0f} to {100.0 * of.coverage.max():.0f} % of them."
    )
    return Notice(tone="good", text=text)


def _mean_square_error(of: EstimatorStatistics) -> float:
    return float(np.sum(of.mean_error**2 + of.std**2))


def _closest(inertias: Inertias) -> str:
    """Return the estimator with the smallest root mean square error in kg·m²."""
    errors = {name: estimate.theta - inertias.origin for name, estimate in inertias.by_name.items()}
    return min(errors, key=lambda name: float(np.sum(errors[name] ** 2)))


def _coverage(inertias: Inertias) -> str:
    misses = dict(_misses(inertias))
    total = len(PARAMETER_NAMES) * len(inertias.by_name)
    missed = sum(len(names) for names in misses.values())
    if not missed:
        return f"all {total} of the estimators' 95 % bands cover the truth"
    where = "; ".join(f"{estimator_name(name)} misses {listed(names)}" for name, names in misses.items())
    return f"{total - missed} of the estimators' {total} 95 % bands cover the truth ({where})"


def _misses(inertias: Inertias) -> Iterator[tuple[str, list[str]]]:
    for name in inertias.by_name:
        outside = np.abs(inertias.ratio(name)) > BAND
        if outside.any():
            yield name, [parameter for parameter, out in zip(PARAMETER_NAMES, outside, strict=True) if out]
