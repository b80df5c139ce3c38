"""Ψ_f against a filter integrated by other means, and its figures against the paper's table."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from testbed.dynamics.inertia import torque_regressor
from testbed.maneuver.information import (
    filtered,
    filtered_regressor,
    information_of,
    maneuver_information,
    sampled_filter,
)
from testbed.maneuver.profiles import basic_profile

GAMMA = 0.8
SAMPLING = sampled_filter(5.0, 16.0, GAMMA)
SAMPLES = SAMPLING.fine_time[SAMPLING.samples]


def lagged(signal):
    return filtered(SAMPLING, signal)


def test_the_samples_are_the_gyros():
    np.testing.assert_allclose(SAMPLES, np.arange(81) / 16.0, atol=1e-14)


def test_a_duration_between_samples_ends_at_the_last_one():
    short = sampled_filter(4.99, 16.0, GAMMA)
    assert short.fine_time[-1] == pytest.approx(79 / 16.0)


def test_a_parabola_is_filtered_exactly():
    # y = t² has F y = t² - 2γt + 2γ²(1 - exp(-t/γ)) from zero state.
    exact = SAMPLES**2 - 2 * GAMMA * SAMPLES + 2 * GAMMA**2 * (1 - np.exp(-SAMPLES / GAMMA))
    np.testing.assert_allclose(lagged(SAMPLING.fine_time**2), exact, atol=1e-12)


def test_a_sine_is_filtered_to_third_order():
    frequency = 12.0  # rad/s, twice the fastest motion that 20 control points in 5 s can make
    x = frequency * SAMPLES
    gain = 1.0 / (1.0 + (GAMMA * frequency) ** 2)
    exact = gain * (np.sin(x) - GAMMA * frequency * (np.cos(x) - np.exp(-SAMPLES / GAMMA)))
    # Parabolas through steps of 1/32 s miss a third derivative of 12³ by about 12³/32³/15 = 3.5e-3 in places, but the
    # signs alternate; what is left is about 1e-4 of the amplitude.
    np.testing.assert_allclose(lagged(np.sin(frequency * SAMPLING.fine_time)), exact, atol=2e-4)


@pytest.mark.parametrize("offset", [0.0, 0.2], ids=["from rest", "in motion"])
def test_the_regressor_is_the_filtered_torque_regressor(offset):
    """ψ_f integrated as γψ_f' + ψ_f = ψ(ω, ω̇), which needs the derivative that the sampled form avoids."""
    amplitude, frequency = np.array([0.3, -0.2, 0.25]), np.array([1.3, 2.1, 3.4])

    def body_rate(time):
        return offset + amplitude * np.sin(np.multiply.outer(time, frequency))

    def slope(time, filtered):
        acceleration = amplitude * frequency * np.cos(time * frequency)
        return (torque_regressor(body_rate(time), acceleration).ravel() - filtered) / GAMMA

    exact = solve_ivp(slope, (0.0, 5.0), np.zeros(18), t_eval=SAMPLES, rtol=1e-10, atol=1e-12).y.T
    regressor = filtered_regressor(SAMPLING, body_rate(SAMPLING.fine_time))
    # 4 products of 0.1 (rad/s)² with derivatives of (5.5 rad/s)³ over steps of 1/32 s: below 1e-6.
    np.testing.assert_allclose(regressor, exact.reshape(-1, 6), atol=2e-6)


def test_the_basic_profile_meets_its_row_of_table_1():
    information = maneuver_information(basic_profile(), 16.0, GAMMA)
    found = [
        information.min_eigenvalue,
        information.trace_inverse,
        information.determinant,
        information.regressor_condition_number,
    ]
    np.testing.assert_allclose(found, [0.099, 21.27, 0.0036, 3.271], rtol=0.01)  # the table's own last digit is 1 %


def test_figures_of_a_known_matrix():
    information = information_of(np.diag([1.0, 2.0, 4.0, 4.0, 8.0, 16.0]))
    assert information.min_eigenvalue == pytest.approx(1.0)
    assert information.trace_inverse == pytest.approx(1 + 1 / 2 + 1 / 4 + 1 / 4 + 1 / 8 + 1 / 16)
    assert information.determinant == pytest.approx(4096.0)
    assert information.condition_number == pytest.approx(16.0)
    assert information.regressor_condition_number == pytest.approx(4.0)
