"""Least squares on the prefiltered equation: simple, and biased where gyro noise is not small."""

from __future__ import annotations

from testbed.estimation.estimate import Estimate, EstimationSettings, estimate_of
from testbed.estimation.noise_image import filtered_noise
from testbed.estimation.prefilter import filtered_equation
from testbed.estimation.preparation import identifiable_part
from testbed.estimation.regression import covariance_of, noise_gain, residual_sigma, solution_of
from testbed.estimation.stated_noise import influence_of_white, wanders
from testbed.estimation.telemetry import Telemetry


def least_squares(telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
    """Estimate the inertia by θ̂ = (ΨᵀΨ)⁻¹ ΨᵀY, with covariance σ² (ΨᵀΨ)⁻¹.

    The regressor carries the gyro's noise, which pulls the moments of inertia down: by 1e-3 kg·m² at 0.025 rad/s, by
    nothing that shows at 0.0017 rad/s. The covariance does not know of that, and of the noise's colour only where a
    bias is stated to wander.

    Args:
        telemetry: one run.
        settings: the prefilter's time; the instrument does not matter here.

    Raises:
        InputError: too few samples.
        UnidentifiableError: the motion leaves directions of the inertia open.

    Source: paper eqs. (14), (15), (16), (22).
    """
    part = identifiable_part(telemetry, settings)
    equation = filtered_equation(part, part.body_rate, settings.prefilter_time)
    solution = solution_of(equation.regressor, equation.regressor, equation.response)  # eq. (14)
    sigma = float(residual_sigma(solution))
    influence = -noise_gain(solution, filtered_noise(part, equation, solution, settings.prefilter_time).image)
    covariance = covariance_of(noise_gain(solution, solution.instrument), sigma**2)  # eq. (16)
    if wanders(part):
        covariance = covariance_of(influence_of_white(part, influence, equation.time), part.gyro_noise**2)
    return estimate_of(
        part,
        solution.parameters,
        covariance,
        influence=influence,
        time=equation.time,
        residual=solution.residual,
        unit="N·m",
        sigma=sigma,
        iterations=1,
    )
