"""The prefilter against closed forms; products on the sample grid, and records that start in motion."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.estimation.lag import first_order_lag, impulse_power, transposed_lag
from testbed.estimation.prefilter import filtered_equation

GAMMA = 0.8
FLIGHT = nominal_flight(np.array([0.003, -0.004, 0.006]))
CUT = sample_times(16.0, 1.3, 4.2)
MIDDLE = exact_telemetry(FLIGHT, CUT, CUT)


def least_squares_error(telemetry, fine_step=1 / 256):
    equation = filtered_equation(telemetry, telemetry.body_rate, GAMMA, fine_step)
    solution = np.linalg.lstsq(equation.regressor, equation.response, rcond=None)[0]
    return np.abs(solution[:6] - TRUE_THETA).max()


@pytest.mark.parametrize("step", [0.1, 0.001])
def test_lag_of_a_ramp_is_exact_at_any_step(step):
    time = np.arange(0.0, 3.0, step)
    output = first_order_lag(time[:, None] + 2.0, step, GAMMA)[:, 0]
    exact = time - GAMMA + 2.0 + (GAMMA - 2.0) * np.exp(-time / GAMMA)
    np.testing.assert_allclose(output, exact, atol=1e-12)


def test_transposed_lag_is_the_transposed_matrix():
    matrix = first_order_lag(np.eye(9), 0.0625, GAMMA)
    np.testing.assert_allclose(transposed_lag(np.eye(9), 0.0625, GAMMA), matrix.T, atol=1e-15)


def test_impulse_power_is_that_of_the_response():
    impulse = np.zeros((2000, 1))
    impulse[1] = 1.0
    response = first_order_lag(impulse, 0.0625, GAMMA)[1:, 0]
    np.testing.assert_allclose(impulse_power(0.0625, GAMMA), [response[0], np.sum(response[1:] ** 2)], rtol=1e-12)


def test_products_are_filtered_on_a_fine_grid():
    assert least_squares_error(MIDDLE, fine_step=1 / 16) > 2e-6  # kg·m²: what filtering at 16 Hz leaves
    assert least_squares_error(MIDDLE) < 5e-8


def test_a_record_that_starts_in_motion_is_not_biased():
    assert np.abs(MIDDLE.body_rate[0]).max() > 0.2
    assert least_squares_error(MIDDLE) < 1e-6


def test_a_filter_started_from_rest_on_such_a_record_is():
    assert least_squares_error(replace(MIDDLE, initial_momentum="zero")) > 1e-3


def test_a_platform_turned_by_thrusters_has_the_same_start_up():
    flight = nominal_flight()
    exact = exact_telemetry(flight, CUT, CUT)
    fine = np.linspace(0.0, 5.0, 5001)
    rate = flight.body_rate(fine)
    inertia = np.diag(TRUE_THETA[:3])
    torque = np.gradient(rate, fine, axis=0, edge_order=2) @ inertia + np.cross(rate, rate @ inertia)
    at_samples = torque[np.searchsorted(fine, CUT - 1e-9)]
    thrusters = replace(exact, gimbals=None, applied_torque=at_samples)
    assert least_squares_error(thrusters) < 1e-5  # the torque is a difference quotient, sampled at 16 Hz
    assert least_squares_error(replace(thrusters, initial_momentum="zero")) > 1e-3


def test_a_gap_starts_the_filter_anew():
    keep = np.delete(np.arange(len(CUT)), range(20, 28))
    gappy = replace(MIDDLE, gyro_time=CUT[keep], body_rate=MIDDLE.body_rate[keep])
    equation = filtered_equation(gappy, gappy.body_rate, GAMMA)
    assert equation.breaks == (20,)
    assert equation.regressor.shape == (3 * len(keep), 6 + 3 + 3)
    assert least_squares_error(gappy) < 1e-6
