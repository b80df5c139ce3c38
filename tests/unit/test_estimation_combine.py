"""Eq. (33): runs averaged by their covariance."""

from dataclasses import replace

import numpy as np

from support.synthetic_telemetry import (
    NOMINAL_THETA,
    TRUE_THETA,
    exact_telemetry,
    noisy,
    nominal_flight,
    sample_times,
)
from testbed.estimation.combine import combined
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.output_error import output_error

SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
TIMES = sample_times(16.0)
EXACT = exact_telemetry(nominal_flight(), TIMES, TIMES, 0.001658)
WHOLE = output_error(noisy(EXACT, 0, 1e-4), SETTINGS)


def test_one_run_stays_itself():
    one = combined([WHOLE])
    np.testing.assert_allclose(one.theta, WHOLE.theta, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(one.std, WHOLE.std, rtol=1e-9)


def test_four_alike_have_half_the_deviation():
    np.testing.assert_allclose(combined([WHOLE] * 4).std, WHOLE.std / 2.0, rtol=1e-9)


def test_a_run_that_says_little_weighs_little():
    vague = replace(WHOLE, theta=np.zeros(6), covariance=1e6 * WHOLE.covariance)
    np.testing.assert_allclose(combined([WHOLE, vague]).theta, WHOLE.theta, rtol=1e-5, atol=1e-8)


def test_diagonal_covariances_give_the_textbook_average():
    left = replace(WHOLE, theta=np.full(6, 1.0), covariance=np.eye(6))
    right = replace(WHOLE, theta=np.full(6, 4.0), covariance=0.5 * np.eye(6))
    both = combined([left, right])
    np.testing.assert_allclose(both.theta, 3.0)  # (1 + 2 * 4) / 3
    np.testing.assert_allclose(both.covariance, np.eye(6) / 3.0, atol=1e-15)


def test_truncated_runs_together_beat_each_of_them():
    pieces = [(0.0, 2.5), (1.0, 4.0), (2.0, 5.0)]
    flight = nominal_flight()
    runs = [
        exact_telemetry(flight, sample_times(16.0, *piece), sample_times(16.0, *piece), 0.001658) for piece in pieces
    ]
    estimates = [output_error(noisy(run, seed, 1e-4), SETTINGS) for seed, run in enumerate(runs)]
    together = combined(estimates)
    assert all((together.std < estimate.std).all() for estimate in estimates)
    assert (np.abs(together.theta - TRUE_THETA) < 4.0 * together.std).all()
