"""Table 2 and figure 3: the closed loop flown many times, the paper's estimator and three others beside the bound."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from testbed.arrays import Array, Theta
from testbed.assembly.platform import true_platform
from testbed.campaign.executor import Executor
from testbed.campaign.plan import CampaignPlan
from testbed.campaign.run import Progress as CampaignProgress
from testbed.campaign.run import run_campaign
from testbed.campaign.statistics import CampaignStatistics, errors_of, estimators_of, statistics_of
from testbed.dynamics.inertia import theta_of
from testbed.maneuver.maneuver import Maneuver
from testbed.reproduction.noise_free import predicted_iv_bias
from testbed.reproduction.parts import NOWHERE, Parts, kept_maneuver
from testbed.reproduction.progress import Progress, silent
from testbed.reproduction.scenarios import paper_scenario
from testbed.scenario.scenario import Scenario

PAPER_STD: Mapping[str, Theta] = {
    "basic": 1e-3 * np.array([1.12, 1.67, 1.30, 1.27, 1.01, 1.20]),
    "scaled": 1e-3 * np.array([0.67, 0.96, 0.76, 0.74, 0.60, 0.69]),
    "paper_d_optimal": 1e-3 * np.array([0.38, 0.33, 0.35, 0.23, 0.24, 0.28]),
}
"""kg·m². Source: paper Table 2, st.d. of 100 runs."""
PAPER_MEAN: Mapping[str, Theta] = {
    "basic": 1e-3 * np.array([22.24, 22.33, 27.30, 0.14, 0.12, 0.15]),
    "scaled": 1e-3 * np.array([22.14, 22.15, 27.15, 0.05, 0.05, 0.05]),
    "paper_d_optimal": 1e-3 * np.array([22.12, 22.11, 27.02, 0.04, 0.10, 0.01]),
}
"""kg·m². Source: paper Table 2, avg."""
PAPER_RUNS = 100
"""Source: paper section 5.1."""
PAPER_PEAK_RATE = 0.3
"""rad/s, of the paper's D-opt and scaled maneuvers. Source: paper section 5.1."""
LIKE_FOR_LIKE = "gimbal_slow"
"""This project's maneuver that turns no faster than the paper's."""
OWN = "gimbal_weighted"
"""This project's maneuver at the cluster's own limits, which eq. (31) allows too: three times as fast."""
SCENARIOS = ("basic", "scaled", "paper_d_optimal", LIKE_FOR_LIKE, OWN)
"""The paper's three maneuvers, and this project's."""
MANEUVER_NAMES: Mapping[str, str] = {
    "basic": "basic",
    "scaled": "scaled",
    "paper_d_optimal": "D-opt",
    LIKE_FOR_LIKE: "gimbal space, slow",
    OWN: "gimbal space",
}
"""What tables call them; the first three as the paper does."""
FEWEST_DRIFTING = 20
"""Runs again with the drift, where a fifth is fewer."""
_INSTANTS = 501
"""At which a peak is looked for; between them a spline of 20 points gains less than 1e-4 of it."""
BIAS_INSTABILITY = 2e-4
"""rad/s, 41 deg/h: of a consumer-grade MEMS gyro; correlation time 100 s."""
RATE_RANDOM_WALK = 1e-4
"""rad/s/√s, of the same class: 2.2e-4 rad/s after 5 s."""


@dataclass(frozen=True, kw_only=True)
class ManeuverStatistics:
    """One maneuver of Table 2.

    Attributes:
        name: of the scenario.
        maneuver: its reference.
        true_theta: shape (6,), kg·m².
        statistics: of every estimator.
        errors: estimate - truth by estimator, shape (runs, 6), kg·m²; for the box plot.
        drift: the same statistics with a gyro whose bias drifts, on the first of the same seeds.
        steady: of exactly those seeds without the drift.
        predicted_iv_bias: mean error that the paper's estimator has in theory, shape (6,), kg·m².
        paper_mean: kg·m²; None for a maneuver that the paper does not have.
        paper_std: kg·m²; likewise.
    """

    name: str
    maneuver: Maneuver
    true_theta: Theta
    statistics: CampaignStatistics
    errors: Mapping[str, Array]
    drift: CampaignStatistics
    steady: CampaignStatistics
    predicted_iv_bias: Theta
    paper_mean: Theta | None
    paper_std: Theta | None

    @property
    def title(self) -> str:
        """What tables call it."""
        return MANEUVER_NAMES[self.name]

    @property
    def peak_rate(self) -> float:
        """Largest body rate of the reference about any axis, rad/s."""
        time = np.linspace(0.0, self.maneuver.duration, _INSTANTS)
        return float(np.abs(self.maneuver.reference(time).body_rate).max())


def standard_error_of_std(std: Theta, runs: int) -> Theta:
    """Return the standard error of standard deviations, of normal errors, kg·m².

    Args:
        std: shape (6,), kg·m².
        runs: that they were taken of.
    """
    return np.asarray(std / np.sqrt(2.0 * (runs - 1)))


def table2(
    runs: int, seed: int, executor: Executor, progress: Progress = silent, parts: Parts = NOWHERE
) -> tuple[ManeuverStatistics, ...]:
    """Fly every maneuver of Table 2, and again with a drifting gyro.

    Args:
        runs: of each maneuver; a fifth of them, and at least 20, again with the drift.
        seed: of the campaigns; the same for each, so that maneuvers meet the same noise.
        executor: where the runs are flown.
        progress: called with each campaign and its runs.
        parts: that are finished.
    """
    return tuple(_maneuver(name, runs, seed, executor, progress, parts) for name in SCENARIOS)


def _maneuver(
    name: str, runs: int, seed: int, executor: Executor, progress: Progress, parts: Parts
) -> ManeuverStatistics:
    scenario = paper_scenario(name)
    maneuver = kept_maneuver(scenario, parts)
    again = min(runs, max(FEWEST_DRIFTING, runs // 5))

    def flown(gyro: str, flown_scenario: Scenario, count: int) -> pa.Table:
        plan = CampaignPlan(scenario=flown_scenario, maneuver=maneuver, seed=seed, runs=count)
        campaign_progress = CampaignProgress(kept=progress(f"Table 2, {name}, {gyro} gyro", count))
        return run_campaign(plan, parts.campaign(f"{name}-{gyro}-seed{seed}"), executor, campaign_progress)

    table = flown("steady", scenario, runs)
    drift = flown("drifting", _with_drift(scenario), again)
    return ManeuverStatistics(
        name=name,
        maneuver=maneuver,
        true_theta=theta_of(true_platform(scenario).inertia),
        statistics=statistics_of(table),
        errors={estimator: errors_of(table, estimator) for estimator in estimators_of(table)},
        drift=statistics_of(drift),
        steady=statistics_of(table.slice(0, again)),
        predicted_iv_bias=predicted_iv_bias(scenario, maneuver),
        paper_mean=PAPER_MEAN.get(name),
        paper_std=PAPER_STD.get(name),
    )


def _with_drift(scenario: Scenario) -> Scenario:
    drifting = scenario.gyro.model_copy(
        update={
            "bias_instability_rad_s": BIAS_INSTABILITY,
            "bias_correlation_time_s": 100.0,
            "rate_random_walk_rad_s_per_sqrt_s": RATE_RANDOM_WALK,
        }
    )
    return scenario.model_copy(update={"gyro": drifting})
