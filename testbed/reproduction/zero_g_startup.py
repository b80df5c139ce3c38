"""What the prefilter's start does to an estimate from a record that starts in motion.

The filtered equation holds from zero state but for f(t) L(0), f(t) = exp(-t/γ)/γ, L(0) the total angular momentum at
the first sample: 2 to 4 s of record at γ = 0.8 s never see it die out. Estimating L(0) is exact; leaving it out is what
a filter started from zero does; taking it from the first sample puts that sample's noise on the whole record.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from testbed.arrays import Regressor
from testbed.dynamics.inertia import momentum_regressor
from testbed.estimation.actuation import actuation
from testbed.estimation.estimate import Estimate, EstimationSettings, estimate_of
from testbed.estimation.momentum_equation import mean_momentum
from testbed.estimation.motion import drive_of, simulate
from testbed.estimation.noise_image import filtered_noise
from testbed.estimation.prefilter import FilteredEquation, filtered_equation
from testbed.estimation.regression import covariance_of, noise_gain, residual_sigma, solution_of
from testbed.estimation.telemetry import Telemetry, covered_part

Treatment = Callable[[FilteredEquation, Telemetry], FilteredEquation]
"""From the equation with its three start columns to one without."""


def from_zero(equation: FilteredEquation, _: Telemetry) -> FilteredEquation:
    """Assume a start at rest: the filter begins with zero state."""
    return replace(equation, regressor=equation.regressor[:, :6])


def from_first_sample(equation: FilteredEquation, telemetry: Telemetry) -> FilteredEquation:
    """Take L(0) = Γ(ω(0)) θ + h(0) from the first sample: the filter of the signals less their first values."""
    start = equation.regressor[:, 6:]
    known = actuation(telemetry, equation.time[:1])
    rate = equation.body_rate[0]
    momentum = known.cluster_momentum_B[0] + known.inertia_change_B[0] @ rate
    return replace(
        equation,
        regressor=equation.regressor[:, :6] + start @ momentum_regressor(rate),
        response=equation.response - start @ momentum,
    )


TREATMENTS: Mapping[str, Treatment] = {"iv_from_zero": from_zero, "iv_from_first_sample": from_first_sample}


def treated_estimates(telemetry: Telemetry, settings: EstimationSettings) -> Mapping[str, Estimate]:
    """Estimate as `instrumental_variable` with the nominal instrument does, but for the start, by treatment.

    The covariances know nothing of what a treatment gets wrong.

    Args:
        telemetry: one run without gaps, its initial momentum unknown.
        settings: nominal inertia and prefilter.
    """
    part, theta = covered_part(telemetry), settings.nominal_theta
    instrument_rate = simulate(drive_of(part), theta, mean_momentum(part, theta)).body_rate
    equation = filtered_equation(part, part.body_rate, settings.prefilter_time)
    instrument = filtered_equation(part, instrument_rate, settings.prefilter_time)
    return {
        name: _estimate(part, treatment(equation, part), treatment(instrument, part).regressor, settings)
        for name, treatment in TREATMENTS.items()
    }


def _estimate(
    telemetry: Telemetry, equation: FilteredEquation, instrument: Regressor, settings: EstimationSettings
) -> Estimate:
    solution = solution_of(equation.regressor, instrument, equation.response)
    noise = filtered_noise(telemetry, equation, solution, settings.prefilter_time)
    sigma = float(residual_sigma(solution))
    gain = noise_gain(solution, noise.image)
    return estimate_of(
        replace(telemetry, initial_momentum="zero"),  # no momentum among the parameters
        solution.parameters,
        covariance_of(gain, sigma**2 / noise.power),
        influence=-gain,
        time=equation.time,
        residual=solution.residual,
        unit="N·m",
        sigma=sigma,
        iterations=1,
    )
