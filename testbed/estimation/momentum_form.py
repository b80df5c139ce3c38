"""Instrumental variable in momentum form: conservation of momentum at the samples, with the gyro's own white noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Array, Matrices3, Theta, Vectors3
from testbed.dynamics.inertia import inertia_of, symmetric_inverse
from testbed.estimation.estimate import Estimate, EstimationSettings, estimates_of
from testbed.estimation.identifiability import inertia_size, require_identifiable
from testbed.estimation.instrument import refined
from testbed.estimation.momentum_equation import (
    MomentumEquation,
    measured_equation,
    momentum_equation,
    unknown_columns,
)
from testbed.estimation.motion import drive_of
from testbed.estimation.noise_image import attitude_noise, pendulum_of
from testbed.estimation.preparation import identifiable_part
from testbed.estimation.regression import Solution, covariance_of, noise_gain, residual_sigma, rows_of, solution_of
from testbed.estimation.stated_noise import influence_of_white, white_variance, whitened
from testbed.estimation.telemetry import Telemetry


def momentum_form(telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
    """Estimate the inertia from one run, as `momentum_forms`."""
    (estimate,) = momentum_forms(telemetry, settings)
    return estimate


def momentum_forms(telemetry: Telemetry, settings: EstimationSettings) -> list[Estimate]:
    """Estimate the inertia from Γ(ω) θ - Rᵀ H₀ = -h - (J(d) - J(0)) ω with an instrument.

    Each sample's rows are scaled by J(d)⁻¹, which makes their noise the gyro's, white and equal on all axes: the
    weight (σ² J Jᵀ)⁻¹. With zero momentum the answer reaches the Cramér-Rao bound; with a momentum, the attitude R is
    the integral of the noisy gyro, whose share of the noise is in the covariance but not in the weight.

    Args:
        telemetry: one run, or flights side by side.
        settings: the instrument.

    Raises:
        InputError: too few samples, or no reference.
        UnidentifiableError: the motion or the instrument leaves directions of the inertia open.

    Source: paper eqs. (6), (18), (19), on the integral of eq. (1).
    """
    part = identifiable_part(telemetry, settings)
    equation = measured_equation(part)

    def solve(body_rate: Vectors3, theta: Theta) -> Solution:
        scale = _inertia_inverse(part, theta)
        instrument = _rows(part, scale, momentum_equation(part, body_rate))
        require_identifiable(instrument, 0.0, inertia_size(settings.nominal_theta), body_rate)
        response = np.matvec(scale, equation.response)
        return solution_of(_rows(part, scale, equation), instrument, response.reshape(*response.shape[:-2], -1))

    solution, iterations = refined(part, settings, solve)
    solution = replace(solution, residual=whitened(part, solution.residual[..., None])[..., 0])
    sigma = residual_sigma(solution)
    gain = noise_gain(solution, _noise_image(part, equation, solution))
    return estimates_of(
        part,
        solution.parameters,
        covariance_of(influence_of_white(part, gain), white_variance(part, sigma**2)),  # eq. (19)
        influence=-gain,
        residual=-solution.residual,  # Ψθ - Y is the measured rate minus the predicted one
        sigma=sigma,
        iterations=iterations,
    )


def _inertia_inverse(telemetry: Telemetry, theta: Theta) -> Matrices3:
    """Return J(d)⁻¹ at the gyro's times, shape (..., N, 3, 3), 1/(kg·m²)."""
    change_B = drive_of(telemetry).samples.inertia_change_B
    return symmetric_inverse(inertia_of(theta)[..., None, :, :] + change_B)


def _rows(telemetry: Telemetry, scale: Matrices3, equation: MomentumEquation) -> Array:
    """Return the scaled regressor's rows, shape (..., 3N, P)."""
    return rows_of(np.asarray(scale @ unknown_columns(telemetry, equation.regressor)))


def _noise_image(telemetry: Telemetry, equation: MomentumEquation, solution: Solution) -> Array:
    """Return MᵀZ of the scaled equation's noise, shape (..., 3N, P): Z itself without momentum."""
    pendulum = pendulum_of(telemetry, solution, telemetry.gyro_time)
    if telemetry.initial_momentum == "zero" and pendulum is None:
        return solution.instrument
    scale = _inertia_inverse(telemetry, solution.parameters[..., :6])
    if pendulum is None and telemetry.applied_torque is None:
        momentum_B = np.matvec(equation.matrix_NB.mT, solution.parameters[..., None, 6:9])
    else:
        momentum_B = _whole_momentum(telemetry, solution.parameters[..., :6])
    rows = solution.instrument.reshape(*scale.shape[:-1], -1)
    image = attitude_noise(rows, scale, telemetry.gyro_time, equation.matrix_NB, momentum_B, pendulum)
    return image.reshape(solution.instrument.shape)


def _whole_momentum(telemetry: Telemetry, theta: Theta) -> Vectors3:
    """Return L = J(d) ω + h as measured, shape (..., N, 3), N·m·s, body axes: torques and gravity change it."""
    known = drive_of(telemetry).samples
    turning = np.matvec(inertia_of(theta)[..., None, :, :] + known.inertia_change_B, telemetry.body_rate)
    return np.asarray(turning + known.cluster_momentum_B)
