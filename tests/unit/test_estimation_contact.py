"""The first contact is found from telemetry alone: at both noises, gentle or hard, and not where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import NOMINAL_THETA, exact_telemetry, noisy, nominal_flight, sample_times
from testbed.estimation.contact import first_contact

TIMES = sample_times(16.0)
MOMENTUM_B = np.array([3e-4, -4e-4, 2e-4])  # released with about 0.02 rad/s
NOISES = [0.001658, 0.025]
DIRECTION = np.array([0.48, -0.6, 0.64])
TOUCH = 45
"""First sample after the touch, at 2.8125 s."""


def telemetry(noise: float, seed: int):
    return noisy(exact_telemetry(nominal_flight(MOMENTUM_B), TIMES, TIMES, noise), seed, encoder_noise=1e-4)


def touched(noise: float, seed: int, rate_jump: float):
    """A push turns the body's rate by a step; what it does to the momentum's direction later is second order."""
    free = telemetry(noise, seed)
    rate = free.body_rate.copy()
    rate[TOUCH:] += rate_jump * DIRECTION
    return replace(free, body_rate=rate)


@pytest.mark.parametrize("noise", NOISES)
def test_a_free_flight_has_no_contact(noise):
    # 1 in 2,000 flights by chance; the seeds are fixed.
    assert all(first_contact(telemetry(noise, seed), NOMINAL_THETA) is None for seed in range(30))


@pytest.mark.parametrize("noise", NOISES)
def test_a_clear_touch_is_found_at_its_sample(noise):
    for seed in range(20):
        contact = first_contact(touched(noise, seed, 12.0 * noise), NOMINAL_THETA)
        assert contact is not None
        # One sample in twenty before it looks doubtful by chance, and is given up with it; hardly ever two.
        assert contact.first_seen in TIMES[TOUCH - 2 : TOUCH + 1]
        assert contact.last_free < contact.first_seen
        # The jump is known to the noise of one sample and of its prediction, about 1.3 of it on each axis.
        np.testing.assert_allclose(contact.rate_jump_B, 12.0 * noise * DIRECTION, atol=6.0 * noise)


def test_a_gentle_touch_is_found_within_the_window():
    found = [first_contact(touched(NOISES[0], seed, 6.0 * NOISES[0]), NOMINAL_THETA) for seed in range(20)]
    seen = [contact.first_seen for contact in found if contact is not None]
    assert len(seen) >= 19  # six standard deviations of one sample are eight of the mean of four: none is missed
    assert max(seen) <= TIMES[TOUCH + 3]


def test_a_quiet_gyro_does_not_make_interpolation_a_contact():
    assert first_contact(telemetry(0.0, 0), NOMINAL_THETA) is None
