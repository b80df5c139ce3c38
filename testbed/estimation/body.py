"""Physically consistent inertia: which θ a rigid body can have, and the most likely of them given an estimate.

A body's inertia is J = tr(Σ) I - Σ with the second moments of its mass Σ = ∫ r rᵀ dm, which are positive semidefinite.
So J is positive definite and its principal moments obey the triangle inequalities. A flat plate has a Σ of rank 2: its
inertia lies on the border, and noise puts half of all estimates beyond it.

Source: P. M. Wensing, S. Kim, J.-J. E. Slotine, Linear Matrix Inequalities for Physically Consistent Inertial Parameter
Identification, IEEE Robotics and Automation Letters 3, 2018.
"""

from __future__ import annotations

import numpy as np
import scipy
from scipy.linalg import cholesky

from testbed.arrays import Array, Covariance, Matrix3, Theta
from testbed.dynamics.inertia import inertia_of, theta_of

_ROUNDING = 1e-9
"""Share of tr(Σ) that its smallest eigenvalue may lie below zero: a plate's inertia is written with rounded digits."""
_LOWER = np.tril_indices(3)


def second_moments(theta: Theta) -> Matrix3:
    """Return Σ = tr(J)/2 I - J, kg·m², of inertia parameters."""
    inertia = inertia_of(theta)
    return np.asarray(0.5 * np.trace(inertia) * np.eye(3) - inertia)


def is_body(theta: Theta) -> bool:
    """Return whether some body has this inertia: J positive definite, and the triangle inequalities hold."""
    moments = np.linalg.eigvalsh(second_moments(theta))
    return bool(moments[0] >= -_ROUNDING * moments.sum() and moments.sum() > 0.0)


def nearest_body(theta: Theta, covariance: Covariance) -> Theta:
    """Return the inertia of a body that is most likely given an unconstrained estimate, shape (6,), kg·m².

    It minimises (θ - θ̂)ᵀ P⁻¹ (θ - θ̂) over Σ(θ) ⪰ 0, as a search over the factor L of Σ = L Lᵀ: every L is a body, and
    no limit is needed. An estimate that is a body's is returned as it is.

    Args:
        theta: θ̂, kg·m².
        covariance: P, positive definite, kg²·m⁴.
    """
    if is_body(theta):
        return theta
    whiten = np.linalg.inv(cholesky(covariance, lower=True))
    size = np.trace(inertia_of(theta)) / 2.0
    if size <= 0.0:  # of records that are in other units an estimate may be the negative of a body's
        size = float(np.linalg.norm(theta))

    def misfit(factor: Array) -> Array:
        return np.asarray(whiten @ (_theta(factor * np.sqrt(size)) - theta))

    answer = scipy.optimize.least_squares(misfit, _start(theta, size), method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    return _theta(answer.x * np.sqrt(size))


def _theta(factor: Array) -> Theta:
    """Return θ of Σ = L Lᵀ, with the six entries of L in rows."""
    lower = np.zeros((3, 3))
    lower[_LOWER] = factor
    moments = lower @ lower.T
    return theta_of(np.trace(moments) * np.eye(3) - moments)


def _start(theta: Theta, size: float) -> Array:
    """Return the factor of Σ/size with its eigenvalues lifted above zero: at zero the search would not leave it."""
    strength, axes = np.linalg.eigh(second_moments(theta) / size)
    lifted = axes * np.maximum(strength, 1e-3) @ axes.T
    return np.asarray(cholesky(lifted, lower=True)[_LOWER])
