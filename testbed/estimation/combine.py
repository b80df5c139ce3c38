"""One estimate from several runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from testbed.arrays import Array, Covariance, Theta
from testbed.dynamics.inertia import inertia_words
from testbed.estimation.body import nearest_body
from testbed.estimation.estimate import Estimate


@dataclass(frozen=True, kw_only=True, repr=False)
class CombinedEstimate:
    """The weighted average of several runs.

    Attributes:
        theta: θ̂, shape (6,), kg·m².
        covariance: P, by the gyro's noise alone, shape (6, 6), kg²·m⁴.
        considered: shift of θ̂ by one standard deviation of each quantity that is not estimated, shape (6, K), kg·m².
        spread: further covariance, where estimates that should agree differ by more than that, shape (6, 6), kg²·m⁴.
    """

    theta: Theta
    covariance: Covariance
    considered: Array = field(default_factory=lambda: np.zeros((6, 0)))
    spread: Covariance = field(default_factory=lambda: np.zeros((6, 6)))

    def __repr__(self) -> str:
        return f"Estimate of all records together: {inertia_words(self.theta, self.std)}"

    @property
    def total_covariance(self) -> Covariance:
        """Covariance of θ̂ by noise, by what is uncertain of actuators and gyro, and by the spread, (6, 6), kg²·m⁴."""
        return np.asarray(self.covariance + self.considered @ self.considered.T + self.spread)

    @property
    def std(self) -> Theta:
        """Standard deviation of θ̂, everything considered, shape (6,), kg·m²."""
        return np.sqrt(np.diag(self.total_covariance))

    @property
    def noise_std(self) -> Theta:
        """Standard deviation of θ̂ by the gyro's noise alone, shape (6,), kg·m²."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def body_theta(self) -> Theta:
        """The most likely inertia that some body has, shape (6,), kg·m²; θ̂ itself where that is a body's."""
        return nearest_body(self.theta, self.total_covariance)


def combined(estimates: Sequence[Estimate]) -> CombinedEstimate:
    """Return θ̂ = P Σ P⁽ⁱ⁾⁻¹ θ̂⁽ⁱ⁾ with P = (Σ P⁽ⁱ⁾⁻¹)⁻¹ over one or more runs' estimates.

    What is considered, such as a rotor's momentum, is the same in all runs: its shifts add up like the estimates.

    Source: paper eq. (33).
    """
    weights = np.array([np.linalg.inv(estimate.covariance) for estimate in estimates])
    thetas = np.array([estimate.theta for estimate in estimates])
    shifts = np.array([estimate.considered for estimate in estimates])
    covariance = np.linalg.inv(weights.sum(axis=0))
    return CombinedEstimate(
        theta=covariance @ np.einsum("nij,nj->i", weights, thetas),  # eq. (33)
        covariance=covariance,
        considered=covariance @ np.einsum("nij,njk->ik", weights, shifts),
    )
