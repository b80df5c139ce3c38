"""The filtered regressor Ψ_f of a motion and what it says about the precision of the inertia.

Ψ_f is linear in nine features of the motion at each gyro sample: the three filtered accelerations s F ω and the six
filtered products F ω_a ω_b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from testbed.arrays import Array, Covariance, Regressor, Series, Vectors3
from testbed.dynamics.inertia import cross_matrix, momentum_regressor
from testbed.maneuver.maneuver import Maneuver

FIRST_FACTOR, SECOND_FACTOR = (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)
"""Axes of the six products ω_a ω_b."""
SUBDIVISIONS = 2
"""Fine steps in one sample period: parabolas through them are off by less than 1e-4 of the determinant of Ψ_fᵀΨ_f."""


@dataclass(frozen=True, kw_only=True)
class SampledFilter:
    """The prefilter F(s) = 1/(γs + 1) from zero state, from a fine grid to the gyro's samples.

    What a period's fine samples add to F x at its end is their sum with the weights; at every later sample `decay` of
    it is left. Kept as numbers, not as matrices, whose size would grow with the square of the samples.

    Attributes:
        fine_time: shape (M,), s.
        samples: where the N gyro samples lie on the fine grid.
        time_constant: γ, s.
        weights: of the fine samples of a period, both ends included.
        decay: exp(-Δt/γ) of a sample period Δt.
    """

    fine_time: Series
    samples: slice
    time_constant: float
    weights: Array
    decay: float


@dataclass(frozen=True, kw_only=True)
class Information:
    """Figures of Ψ_fᵀΨ_f, in the paper's units (ψ of a motion in rad/s, no noise).

    Attributes:
        min_eigenvalue: E-optimality makes it large.
        trace_inverse: A-optimality makes it small.
        determinant: D-optimality makes it large.
        condition_number: of Ψ_fᵀΨ_f.
    """

    min_eigenvalue: float
    trace_inverse: float
    determinant: float
    condition_number: float

    @property
    def regressor_condition_number(self) -> float:
        """Condition number of Ψ_f itself, which is what the paper's Table 1 lists."""
        return float(np.sqrt(self.condition_number))


def sampled_filter(duration: float, sample_rate: float, time_constant: float) -> SampledFilter:
    """Return the prefilter for samples at k / sample_rate, k = 0, 1, ... up to the duration.

    Args:
        duration: s.
        sample_rate: of the gyro, Hz.
        time_constant: γ, s.

    Source: paper eqs. (22), (32).
    """
    periods = int(np.floor(duration * sample_rate + 1e-9))  # 1e-9: rounding must not lose the last sample
    period = 1.0 / sample_rate
    return SampledFilter(
        fine_time=np.arange(periods * SUBDIVISIONS + 1) * period / SUBDIVISIONS,
        samples=slice(None, None, SUBDIVISIONS),
        time_constant=time_constant,
        weights=_period_weights(period, time_constant),
        decay=float(np.exp(-period / time_constant)),
    )


def filtered(sampling: SampledFilter, signal: Array) -> Array:
    """Return F x at the gyro's samples, shape (N, ...), of x on the fine grid, shape (M, ...).

    Source: paper eqs. (22), (32).
    """
    periods = len(signal) // SUBDIVISIONS
    last = periods * SUBDIVISIONS
    added = np.zeros((periods + 1, *signal.shape[1:]), dtype=signal.dtype)
    added[1:] = sum(
        weight * signal[place : last + place : SUBDIVISIONS] for place, weight in enumerate(sampling.weights.tolist())
    )
    return np.asarray(scipy.signal.lfilter([1.0], [1.0, -sampling.decay], added, axis=0))


def _period_weights(period: float, time_constant: float) -> Array:
    """Weights of one period's fine samples in F x at its end; exact for the polynomial through them."""
    nodes = np.linspace(0.0, 1.0, SUBDIVISIONS + 1)
    abscissas, gauss_weights = np.polynomial.legendre.leggauss(2 * SUBDIVISIONS)
    abscissas = (abscissas + 1.0) / 2.0
    kernel = np.exp((abscissas - 1.0) * period / time_constant) * period / time_constant
    moments = np.vander(abscissas, SUBDIVISIONS + 1).T @ (kernel * gauss_weights / 2.0)
    return np.asarray(np.linalg.solve(np.vander(nodes).T, moments))


def regressor_features() -> Array:
    """Return T, shape (3, 6, 9), so that ψ_f = T @ features, from Γ(ω̇) + ω× Γ(ω). Source: paper eqs. (5), (7)."""
    axes = np.eye(3)
    gamma, cross = momentum_regressor(axes), cross_matrix(axes)
    product = np.einsum("aij,bjk->abik", cross, gamma)
    product += np.swapaxes(product, 0, 1) * (1.0 - axes)[..., None, None]  # ω_a ω_b stands for both orders
    bilinear = product[list(FIRST_FACTOR), list(SECOND_FACTOR)]
    return np.moveaxis(np.concatenate([gamma, bilinear]), 0, -1)


def filtered_regressor(sampling: SampledFilter, body_rate: Vectors3) -> Regressor:
    """Return Ψ_f at the gyro's samples.

    Args:
        sampling: prefilter and grids.
        body_rate: ω on the fine grid, shape (M, 3), rad/s, body axes.

    Source: paper eqs. (15), (22).
    """
    swing = body_rate - body_rate[0]
    products = body_rate[:, list(FIRST_FACTOR)] * body_rate[:, list(SECOND_FACTOR)]
    lagged = filtered(sampling, np.hstack([swing, products]))
    slope = (swing[sampling.samples] - lagged[:, :3]) / sampling.time_constant  # s F ω, nothing differentiated
    features = np.hstack([slope, lagged[:, 3:]])
    return np.asarray(np.einsum("ipf,nf->nip", regressor_features(), features).reshape(-1, 6))


def information_of(matrix: Covariance) -> Information:
    """Return the figures of an information matrix Ψ_fᵀΨ_f, shape (6, 6). Source: paper section 4.1."""
    eigenvalues = np.linalg.eigvalsh(matrix)
    return Information(
        min_eigenvalue=float(eigenvalues[0]),
        trace_inverse=float(np.sum(1.0 / eigenvalues)),
        determinant=float(np.prod(eigenvalues)),
        condition_number=float(eigenvalues[-1] / eigenvalues[0]),
    )


def maneuver_information(maneuver: Maneuver, sample_rate: float, time_constant: float) -> Information:
    """Return the information in a maneuver that is followed exactly.

    Args:
        maneuver: the reference.
        sample_rate: of the gyro, Hz.
        time_constant: γ of the prefilter, s.
    """
    sampling = sampled_filter(maneuver.duration, sample_rate, time_constant)
    regressor = filtered_regressor(sampling, maneuver.reference(sampling.fine_time).body_rate)
    return information_of(regressor.T @ regressor)
