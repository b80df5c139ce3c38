"""What is known of a platform's parameters before the records are read: bodies' inertias, trims and effects' sizes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from testbed.arrays import Array, Covariance, Matrix3, Theta, Vector3
from testbed.dynamics.inertia import (
    inertia_of,
    log_ratio,
    of_log_ratio,
    slopes_of_log_ratio,
    theta_of,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shown:
    """What healthy records show of an effect that is not in their model.

    Attributes:
        key: of the effect.
        mean: of its parameters, from where it is absent, fitted to all of these records, shape (K,).
        covariance: of the mean by noise, shape (K, K).
        scatter: covariance by which records differ, noise apart, shape (K, K).
    """

    key: str
    mean: Array
    covariance: Array
    scatter: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Belief:
    """What is known of a model's parameters before its runs are seen. Each known number is one more row of a fit.

    Attributes:
        nominal_theta: inertia that the logarithm U of `dynamics.inertia.log_ratio` is taken over, shape (6,), kg·m².
        log_ratio: mean of U, shape (6,).
        log_ratio_std: its standard deviation; infinite for none, zero where the inertia is known.
        reach: largest eigenvalue of U, either sign.
        trim: mean of the actuators' constant torque in a record, shape (3,), N·m.
        trim_std: its scatter from record to record, shape (3,), N·m; infinite where any trim is as likely.
        effects: key, mean and standard deviation of the parameters of effects that are known to be there.
        others: what healthy records show of effects that are not in the model.
        of_loop: whether healthy records show the controller's answer to the motion, rather than that to commands.
        records: number of the healthy records that show it; 0 where there are none.
        scatter: standard deviation of U from one healthy record to the next, beyond what noise makes of it.
        noise: effects on the gyro's noise that healthy records have: key, size and its standard error.
        torque_noise: the least that there is, as `Runs` has it: what turned the healthy platform turns it still; None
            where that is not known.
        common: covariance of the means of U and of `effects`, shape (6 + K, 6 + K), where other records show them: all
            records share that error, such as a factor of torque and inertia, beside which they agree far better; None
            where none do.
    """

    nominal_theta: Theta
    log_ratio: Array
    log_ratio_std: float
    reach: float
    trim: Vector3
    trim_std: Vector3
    effects: tuple[tuple[str, Array, Array], ...] = ()
    others: tuple[Shown, ...] = ()
    of_loop: bool = False
    records: int = 0
    scatter: float = 0.0
    noise: tuple[tuple[str, float, float], ...] = ()
    torque_noise: Array | None = None
    common: Covariance | None = None

    def effect(self, key: str) -> tuple[Array, Array]:
        """Return mean and standard deviation of the parameters of an effect that is known to be there, shapes (K,)."""
        return next((mean, std) for known, mean, std in self.effects if known == key)

    def shown_of(self, key: str) -> Shown | None:
        """Return what healthy records show of an effect that is not in the model; None where that is not known."""
        return next((each for each in self.others if each.key == key), None)

    def spread_of(self, shown: Shown, records: int) -> Covariance:
        """Return the covariance by which healthy records leave an effect's parameters open, shape (K, K).

        Args:
            shown: by the healthy records.
            records: number of those that show it now.
        """
        return shown.scatter * (1.0 / records + 1.0 / self.records) + shown.covariance

    @property
    def nominal(self) -> Matrix3:
        """The inertia itself, shape (3, 3), kg·m²."""
        return inertia_of(self.nominal_theta)

    @property
    def healthy_inertia(self) -> tuple[Theta, Covariance] | None:
        """θ of the healthy records, shape (6,), kg·m², and its covariance as that of one more; None without them."""
        if not self.records or self.common is None:
            return None
        by_logarithm = slopes_of_log_ratio(self.log_ratio, self.nominal, np.eye(3))
        covariance = self.common[:6, :6] + self.scatter**2 * (1.0 + 1.0 / self.records) * np.eye(6)
        return theta_of(of_log_ratio(self.log_ratio, self.nominal)), by_logarithm @ covariance @ by_logarithm.T

    def of_records(self) -> Belief:
        """Return what is known of each record by itself: runs that are held out have the rest from those fitted."""
        return replace(self, log_ratio_std=np.inf, effects=(), common=None)

    @property
    def known_std(self) -> Array:
        """Standard deviations of U and of the effects' parameters, shape (6 + K,)."""
        # The square of U is the sum of all nine entries: those off the diagonal count twice.
        logarithm = self.log_ratio_std / np.sqrt([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
        return np.concatenate([logarithm, *(std for _, _, std in self.effects)])

    def log_ratio_of(self, theta: Theta) -> Theta:
        """Return U of an inertia, shape (6,)."""
        return log_ratio(inertia_of(theta), self.nominal)

    def within_reach(self, logarithm: Theta) -> Theta:
        """Return θ, shape (6,), kg·m², of the nearest U that is within reach."""
        sizes, axes = np.linalg.eigh(inertia_of(logarithm))
        near = theta_of((axes * np.clip(sizes, -self.reach, self.reach)) @ axes.T)
        return theta_of(of_log_ratio(near, self.nominal))

    def moved(self, theta: Theta, step: Theta) -> Theta:
        """Return an inertia after a step, both of shape (6,), kg·m²: U takes the step that it is to first order."""
        logarithm = self.log_ratio_of(theta)
        slopes = slopes_of_log_ratio(logarithm, self.nominal, np.eye(3))
        return self.within_reach(logarithm + np.linalg.solve(slopes, step))

    def ways(self, theta: Theta) -> tuple[Array, Array]:
        """Return ∂θ/∂U about the axes of U, shape (6, 6), and the limits that U is at: -1, 0 or 1, shape (6,)."""
        logarithm = self.log_ratio_of(theta)
        sizes, axes = np.linalg.eigh(inertia_of(logarithm))
        at_limit = np.concatenate([np.sign(sizes) * (np.abs(sizes) > _AT_REACH * self.reach), np.zeros(3)])
        return slopes_of_log_ratio(logarithm, self.nominal, axes), at_limit


_AT_REACH = 1.0 - 1e-9
"""Share of the reach from which on U is at its limit: rounding of its eigenvalues."""
