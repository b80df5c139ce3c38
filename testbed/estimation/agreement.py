"""Do estimates agree that should: runs of one platform, and an efficient estimator with a robust one?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from testbed.arrays import Covariance, Theta
from testbed.estimation.estimate import Estimate


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """How well estimates agree.

    Attributes:
        chi_square: of their differences.
        freedom: its degrees of freedom.
        p_value: of differences as large by chance.
    """

    chi_square: float
    freedom: int
    p_value: float

    @property
    def refused(self) -> bool:
        """Whether the estimates differ by more than chance."""
        return self.p_value < REFUSED

    @property
    def excess(self) -> float:
        """By how much the differences' variance exceeds what is stated, as a share of that; 0 where they agree."""
        return max(self.chi_square / self.freedom - 1.0, 0.0) if self.refused else 0.0


_LEAST_SHARE = 1e-4
"""Of the largest variance; what is smaller is rounding, where two estimators are nearly one."""
REFUSED = 1e-3
"""p-value below which estimates are taken to differ: one sound result in a thousand is then called into doubt."""


def runs_agreement(estimates: Sequence[Estimate]) -> Agreement:
    """Test that two or more runs estimate one inertia, and on a pivot one centre of mass.

    χ² = min over θ and p of Σ (θ̂⁽ⁱ⁾ - θ - C⁽ⁱ⁾ p)ᵀ P⁽ⁱ⁾⁻¹ (...) + pᵀ p: what is considered, such as a rotor's momentum,
    is the same in all runs, but moves each estimate by its own C⁽ⁱ⁾. On a pivot θ has the offset behind it.

    Args:
        estimates: of one estimator, a run each.
    """
    rows, response, unknowns = [], [], len(estimates[0].joint)
    for estimate in estimates:
        root = np.linalg.inv(np.linalg.cholesky(estimate.joint_covariance))
        rows.append(root @ np.hstack([np.eye(unknowns), estimate.joint_considered]))
        response.append(root @ estimate.joint)
    prior = np.eye(rows[0].shape[1])[unknowns:]
    regressor = np.vstack([*rows, prior])
    measured = np.concatenate([*response, np.zeros(len(prior))])
    scale = np.linalg.norm(regressor, axis=0)
    answer = np.linalg.lstsq(regressor / scale, measured, rcond=None)[0]
    rest = measured - regressor / scale @ answer
    return _agreement(float(rest @ rest), unknowns * (len(estimates) - 1))


def estimators_agreement(difference: Theta, covariance: Covariance) -> Agreement:
    """Test that two estimators answer alike (Hausman): a robust one, and an efficient one that trusts more.

    Args:
        difference: of their answers, shape (6,), kg·m².
        covariance: of the difference, built from what each makes of the same noise, so that it is positive semidefinite
            in a finite sample too, shape (6, 6), kg²·m⁴.

    Source: J. A. Hausman, Specification Tests in Econometrics, Econometrica 46, 1978.
    """
    scale = np.sqrt(np.diag(covariance))
    strength, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    seen = strength > _LEAST_SHARE * strength[-1]
    parts = axes[:, seen].T @ (difference / scale)
    return _agreement(float(np.sum(parts**2 / strength[seen])), int(seen.sum()))


def _agreement(chi_square: float, freedom: int) -> Agreement:
    return Agreement(chi_square=chi_square, freedom=freedom, p_value=float(scipy.stats.chi2.sf(chi_square, freedom)))
