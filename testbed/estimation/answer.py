"""What one record, or several together, say of the inertia and, on a pivot, of the centre of mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from testbed.arrays import Array, Covariance, Theta
from testbed.estimation.body import nearest_body


@dataclass(frozen=True, kw_only=True, repr=False)
class Answer:
    """θ̂ and, on a pivot, the offset of the centre of mass from it, with their uncertainty.

    Attributes:
        theta: θ̂, shape (6,), kg·m².
        covariance: of θ̂ by the gyro's noise alone, shape (6, 6), kg²·m⁴.
        considered: shift of θ̂ by one standard deviation of each quantity that is not estimated, shape (6, K), kg·m².
        considered_kinds: of these quantities, K fields of `Uncertainty`.
        spread: covariance beyond that, by which estimates differ that should agree, shape (6, 6), kg²·m⁴.
        offset_error: of the centre of mass on a pivot, estimated less believed place, shape (3,), m; (0,) without one.
        offset_covariance: of it by the gyro's noise alone, shape (3, 3), m²; (0, 0) without one.
        offset_cross_covariance: of θ̂ with it, by the gyro's noise alone, shape (6, 3), kg·m³; (6, 0) without one.
        offset_considered: its shift as `considered`, shape (3, K), m.
        offset_spread: as `spread`, shape (3, 3), m²; (0, 0) without one.
    """

    theta: Theta
    covariance: Covariance
    considered: Array = field(default_factory=lambda: np.zeros((6, 0)))
    considered_kinds: tuple[str, ...] = ()
    spread: Covariance = field(default_factory=lambda: np.zeros((6, 6)))
    offset_error: Array = field(default_factory=lambda: np.zeros(0))
    offset_covariance: Array = field(default_factory=lambda: np.zeros((0, 0)))
    offset_cross_covariance: Array = field(default_factory=lambda: np.zeros((6, 0)))
    offset_considered: Array = field(default_factory=lambda: np.zeros((0, 0)))
    offset_spread: Array = field(default_factory=lambda: np.zeros((0, 0)))

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

    @property
    def considered_variance(self) -> Mapping[str, Theta]:
        """What each kind of quantity that is not estimated adds to the variance of θ̂, shapes (6,), kg²·m⁴."""
        kinds = np.array(self.considered_kinds)
        return {
            kind: (self.considered[:, kinds == kind] ** 2).sum(axis=1) for kind in dict.fromkeys(self.considered_kinds)
        }

    @property
    def offset_std(self) -> Array:
        """Standard deviation of the offset, everything considered, shape (3,), m; (0,) without a pivot."""
        spread = np.diag(self.offset_spread) if self.offset_spread.size else 0.0
        return np.asarray(np.sqrt(np.diag(self.offset_covariance) + (self.offset_considered**2).sum(axis=1) + spread))

    @property
    def joint(self) -> Array:
        """θ̂ with the offset's error behind it, shape (6,), kg·m², or (9,), the last three m."""
        return np.concatenate([self.theta, self.offset_error])

    @property
    def joint_covariance(self) -> Array:
        """Covariance of `joint` by the gyro's noise alone, shape (6, 6) or (9, 9)."""
        if not self.offset_error.size:
            return self.covariance
        cross = self.offset_cross_covariance
        return np.block([[self.covariance, cross], [cross.T, self.offset_covariance]])

    @property
    def joint_considered(self) -> Array:
        """Shift of `joint` as `considered`, shape (6, K) or (9, K)."""
        return np.vstack([self.considered, self.offset_considered]) if self.offset_error.size else self.considered

    @cached_property
    def body_theta(self) -> Theta:
        """The most likely inertia that some body has, shape (6,), kg·m²; θ̂ itself where that is a body's."""
        return nearest_body(self.theta, self.total_covariance)
