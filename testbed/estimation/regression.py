"""Linear regression with an instrument, and the covariance that known noise leaves in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Regressor, Response


@dataclass(frozen=True, kw_only=True)
class Solution:
    """The solution of Ψ θ' = Y + noise with an instrument Z; of flights side by side on leading axes.

    Attributes:
        parameters: θ', shape (..., P): the inertia, then the unknown momenta.
        instrument: Z, shape (..., 3N, P).
        normal: ZᵀΨ, shape (..., P, P).
        residual: Y - Ψ θ', shape (..., 3N).
    """

    parameters: Array
    instrument: Regressor
    normal: Array
    residual: Response


def solution_of(regressor: Regressor, instrument: Regressor, response: Response) -> Solution:
    """Return θ' = (ZᵀΨ)⁻¹ ZᵀY; least squares where the instrument is the regressor.

    Args:
        regressor: Ψ, shape (..., 3N, P).
        instrument: Z, shape (..., 3N, P), of full rank.
        response: Y, shape (..., 3N).

    Source: paper eqs. (14), (18).
    """
    across = instrument.mT
    normal = np.asarray(across @ regressor)
    parameters = np.asarray(np.linalg.solve(normal, across @ response[..., None]), dtype=np.float64)  # eq. (18)
    return Solution(
        parameters=parameters[..., 0],
        instrument=instrument,
        normal=normal,
        residual=response - (regressor @ parameters)[..., 0],
    )


def noise_gain(solution: Solution, noise_image: Array) -> Array:
    """Return (ZᵀΨ)⁻¹ ZᵀM, shape (..., P, 3N): by how much noise e, which enters the equation as M e, moves θ' down.

    Args:
        solution: of the regression.
        noise_image: MᵀZ, shape (..., 3N, P); Z itself where the equation's own noise is white.
    """
    return np.asarray(np.linalg.solve(solution.normal, noise_image.mT))


def covariance_of(gain: Array, variance: Array | float) -> Array:
    """Return σ² (ZᵀΨ)⁻¹ ZᵀM MᵀZ (ΨᵀZ)⁻¹, shape (..., P, P), for noise M e with e white.

    Args:
        gain: as `noise_gain`.
        variance: σ², of e, shape (...).

    Source: paper eq. (19), which has M = I.
    """
    return np.asarray(np.asarray(variance)[..., None, None] * gain @ gain.mT)


def residual_sigma(solution: Solution) -> Array:
    """Return the residual's standard deviation, shape (...), the parameters' degrees of freedom taken off."""
    freedom = solution.residual.shape[-1] - solution.parameters.shape[-1]
    return np.asarray(np.sqrt(np.vecdot(solution.residual, solution.residual) / freedom))


def rows_of(columns: Array) -> Regressor:
    """Return the columns of N vectors, shape (..., N, 3, P), as rows grouped by sample, shape (..., 3N, P)."""
    return columns.reshape(*columns.shape[:-3], -1, columns.shape[-1])
