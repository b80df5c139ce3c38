"""What gyro noise leaves in the paper's IV estimate of a maneuver: scatter to first order, bias to second, in 2 ms.

With the reference as instrument and nothing wrong but the gyro's noise e, the filtered equation (22) gives

    θ̂ - θ = (I + N)⁻¹ u ≈ u - N u,   N = (ZᵀZ)⁻¹ Zᵀ δΨ,   u = (ZᵀZ)⁻¹ Zᵀ (δY - δΨ θ),

both linear in e. The covariance is E[u uᵀ]; the mean is -E[N u], which does not vanish: the paper's IV is consistent,
but at 80 samples it estimates the moments 0.3 to 0.8 % too large from the basic profile.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Regressor, Theta, Vectors3
from testbed.dynamics.inertia import inertia_of
from testbed.maneuver.information import (
    FIRST_FACTOR,
    SECOND_FACTOR,
    SampledFilter,
    filtered,
    filtered_regressor,
    regressor_features,
)


class Scatter(NamedTuple):
    """Of an IV estimate, each of shape (6,), kg·m².

    Attributes:
        std: standard deviation.
        bias: mean error.
    """

    std: Theta
    bias: Theta

    def bias_in_standard_errors(self, runs: int) -> Array:
        """Return by how many standard errors the mean of many runs is off, shape (6,)."""
        return self.bias / self.std * np.sqrt(runs)


class NoiseMap:
    """The linear maps from gyro noise to the filtered equation, which depend on prefilter and sample rate alone."""

    def __init__(self, sampling: SampledFilter) -> None:
        """Build the maps of a prefilter.

        Args:
            sampling: prefilter and grids.
        """
        time = sampling.fine_time[sampling.samples]
        self.sampling = sampling
        self._lag = filtered(sampling, np.eye(len(sampling.fine_time)))  # fine grid to samples
        self._finer = np.asarray(CubicSpline(time, np.eye(len(time)))(sampling.fine_time))  # samples to fine grid
        self._slope = (np.eye(len(time)) - self._lag @ self._finer) / sampling.time_constant  # s F

    def scatter(self, body_rate: Vectors3, theta: Theta, noise: float) -> Scatter:
        """Return scatter and bias of the IV estimate of a platform without total momentum.

        Args:
            body_rate: ω on the fine grid, shape (M, 3), rad/s, body axes.
            theta: true inertia parameters, kg·m².
            noise: of the gyro, rad/s per sample.

        Source: paper eqs. (7), (18), (22).
        """
        instrument = filtered_regressor(self.sampling, body_rate)
        weight = (instrument @ np.linalg.inv(instrument.T @ instrument)).reshape(-1, 3, 6)  # Z (ZᵀZ)⁻¹
        regressor = self._regressor_noise(weight, body_rate)
        error = self._response_noise(weight, body_rate @ inertia_of(theta)) - regressor @ theta
        return Scatter(
            std=noise * np.sqrt(np.einsum("mbq,mbq->q", error, error)),
            bias=-(noise**2) * np.einsum("mbqp,mbp->q", regressor, error),
        )

    def _regressor_noise(self, weight: Regressor, body_rate: Vectors3) -> Array:
        """Return N of unit noise at sample m about axis b, shape (N, 3, 6, 6)."""
        seen = np.einsum("niq,ipf->nqpf", weight, regressor_features(), optimize=True)
        noise = np.einsum("nqpb,nm->mbqp", seen[..., :3], self._slope, optimize=True)
        products = np.tensordot(self._lag.T, seen[..., 3:], 1)
        for feature, (first, second) in enumerate(zip(FIRST_FACTOR, SECOND_FACTOR, strict=True)):
            noise[:, second] += np.tensordot((self._finer * body_rate[:, [first]]).T, products[..., feature], 1)
            noise[:, first] += np.tensordot((self._finer * body_rate[:, [second]]).T, products[..., feature], 1)
        return noise

    def _response_noise(self, weight: Regressor, momentum_B: Vectors3) -> Array:
        """Return (ZᵀZ)⁻¹ Zᵀ F[e × J ω], from -ω × h with h = -J ω, shape (N, 3, 6)."""
        lagged = np.tensordot(self._lag.T, weight, 1)
        turned = np.cross(np.eye(3)[:, None, :], momentum_B[None])
        return np.asarray(np.einsum("jm,bji,jiq->mbq", self._finer, turned, lagged, optimize=True))
