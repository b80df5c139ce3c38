"""Estimates of the inertia as the pages show them, of one run or of several combined."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from testbed.arrays import Theta
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.estimate import Estimate

AnyEstimate: TypeAlias = Estimate | CombinedEstimate


@dataclass(frozen=True, kw_only=True)
class Inertias:
    """The estimates of the inertia beside the nominal and the true one.

    Attributes:
        by_name: each estimator's estimate.
        bound_std: square root of the Cramér-Rao bound's diagonal, shape (6,), kg·m²; None where there is none.
        nominal: θ of the model before the flight, kg·m².
        truth: θ of the simulated platform, kg·m²; None for measured records.
    """

    by_name: Mapping[str, AnyEstimate]
    bound_std: Theta | None
    nominal: Theta
    truth: Theta | None

    @property
    def origin(self) -> Theta:
        """What differences refer to: the truth, or the nominal θ where nobody knows it."""
        return self.nominal if self.truth is None else self.truth

    @property
    def most_certain(self) -> str:
        """The estimator that states the smallest sum of variances."""
        return min(self.by_name, key=lambda name: float(np.sum(self.by_name[name].std ** 2)))

    @property
    def bound_center(self) -> Theta:
        """Where the bound was taken: at the truth, or at the most certain estimate where nobody knows it."""
        return self.by_name[self.most_certain].theta if self.truth is None else self.truth

    def ratio(self, name: str) -> Theta:
        """Return (θ̂ - origin) / std of an estimator, shape (6,)."""
        estimate = self.by_name[name]
        return np.asarray((estimate.theta - self.origin) / estimate.std)
