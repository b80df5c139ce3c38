"""Whether the campaign's claimed standard deviations are true: the whole campaign repeated over many seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from testbed.arrays import Array, Theta
from testbed.campaign.statistics import NORMAL_95
from testbed.estimation.combine import CombinedEstimate


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """How combined estimates of many campaigns lie about the truth; arrays have shape (6,), in the order of θ.

    Attributes:
        campaigns: how many.
        mean_error: estimate minus truth, kg·m².
        std: of the estimates, kg·m².
        claimed_std: mean of what they claim, kg·m².
        share: of the 95 % intervals that hold the truth, and
        share_band: what it may be at 95 % confidence (Clopper-Pearson), shape (6, 2).
        overall_share: of all parameters' intervals.
        largest: largest error in claimed standard deviations.
    """

    campaigns: int
    mean_error: Theta
    std: Theta
    claimed_std: Theta
    share: Theta
    share_band: Array
    overall_share: float
    largest: float


def coverage_of(estimates: Sequence[CombinedEstimate], true_theta: Theta) -> Coverage:
    """Score the combined estimates of two or more campaigns."""
    errors = np.array([estimate.theta for estimate in estimates]) - true_theta
    claimed = np.array([estimate.std for estimate in estimates])
    holds = np.abs(errors) <= NORMAL_95 * claimed
    return Coverage(
        campaigns=len(estimates),
        mean_error=errors.mean(axis=0),
        std=errors.std(axis=0, ddof=1),
        claimed_std=claimed.mean(axis=0),
        share=holds.mean(axis=0),
        share_band=np.array([_band(int(count), len(estimates)) for count in holds.sum(axis=0)]),
        overall_share=float(holds.mean()),
        largest=float(np.abs(errors / claimed).max()),
    )


def coverage_by_name(campaigns: Sequence[Mapping[str, CombinedEstimate]], true_theta: Theta) -> Mapping[str, Coverage]:
    """Score every estimator over the campaigns."""
    return {name: coverage_of([campaign[name] for campaign in campaigns], true_theta) for name in campaigns[0]}


def _band(count: int, trials: int) -> tuple[float, float]:
    interval = scipy.stats.binomtest(count, trials).proportion_ci(0.95, method="exact")
    return float(interval.low), float(interval.high)
