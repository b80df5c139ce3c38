"""What makes this project's estimates more precise than the paper's: estimator, maneuver, faster turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Theta
from testbed.reproduction.table2 import PAPER_STD, ManeuverStatistics

_EFFICIENT = "output_error"


@dataclass(frozen=True, kw_only=True)
class Gains:
    """Ratios of standard deviations, shape (6,) each; below 1 is a gain.

    Attributes:
        reproduction: the paper's D-opt maneuver with its estimator, flown here, over the paper's row.
        estimator: output error over that, on the same flights.
        maneuver: this project's maneuver that turns no faster, over the paper's, both with output error.
        rate: this project's maneuver at the cluster's own limits over that one.
    """

    reproduction: Theta
    estimator: Theta
    maneuver: Theta
    rate: Theta

    @property
    def total(self) -> Theta:
        """This project's maneuver with output error over the paper's row: the product of all."""
        return np.asarray(self.reproduction * self.estimator * self.maneuver * self.rate)


def gains_of(d_optimal: ManeuverStatistics, slow: ManeuverStatistics, own: ManeuverStatistics) -> Gains:
    """Separate the gains.

    Args:
        d_optimal: the paper's maneuver.
        slow: this project's that turns no faster.
        own: this project's at the cluster's own limits.
    """
    iv, efficient = (_std(d_optimal, name) for name in ("iv", _EFFICIENT))
    return Gains(
        reproduction=np.asarray(iv / PAPER_STD["paper_d_optimal"]),
        estimator=np.asarray(efficient / iv),
        maneuver=np.asarray(_std(slow, _EFFICIENT) / efficient),
        rate=np.asarray(_std(own, _EFFICIENT) / _std(slow, _EFFICIENT)),
    )


def _std(maneuver: ManeuverStatistics, estimator: str) -> Theta:
    return maneuver.statistics.estimators[estimator].std
