"""The variance of increments that nobody has measured, from what they do to a residual."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import exp, inf, isinf, log1p

import numpy as np
import scipy

from testbed.arrays import Array

_VARIANCES = (-12.0, 25.0)
"""Logarithms between which the variance of the increments is searched, in units of what the best-known direction shows:
at the first a torque adds 6e-6 of the noise's variance and less, at the second the residual is torque alone."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Increments:
    """Increments x ~ N(0, q) in a residual G x + e, e ~ N(0, 1), in coordinates in which GᵀG = diag(power) - A Aᵀ.

    Runs share few parameters: without them GᵀG is that of each run alone, and A what they take from all together.

    Attributes:
        power: shape (n,).
        slope: Gᵀ times the residual, shape (n,).
        across: A, shape (n, r); r = 0 where components are independent.
    """

    power: Array
    slope: Array
    across: Array

    @classmethod
    def independent(cls, power: Array, slope: Array) -> Increments:
        """Return components that do not act on each other."""
        return cls(power=power, slope=slope, across=np.zeros((len(power), 0)))

    def solved(self, variance: float) -> Array:
        """Return (1 + q GᵀG)⁻¹ Gᵀ times the residual, shape (n,)."""
        alone = self.slope / (1.0 + variance * self.power)
        weighted, core = self._core(variance)
        return np.asarray(alone + variance * weighted @ np.linalg.solve(core, self.across.T @ alone))

    def explained(self, variance: float) -> float:
        """Return by how much of χ² the increments explain the residual."""
        return variance * float(self.slope @ self.solved(variance))

    def widened(self, variance: float) -> float:
        """Return log det(1 + q GᵀG)."""
        _, core = self._core(variance)
        return float(np.log1p(variance * self.power).sum() + np.linalg.slogdet(core)[1])

    def count(self, variance: float) -> float:
        """Return how many components stand out of the noise, tr q GᵀG (1 + q GᵀG)⁻¹."""
        weighted, core = self._core(variance)
        alone = float((variance * self.power / (1.0 + variance * self.power)).sum())
        return alone - variance * float(np.trace(np.linalg.solve(core, weighted.T @ weighted)))

    def _core(self, variance: float) -> tuple[Array, Array]:
        """Return E⁻¹ A and 1 - q Aᵀ E⁻¹ A, E = 1 + q diag(power), of Woodbury's identity."""
        weighted = self.across / (1.0 + variance * self.power)[:, None]
        return weighted, np.eye(self.across.shape[1]) - variance * self.across.T @ weighted


def _scale(increments: Increments) -> float:
    """Return the variance with which the best-known component is as large as the noise."""
    return 1.0 / max(float(increments.power.max(initial=0.0)), np.finfo(float).tiny)


def likeliest_variance(increments: Increments, noise_freedom: float = inf) -> tuple[float, float]:
    """Return the likeliest variance of the increments, q̂ >= 0, and 2 (log L(q̂) - log L(0)).

    Args:
        increments: what they do to the residual.
        noise_freedom: degrees of freedom with which the noise is known; infinite where it is stated.
    """
    scale = _scale(increments)
    if isinf(noise_freedom):
        log_likelihood = partial(_of_known_noise, increments=increments)
    else:
        everything = scale * exp(_VARIANCES[1])
        log_likelihood = partial(
            _of_estimated_noise,
            increments=increments,
            whole=noise_freedom + increments.explained(everything),
            freedom=noise_freedom + increments.count(everything),
        )
    found = scipy.optimize.minimize_scalar(
        lambda exponent: -log_likelihood(scale * np.exp(exponent)), bounds=_VARIANCES, method="bounded"
    )
    variance = scale * float(np.exp(found.x))
    ratio = 2.0 * log_likelihood(variance)
    return (variance, ratio) if ratio > 0.0 else (0.0, 0.0)


def _of_known_noise(variance: float, increments: Increments) -> float:
    """Return log L(q) - log L(0)."""
    return 0.5 * (increments.explained(variance) - increments.widened(variance))


def _of_estimated_noise(variance: float, increments: Increments, whole: float, freedom: float) -> float:
    """Return the same of noise that is known with ν degrees of freedom only.

    All samples share a factor, ν over which is χ²(ν): what n components show is of Student's t distribution, and its
    sum of squares counts as (ν + n) log(1 + Σ y² / ν).

    Args:
        variance: q.
        increments: what they do to the residual.
        whole: ν + Σ y².
        freedom: ν + n.
    """
    share = log1p(-increments.explained(variance) / whole)
    return -0.5 * (freedom * share + increments.widened(variance))


_STEP = 0.1
"""Of log q, over which the curvature of the log-likelihood is taken: it is of order one over a step of one."""


def relative_error(increments: Increments, variance: float) -> float:
    """Return the standard error of log q at the likeliest variance, from the curvature there; infinite without any."""
    below, at, above = (_of_known_noise(variance * exp(step), increments) for step in (-_STEP, 0.0, _STEP))
    curvature = (2.0 * at - below - above) / _STEP**2
    return curvature**-0.5 if curvature > 0.0 else inf
