"""Everything that one run of a scenario produced, between the flight and what is written about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from testbed.arrays import Theta, Vector3
from testbed.assembly.platform import PlatformModel
from testbed.dynamics.environment import Pivoted
from testbed.estimation.agreement import Agreement
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.estimate import Estimate
from testbed.experiment.aligning import Aligning
from testbed.experiment.checking import Checks, Compared
from testbed.experiment.flying import FlownRun
from testbed.experiment.planning import Plan
from testbed.scenario.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class Estimation:
    """The estimates of one record beside the bound.

    Attributes:
        by_name: each estimator's answer; an estimator that failed is absent.
        failures: why an estimator is absent, by its name.
        bound_std: square root of the Cramér-Rao bound's diagonal, shape (6,), kg·m²; None where it does not exist.
        offset_bound_std: the same of the centre of mass on a pivot, shape (3,), m; None without one.
        pivot: that the platform is believed to stand on; None of one that floats.
        checks: what vouches for the estimates; None where they were not tested, or there are none.
        zero_momentum_p_value: of a record that goes along with an initial momentum as much, if there was none; None
            where none was assumed.
        initial_momentum: whether the initial momentum was estimated, or taken to be zero.
        outliers: gyro samples that were left out because they stand apart.
    """

    by_name: Mapping[str, Estimate]
    failures: Mapping[str, str]
    bound_std: Theta | None
    offset_bound_std: Vector3 | None = None
    pivot: Pivoted | None = None
    checks: Checks | None = None
    zero_momentum_p_value: float | None = None
    initial_momentum: Literal["estimated", "zero"] = "estimated"
    outliers: int = 0


@dataclass(frozen=True, kw_only=True)
class CombinedEstimation:
    """The estimates of several runs, averaged.

    Attributes:
        by_name: the average of each estimator.
        runs: number of runs.
        runs_agreement: of the runs, by estimator; none of a single run.
        compared: an efficient estimator with a robust one, over all runs; None where there is but one.
        pivot: that the platform is believed to stand on; None of one that floats.
    """

    by_name: Mapping[str, CombinedEstimate]
    runs: int
    runs_agreement: Mapping[str, Agreement]
    compared: Compared | None
    pivot: Pivoted | None = None


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """One run of a scenario.

    Attributes:
        scenario: what was asked for.
        seed: of the sensor noise.
        nominal: the platform that controller, designer and estimators believe in.
        truth: the platform that flew.
        plan: the maneuver, and its design where it was designed.
        flown: record, figures, and whether it diverged.
        estimation: None where the flight diverged.
        aligning: None where the flight diverged, or the scenario does not ask for alignments.
    """

    scenario: Scenario
    seed: int
    nominal: PlatformModel
    truth: PlatformModel
    plan: Plan
    flown: FlownRun
    estimation: Estimation | None
    aligning: Aligning | None = None

    @property
    def outcome(self) -> str:
        """`completed` or `diverged`."""
        return "diverged" if self.flown.divergence else "completed"
