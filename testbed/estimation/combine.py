"""One estimate from several runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Covariance, Theta
from testbed.estimation.estimate import Estimate


@dataclass(frozen=True, kw_only=True)
class CombinedEstimate:
    """The weighted average of several runs.

    Attributes:
        theta: θ̂, shape (6,), kg·m².
        covariance: P, shape (6, 6), kg²·m⁴.
    """

    theta: Theta
    covariance: Covariance

    @property
    def std(self) -> Theta:
        """Standard deviation of θ̂, shape (6,), kg·m²."""
        return np.sqrt(np.diag(self.covariance))


def combined(estimates: Sequence[Estimate]) -> CombinedEstimate:
    """Return θ̂ = P Σ P⁽ⁱ⁾⁻¹ θ̂⁽ⁱ⁾ with P = (Σ P⁽ⁱ⁾⁻¹)⁻¹ over one or more runs' estimates.

    Source: paper eq. (33).
    """
    weights = np.array([np.linalg.inv(estimate.covariance) for estimate in estimates])
    thetas = np.array([estimate.theta for estimate in estimates])
    covariance = np.linalg.inv(weights.sum(axis=0))
    theta = covariance @ np.einsum("nij,nj->i", weights, thetas)  # eq. (33)
    return CombinedEstimate(theta=theta, covariance=covariance)
