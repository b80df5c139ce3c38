"""Quaternions against their definition, and attitude against a closed form and a tight integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from testbed.dynamics.inertia import cross_matrix
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import (
    exponential,
    matrix_of,
    quaternion_inverse,
    quaternion_product,
    turned,
)

ROUNDING = 1e-12


def coning_rate(time):
    return np.stack([0.5 * np.sin(3.0 * time), 0.4 * np.cos(2.0 * time), 0.3 * np.sin(4.0 * time + 1.0)], axis=-1)


def final_matrix(duration):
    """R at the end of the coning motion, from its nine differential equations."""

    def slope(time, matrix):
        return (matrix.reshape(3, 3) @ cross_matrix(coning_rate(time))).ravel()

    end = solve_ivp(slope, (0.0, duration), np.eye(3).ravel(), method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return end.reshape(3, 3)


def test_scalar_comes_first_and_a_quarter_turn_takes_x_to_y():
    quat_NB = exponential(np.array([0.0, 0.0, np.pi / 2]))
    np.testing.assert_allclose(quat_NB, [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)], atol=ROUNDING)
    np.testing.assert_allclose(turned(quat_NB, np.array([1.0, 0.0, 0.0])), [0.0, 1.0, 0.0], atol=ROUNDING)


def test_touching_letters_cancel():
    quat_AB, quat_BC = exponential(np.array([[0.1, 0.2, 0.3], [-0.4, 0.5, 0.6]]))
    np.testing.assert_allclose(
        matrix_of(quaternion_product(quat_AB, quat_BC)), matrix_of(quat_AB) @ matrix_of(quat_BC), atol=ROUNDING
    )
    np.testing.assert_allclose(matrix_of(quaternion_inverse(quat_AB)), matrix_of(quat_AB).T, atol=ROUNDING)


def test_constant_rate_gives_the_exponential_at_every_sample():
    time, rate = np.linspace(0.0, 5.0, 80), np.array([0.3, -0.2, 0.7])
    attitude = integrate_attitude(time, np.tile(rate, (80, 1)))
    np.testing.assert_allclose(attitude, exponential(time[:, None] * rate), atol=ROUNDING)


def test_attitude_error_falls_with_the_fourth_power_of_the_step():
    truth = final_matrix(5.0)
    errors = []
    for samples in (41, 81, 161, 321):
        time = np.linspace(0.0, 5.0, samples)
        end = matrix_of(integrate_attitude(time, coning_rate(time))[-1])
        errors.append(np.linalg.norm(end - truth))
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (order > 3.3).all()  # 4, less what the not-a-knot spline loses at the ends
    assert errors[1] < 5e-6  # rad, at 16 Hz


def test_jitter_does_not_matter():
    rng = np.random.default_rng(0)
    time = np.linspace(0.0, 5.0, 81)
    time[1:-1] += rng.uniform(-0.02, 0.02, 79)
    end = matrix_of(integrate_attitude(time, coning_rate(time))[-1])
    np.testing.assert_allclose(end, final_matrix(5.0), atol=5e-6)  # as without jitter


@pytest.mark.parametrize("samples", [2, 3, 64, 65])
def test_every_sample_is_a_unit_quaternion_near_the_last(samples):
    time = np.linspace(0.0, 2.0, samples)
    attitude = integrate_attitude(time, coning_rate(time))
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=1), 1.0, atol=ROUNDING)
    assert (np.einsum("ni,ni->n", attitude[1:], attitude[:-1]) > 0.0).all()  # no jump to the opposite sign
