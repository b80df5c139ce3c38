"""The IV's bias to second order in the noise, against estimates from drawn noise."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.assembly.platform import nominal_platform
from testbed.estimation.noise_response import finite_sample_bias, residual_colour
from testbed.estimation.prefilter import filtered_equation
from testbed.estimation.regression import solution_of
from testbed.experiment.planning import plan_maneuver
from testbed.reproduction.noise_free import NoiseFreeFlight
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario

NOISE, PREFILTER, DRAWS = 0.025, 0.8, 400


@pytest.fixture(scope="module")
def flight():
    scenario = read_scenario(shipped_scenario("basic"))
    return NoiseFreeFlight(scenario, plan_maneuver(scenario, nominal_platform(scenario)).maneuver)


@pytest.fixture(scope="module")
def response(flight):
    return flight.response(PREFILTER)


def solved(flight, noise):
    """Estimate from the quiet flight with noise added to its gyro, as the paper's estimator does."""
    rate = flight.telemetry.body_rate + noise.reshape(-1, 3)
    equation = filtered_equation(flight.telemetry, rate, PREFILTER)
    return solution_of(equation.regressor, flight.instrument(PREFILTER), equation.response)


def test_without_noise_the_equation_holds_at_the_truth(flight):
    """To 1 % of the bias: splines between samples at 16 Hz leave 2e-7 kg·m²."""
    quiet = solved(flight, np.zeros(flight.telemetry.body_rate.size))
    assert np.abs(quiet.parameters - flight.true_theta).max() < 1e-6


def test_the_bias_is_that_of_many_estimates(flight, response):
    """The first order, whose mean is zero, is taken off each: what is left scatters little about the bias."""
    instrument = flight.instrument(PREFILTER)
    gain = np.linalg.solve(instrument.T @ response.regressor, instrument.T) @ response.error_slope
    rng = np.random.default_rng(11)
    left = []
    for _ in range(DRAWS):
        noise = NOISE * rng.standard_normal(gain.shape[1])
        pair = [solved(flight, sign * noise).parameters - flight.true_theta for sign in (1.0, -1.0)]
        left.append(np.mean(pair, axis=0))  # of opposite noise: the first order, and all odd ones, cancel
    bias = finite_sample_bias(response, instrument, NOISE)
    error = np.std(left, axis=0, ddof=1) / np.sqrt(DRAWS)
    assert np.abs((np.mean(left, axis=0) - bias) / error).max() < 4.0  # six parameters: once in 2,600
    assert (bias[:3] > 6 * error[:3]).all()  # it is there to be seen
    assert bias[:3] == pytest.approx(1e-4, rel=0.3)  # 0.4 % of the moments


def test_the_bias_grows_with_the_noises_square(flight, response):
    instrument = flight.instrument(PREFILTER)
    one, two = (finite_sample_bias(response, instrument, noise) for noise in (NOISE, 2 * NOISE))
    np.testing.assert_allclose(two, 4.0 * one)


def test_the_residual_has_the_predicted_colour(flight, response):
    """To first order in the noise; 1e-3 of the paper's leaves 1e-3 of what is beyond it."""
    noise = 1e-3 * NOISE * np.random.default_rng(12).standard_normal(response.error_slope.shape[1])
    predicted = residual_colour(response, flight.instrument(PREFILTER)) @ noise
    quiet = solved(flight, np.zeros_like(noise)).residual
    np.testing.assert_allclose(solved(flight, noise).residual - quiet, predicted, atol=2e-3 * np.abs(predicted).max())
