"""The noise that an instrument sees, against the equations themselves with one sample of noise at a time."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.actuation import actuation
from testbed.estimation.momentum_equation import momentum_equation
from testbed.estimation.noise_image import attitude_noise, filtered_noise
from testbed.estimation.prefilter import filtered_equation
from testbed.estimation.regression import solution_of

GAMMA = 0.8
KICK = 1e-6
MOMENTUM_B = np.array([0.003, -0.004, 0.006])
FLIGHT = nominal_flight(MOMENTUM_B)
TIMES = sample_times(16.0, 0.0, 2.5)
TELEMETRY = exact_telemetry(FLIGHT, TIMES, TIMES)
TRUTH = np.concatenate([TRUE_THETA, MOMENTUM_B])


def noise_matrix(error_of):
    """M, shape (3N, 3N): the change of an equation's error by every sample of noise."""
    columns = []
    for index in np.ndindex(TELEMETRY.body_rate.shape):
        kick = np.zeros(TELEMETRY.body_rate.shape)
        kick[index] = KICK
        ahead, behind = error_of(TELEMETRY.body_rate + kick), error_of(TELEMETRY.body_rate - kick)
        columns.append((ahead - behind) / (2.0 * KICK))
    return np.array(columns).T


def relative_error(image, exact):
    return np.linalg.norm(image - exact, axis=0) / np.linalg.norm(exact, axis=0)


def filtered_error(body_rate):
    equation = filtered_equation(TELEMETRY, body_rate, GAMMA)
    return equation.regressor @ TRUTH - equation.response


@pytest.fixture(scope="module")
def filtered_matrix():
    return noise_matrix(filtered_error)


def test_filtered_noise_has_the_equations_colour(filtered_matrix):
    equation = filtered_equation(TELEMETRY, TELEMETRY.body_rate, GAMMA)
    solution = solution_of(equation.regressor, equation.regressor, equation.response)
    noise = filtered_noise(TELEMETRY, equation, solution, GAMMA)
    exact = filtered_matrix.T @ solution.instrument
    assert relative_error(noise.image, exact)[:6].max() < 0.1  # on the sample grid instead of the fine one
    np.testing.assert_allclose(np.linalg.norm(noise.image, axis=0)[:6], np.linalg.norm(exact, axis=0)[:6], rtol=0.02)
    assert noise.power == pytest.approx(np.sum(filtered_matrix**2) / len(filtered_matrix), rel=0.01)


def test_taking_it_for_white_would_overstate_the_covariance(filtered_matrix):
    equation = filtered_equation(TELEMETRY, TELEMETRY.body_rate, GAMMA)
    power = np.sum(filtered_matrix**2) / len(filtered_matrix)
    white = power * np.sum(equation.regressor**2, axis=0)
    coloured = np.sum((filtered_matrix.T @ equation.regressor) ** 2, axis=0)
    assert (white[:6] > 1.1 * coloured[:6]).all()


def test_attitude_noise_is_that_of_the_integrated_gyro():
    inertia = inertia_of(TRUE_THETA) + actuation(TELEMETRY, TIMES).inertia_change_B
    scale = np.linalg.inv(inertia)

    def error(body_rate):
        equation = momentum_equation(TELEMETRY, body_rate)
        return np.matvec(scale, equation.regressor @ TRUTH - equation.response).ravel()

    equation = momentum_equation(TELEMETRY, TELEMETRY.body_rate)
    rows = scale @ equation.regressor
    image = attitude_noise(rows, scale, TIMES, equation.matrix_NB, FLIGHT.momentum(TIMES)).reshape(-1, 9)
    exact = noise_matrix(error).T @ rows.reshape(-1, 9)
    assert relative_error(image, exact)[:6].max() < 0.06  # the trapezoidal rule at 16 Hz
    assert relative_error(rows.reshape(-1, 9), exact)[:6].max() > 0.4  # what leaving it out would miss


def test_without_momentum_the_scaled_noise_is_white():
    telemetry = replace(TELEMETRY, initial_momentum="zero")
    equation = momentum_equation(telemetry, telemetry.body_rate)
    rows = equation.regressor[..., :6]
    scale = np.tile(np.eye(3), (len(TIMES), 1, 1))
    image = attitude_noise(rows, scale, TIMES, equation.matrix_NB, np.zeros((len(TIMES), 3)))
    np.testing.assert_array_equal(image, rows)
