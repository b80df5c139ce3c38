"""The residual's autocorrelation, and what prefilter and fit make of white gyro noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from testbed.assembly.platform import nominal_platform
from testbed.experiment.planning import plan_maneuver
from testbed.reproduction.whiteness import LAGS, autocorrelation, chi_square, expected_autocorrelation, whiteness
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario

SAMPLES = 81
MOVING = np.kron(np.eye(SAMPLES, SAMPLES + 1, k=1) + 0.5 * np.eye(SAMPLES, SAMPLES + 1), np.eye(3))
"""From white noise to e_k + 0.5 e_{k-1}."""


def moving(flights: int, seed: int) -> list[np.ndarray]:
    noise = np.random.default_rng(seed).standard_normal((flights, MOVING.shape[1]))
    return [(MOVING @ one).reshape(-1, 3) for one in noise]


def test_autocorrelation_of_a_moving_average_is_the_textbooks():
    """e_k + b e_{k-1}: b / (1 + b²) at lag 1, nothing beyond; 3 · 800 samples leave 1/√2,400 = 0.020."""
    noise = np.random.default_rng(1).standard_normal((801, 3))
    measured = autocorrelation([noise[1:] + 0.5 * noise[:-1]], 4)
    np.testing.assert_allclose(measured, [0.4, 0.0, 0.0, 0.0], atol=4 * 0.020)


def test_what_a_covariance_leads_to_expect_is_measured():
    """A mean taken off 81 samples leaves -1/81 and more of a white series; 20,000 of them tell 1e-3."""
    measured = autocorrelation(moving(20_000, 2), 3)
    np.testing.assert_allclose(measured, expected_autocorrelation(MOVING @ MOVING.T, 3), atol=2e-3)


def test_chi_square_is_one_where_the_covariance_is_right_and_large_where_it_is_not():
    found = [chi_square(moving(25, seed), MOVING @ MOVING.T, LAGS) for seed in range(200)]
    assert np.mean(found) == pytest.approx(LAGS, abs=4 * np.sqrt(2 * LAGS / 200))
    assert np.mean(np.array(found) > chi2.isf(0.05, LAGS)) < 0.05 + 4 * np.sqrt(0.05 * 0.95 / 200)
    assert chi_square(moving(25, 1), np.eye(len(MOVING)), LAGS) > 100.0


def test_the_residual_is_what_the_prefilter_makes_of_a_white_gyro_and_not_white():
    scenario = read_scenario(shipped_scenario("basic"))
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    curve = whiteness(scenario, maneuver, 10, 1)
    assert (curve.predicted_chi_square < curve.largest_chi_square).all()
    # Behind a prefilter of 0.05 s the derivative is still there: sF of white noise at 16 Hz, and no fit hides it.
    assert curve.white_chi_square[0] > 10 * curve.largest_chi_square
    assert curve.autocorrelation[0, 0] < -5 * curve.white_band
    paper = curve.time_constant.tolist().index(0.8)
    assert curve.white_chi_square[paper] < 0.2 * curve.white_chi_square[0]
