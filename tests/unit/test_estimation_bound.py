"""The Cramér-Rao bound against a closed form, and what an unknown momentum adds to it."""

from dataclasses import replace

import numpy as np

from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.cmg.cluster import inertia_change
from testbed.dynamics.inertia import inertia_of, momentum_regressor
from testbed.estimation.bound import cramer_rao_bound

NOISE = 0.025
TIMES = sample_times(16.0)
FLIGHT = nominal_flight()
AT_REST = exact_telemetry(FLIGHT, TIMES, sample_times(1000.0), NOISE)


def std(covariance):
    return np.sqrt(np.diag(covariance))


def test_known_zero_momentum_has_a_closed_form():
    inertia = inertia_of(TRUE_THETA) + inertia_change(FLIGHT.cluster, FLIGHT.gimbals.angle(TIMES))
    rows = (np.linalg.inv(inertia) @ momentum_regressor(FLIGHT.body_rate(TIMES))).reshape(-1, 6)
    bound = cramer_rao_bound(replace(AT_REST, initial_momentum="zero"), TRUE_THETA, np.zeros(3))
    np.testing.assert_allclose(bound, NOISE**2 * np.linalg.inv(rows.T @ rows), rtol=1e-6, atol=1e-15)


def test_an_unknown_momentum_costs_a_few_percent_on_a_maneuver_from_rest_to_rest():
    known = std(cramer_rao_bound(replace(AT_REST, initial_momentum="zero"), TRUE_THETA, np.zeros(3)))
    unknown = std(cramer_rao_bound(AT_REST, TRUE_THETA, np.zeros(3)))
    inflation = unknown / known
    assert (inflation > 1.0).all()
    assert (inflation < 1.12).all()  # measured: 3 to 9 %


def test_measured_rates_do_not_matter_and_the_noise_scales_it():
    bound = cramer_rao_bound(AT_REST, TRUE_THETA, np.zeros(3))
    other = replace(AT_REST, body_rate=np.zeros_like(AT_REST.body_rate), gyro_noise=2.0 * NOISE)
    np.testing.assert_allclose(cramer_rao_bound(other, TRUE_THETA, np.zeros(3)), 4.0 * bound, rtol=1e-12)


def test_more_samples_lower_it():
    dense = exact_telemetry(FLIGHT, sample_times(64.0), sample_times(1000.0), NOISE)
    ratio = std(cramer_rao_bound(AT_REST, TRUE_THETA, np.zeros(3))) / std(
        cramer_rao_bound(dense, TRUE_THETA, np.zeros(3))
    )
    np.testing.assert_allclose(ratio, 2.0, rtol=0.02)  # the square root of four times the samples, but for the ends
