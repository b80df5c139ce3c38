"""What each gyro sample's noise does to the filtered equation: the residual's colour, and the IV's finite-sample bias.

The equation is of second degree in the rates, so that central differences of it are exact derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Regressor, Vectors3
from testbed.estimation.prefilter import filtered_equation
from testbed.estimation.telemetry import Telemetry


@dataclass(frozen=True, kw_only=True)
class NoiseResponse:
    """Derivatives of the filtered equation Ψ θ' = Y by the noise e of every gyro sample, at a motion without noise.

    Attributes:
        regressor: Ψ at that motion, shape (3N, P).
        regressor_slope: ∂Ψ/∂e, shape (3N, P, 3N), the last index that of the noise.
        error_slope: M = ∂(Y - Ψ θ')/∂e, shape (3N, 3N).
    """

    regressor: Regressor
    regressor_slope: Array
    error_slope: Array


def noise_response(
    telemetry: Telemetry, body_rate: Vectors3, parameters: Array, prefilter_time: float
) -> NoiseResponse:
    """Return what noise on a motion does to the filtered equation.

    Args:
        telemetry: the actuators' part, the times, and whether the initial momentum is known.
        body_rate: the true ω at the gyro's times, shape (N, 3), rad/s.
        parameters: the true θ', shape (P,): the inertia, then the unknown momenta.
        prefilter_time: γ, s.
    """
    regressors, errors = [], []
    for index in range(body_rate.size):
        step = np.zeros(body_rate.size)
        step[index] = 1.0
        more, less = (
            filtered_equation(telemetry, body_rate + sign * step.reshape(-1, 3), prefilter_time) for sign in (1.0, -1.0)
        )
        slope = (more.regressor - less.regressor) / 2.0
        regressors.append(slope)
        errors.append((more.response - less.response) / 2.0 - slope @ parameters)
    return NoiseResponse(
        regressor=filtered_equation(telemetry, body_rate, prefilter_time).regressor,
        regressor_slope=np.stack(regressors, axis=2),
        error_slope=np.stack(errors, axis=1),
    )


def finite_sample_bias(response: NoiseResponse, instrument: Regressor, noise: float) -> Array:
    """Return the IV's bias to second order in the gyro's noise, shape (P,): consistent is not unbiased.

    θ̂ - θ' = (Zᵀ(Ψ + δΨ))⁻¹ Zᵀ(M e + ...) has the mean -σ² Σₖ G (∂Ψ/∂eₖ) G M uₖ, G = (ZᵀΨ)⁻¹ Zᵀ: the noise in the
    regressor is that of the equation. The quadratic part of the equation's own error has no mean, white noise being
    alike about all axes.

    Args:
        response: of the equation to the noise.
        instrument: Z, shape (3N, P), without noise.
        noise: σ, of the gyro, rad/s per sample.
    """
    gain = np.linalg.solve(instrument.T @ response.regressor, instrument.T)
    moved = np.einsum("pn,nqk->kpq", gain, response.regressor_slope, optimize=True)
    return np.asarray(-(noise**2) * np.einsum("kpq,qk->p", moved, gain @ response.error_slope))


def residual_colour(response: NoiseResponse, instrument: Regressor) -> Array:
    """Return (I - ΨG) M, shape (3N, 3N), with which white noise becomes the IV's residual.

    Args:
        response: of the equation to the noise.
        instrument: Z, shape (3N, P).
    """
    return np.asarray(residual_maker(response, instrument) @ response.error_slope)


def residual_maker(response: NoiseResponse, instrument: Regressor) -> Array:
    """Return I - Ψ (ZᵀΨ)⁻¹ Zᵀ, shape (3N, 3N): from the equation's error to the residual of an estimate.

    Args:
        response: with the regressor.
        instrument: Z, shape (3N, P).
    """
    gain = np.linalg.solve(instrument.T @ response.regressor, instrument.T)
    return np.asarray(np.eye(len(instrument)) - response.regressor @ gain)
