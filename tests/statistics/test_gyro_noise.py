"""Moments of the gyro's noises over many flights, and the independence of their sources."""

import numpy as np
import pytest

from testbed.sensors.gyro import GyroParameters, gyro_errors

SAMPLES = 80
FLIGHTS = 4000
# Standard error of a variance over FLIGHTS x 3 axes is sqrt(2 / 12000) = 1.3 %; four of them are allowed.
VARIANCE_TOLERANCE = 4 * np.sqrt(2 / (3 * FLIGHTS))


def flights(**parameters):
    """Errors of many flights, shape (FLIGHTS, SAMPLES, 3)."""
    gyro = GyroParameters(**{"sample_rate": 16.0, **parameters})
    seeds = np.random.SeedSequence(20).spawn(FLIGHTS)
    return np.stack([gyro_errors(gyro, SAMPLES, seed) for seed in seeds])


def variance_by_sample(errors):
    return np.mean(errors**2, axis=(0, 2))


def test_white_noise_is_unbiased_white_and_of_its_size():
    errors = flights(white_noise=0.025)
    standard_error = 0.025 / np.sqrt(errors.size / 3)
    assert np.abs(errors.mean(axis=(0, 1))).max() < 4 * standard_error
    assert errors.std() == pytest.approx(0.025, rel=4 / np.sqrt(2 * errors.size))
    neighbours = np.mean(errors[:, 1:] * errors[:, :-1]) / 0.025**2
    assert abs(neighbours) < 4 / np.sqrt(errors[:, 1:].size)
    across = np.corrcoef(errors.reshape(-1, 3).T) - np.eye(3)
    assert np.abs(across).max() < 4 / np.sqrt(errors.size / 3)


def test_bias_instability_is_stationary_from_the_first_sample_and_forgets_exponentially():
    errors = flights(bias_instability=2e-3, bias_correlation_time=1.5)
    np.testing.assert_allclose(variance_by_sample(errors) / 2e-3**2, 1.0, rtol=1.5 * VARIANCE_TOLERANCE)
    after = np.mean(errors[:, 0] * errors[:, 24]) / 2e-3**2
    assert after == pytest.approx(np.exp(-1.0), abs=4 / np.sqrt(3 * FLIGHTS))


def test_an_endless_correlation_time_makes_a_constant_bias_drawn_once_per_flight():
    errors = flights(bias_instability=2e-3)
    np.testing.assert_allclose(errors, np.broadcast_to(errors[:, :1], errors.shape), rtol=1e-12)
    assert variance_by_sample(errors)[0] == pytest.approx(2e-3**2, rel=VARIANCE_TOLERANCE)


def test_rate_random_walk_starts_at_zero_and_gains_k_squared_t():
    errors = flights(rate_random_walk=1e-3)
    elapsed = np.arange(SAMPLES) / 16.0
    assert (errors[:, 0] == 0.0).all()
    np.testing.assert_allclose(variance_by_sample(errors)[1:], 1e-3**2 * elapsed[1:], rtol=1.5 * VARIANCE_TOLERANCE)


def test_angle_quantization_never_loses_angle():
    """The integrated error stays within one angle step, however long the flight."""
    errors = flights(angle_quantization=1e-4)
    angle = np.cumsum(errors, axis=1) / 16.0
    assert np.abs(angle).max() <= 1e-4 * np.sqrt(12)
    assert errors.var() == pytest.approx(2 * (16.0 * 1e-4) ** 2, rel=VARIANCE_TOLERANCE)


def test_bias_moves_every_sample():
    errors = flights(bias=np.array([0.1, 0.0, -0.2]))
    np.testing.assert_array_equal(errors, np.broadcast_to([0.1, 0.0, -0.2], errors.shape))


@pytest.mark.parametrize(
    "other",
    [
        {"bias_instability": 1e-3, "bias_correlation_time": 2.0},
        {"rate_random_walk": 1e-3},
        {"angle_quantization": 1e-5},
        {"bias": np.array([0.1, 0.2, 0.3])},
    ],
)
def test_switching_one_noise_on_leaves_the_others_numbers_alone(other):
    seed = np.random.SeedSequence(3)
    white = gyro_errors(GyroParameters(sample_rate=16.0, white_noise=0.025), SAMPLES, seed)
    alone = gyro_errors(GyroParameters(sample_rate=16.0, **other), SAMPLES, seed)
    both = gyro_errors(GyroParameters(sample_rate=16.0, white_noise=0.025, **other), SAMPLES, seed)
    assert np.abs(alone).max() > 0.0
    np.testing.assert_allclose(both, white + alone, atol=1e-15)


def test_a_longer_flight_begins_like_a_shorter_one():
    gyro = GyroParameters(sample_rate=16.0, white_noise=0.025, rate_random_walk=1e-3, angle_quantization=1e-5)
    seed = np.random.SeedSequence(3)
    np.testing.assert_array_equal(gyro_errors(gyro, 40, seed), gyro_errors(gyro, 80, seed)[:40])


def test_seeds_of_one_scenario_give_unrelated_flights():
    first, second = np.random.SeedSequence(3).spawn(2)
    gyro = GyroParameters(sample_rate=16.0, white_noise=1.0)
    a, b = gyro_errors(gyro, 20_000, first), gyro_errors(gyro, 20_000, second)
    assert abs(np.mean(a * b)) < 4 / np.sqrt(a.size)
