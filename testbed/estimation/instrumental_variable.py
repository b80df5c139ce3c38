"""Instrumental variable on the prefiltered equation: the paper's estimator, consistent whatever the gyro's noise."""

from __future__ import annotations

from testbed.arrays import Theta, Vectors3
from testbed.estimation.estimate import Estimate, EstimationSettings, estimate_of
from testbed.estimation.identifiability import inertia_size, require_identifiable
from testbed.estimation.instrument import refined
from testbed.estimation.noise_image import filtered_noise
from testbed.estimation.prefilter import filtered_equation
from testbed.estimation.preparation import identifiable_part
from testbed.estimation.regression import Solution, covariance_of, noise_gain, residual_sigma, solution_of
from testbed.estimation.stated_noise import influence_of_white, white_variance
from testbed.estimation.telemetry import Telemetry


def instrumental_variable(telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
    """Estimate the inertia by θ̂ = (ZᵀΨ)⁻¹ ZᵀY, Ψ and Z filtered by F(s).

    The covariance is eq. (19) with the noise's colour in it: behind the prefilter the noise lacks low frequencies, and
    eq. (19) as it stands gives bands 10 to 40 % too wide. Its scale is the residual's, a torque, not the gyro's.

    Args:
        telemetry: one run.
        settings: the prefilter's time and the instrument. In closed loop, where noise moves the platform, take the
            reference: what is simulated from measured momentum carries earlier noise, and so does the filter.

    Raises:
        InputError: too few samples, or no reference.
        UnidentifiableError: the motion or the instrument leaves directions of the inertia open.

    Source: paper eqs. (18), (19), (20), (22).
    """
    part = identifiable_part(telemetry, settings)
    filter_time = settings.prefilter_time
    equation = filtered_equation(part, part.body_rate, filter_time)

    def solve(body_rate: Vectors3, _: Theta) -> Solution:
        instrument = filtered_equation(part, body_rate, filter_time).regressor
        require_identifiable(instrument, 0.0, inertia_size(settings.nominal_theta), body_rate)
        return solution_of(equation.regressor, instrument, equation.response)

    solution, iterations = refined(part, settings, solve)
    sigma = float(residual_sigma(solution))
    noise = filtered_noise(part, equation, solution, filter_time)
    gain = noise_gain(solution, noise.image)
    variance = white_variance(part, sigma**2 / noise.power)
    return estimate_of(
        part,
        solution.parameters,
        covariance_of(influence_of_white(part, gain, equation.time), variance),  # eq. (19)
        influence=-gain,
        time=equation.time,
        residual=solution.residual,
        unit="N·m",
        sigma=sigma,
        iterations=iterations,
    )
