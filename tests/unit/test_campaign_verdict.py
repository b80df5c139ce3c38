"""The verdict on a campaign speaks of the most efficient estimator, and is good only if its intervals are earned."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.campaign.statistics import CampaignStatistics, EstimatorStatistics
from testbed.report.verdict import campaign_verdict

RUNS, STD = 100, np.full(6, 2e-4)


def estimator(*, bias: float = 0.0, coverage: float = 0.95, claimed: float = 1.0) -> EstimatorStatistics:
    """Return figures with a bias in standard errors, and intervals so many times as wide as the scatter."""
    return EstimatorStatistics(
        runs=RUNS,
        mean=np.zeros(6),
        std=STD,
        mean_error=np.full(6, bias) * STD / np.sqrt(RUNS),
        bias_in_standard_errors=np.full(6, bias),
        coverage=np.full(6, coverage),
        claimed_std=claimed * STD,
        scatter_over_bound=np.ones(6),
    )


def verdict_on(**estimators: EstimatorStatistics):
    return campaign_verdict(
        CampaignStatistics(runs=RUNS, failed=0, true_theta=np.zeros(6), bound_std=STD, estimators=estimators)
    )


def test_an_estimator_at_the_bound_is_good_beside_a_biased_baseline():
    verdict = verdict_on(ls=estimator(bias=-20.0, coverage=0.4), output_error=estimator())
    assert verdict.tone == "good"
    assert "intervals of output error hold the truth in 95 %" in verdict.text


def test_a_bias_of_the_most_efficient_estimator_is_not_hidden_by_another_without():
    """That with the least squared error of the campaign was judged: beside a hidden torque, an unbiased one."""
    verdict = verdict_on(iv=estimator(), output_error=estimator(bias=10.0, coverage=1.0, claimed=5.0))
    assert verdict.tone == "warn"
    assert "output error" in verdict.text
    assert "The bias is more than chance." in verdict.text


@pytest.mark.parametrize(("claimed", "tone"), [(9.0, "good"), (12.0, "warn")])
def test_intervals_of_what_was_assumed_are_in_doubt_as_those_of_a_single_run(claimed, tone):
    verdict = verdict_on(output_error=estimator(coverage=1.0, claimed=claimed))
    assert verdict.tone == tone
    assert ("up to 12 times as wide as the estimates scatter" in verdict.text) == (tone == "warn")
