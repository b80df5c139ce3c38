"""Encoders, tachometers and motor currents."""

import numpy as np
import pytest

from testbed.sensors.units import UnitSensor, read_units, unit_errors

SEED = np.random.SeedSequence(7)
ANGLE = np.linspace(-3.0, 3.0, 60).reshape(10, 6)


def test_a_perfect_sensor_reads_the_truth_exactly():
    errors = unit_errors(UnitSensor(), 10, 6, SEED)
    np.testing.assert_array_equal(read_units(UnitSensor(), ANGLE, errors), ANGLE)


def test_an_encoder_has_its_own_zero_on_each_unit():
    zero = np.array([0.0, 0.01, -0.02, 0.0, 0.0, 0.03])
    encoder = UnitSensor(zero_offset=zero)
    measured = read_units(encoder, ANGLE, unit_errors(encoder, 10, 6, SEED))
    np.testing.assert_allclose(measured - ANGLE, np.broadcast_to(zero, (10, 6)), atol=1e-15)


def test_a_tachometer_scales():
    tachometer = UnitSensor(scale_factor_error=np.array([0.0, 0.0, 0.0, -0.01, 0.0, 0.0]))
    measured = read_units(tachometer, np.full(6, 471.4), np.zeros(6))
    assert measured == pytest.approx([471.4, 471.4, 471.4, 0.99 * 471.4, 471.4, 471.4], rel=1e-15)


def test_quantization_rounds_the_noisy_reading():
    encoder = UnitSensor(white_noise=0.3, quantization=0.1)
    errors = unit_errors(encoder, 10, 6, SEED)
    measured = read_units(encoder, ANGLE, errors)
    np.testing.assert_allclose(measured, np.round(ANGLE + errors, 1), atol=1e-12)


def test_white_noise_has_its_standard_deviation_on_each_unit():
    """20,000 samples: the standard deviation of an estimated one is 0.5 % of it, five of those are allowed."""
    std = np.array([1e-4, 2e-4, 1e-4, 0.0, 1e-3, 1e-4])
    errors = unit_errors(UnitSensor(white_noise=std), 20_000, 6, SEED)
    np.testing.assert_allclose(errors.std(axis=0), std, rtol=0.025)
    correlation = np.corrcoef(errors[:, [0, 1, 2, 4, 5]].T) - np.eye(5)
    assert np.abs(correlation).max() < 5 / np.sqrt(20_000)


def test_the_same_seed_gives_the_same_errors_every_time():
    encoder = UnitSensor(white_noise=1e-4)
    np.testing.assert_array_equal(unit_errors(encoder, 5, 6, SEED), unit_errors(encoder, 5, 6, SEED))


def test_a_series_reads_as_its_samples_do():
    encoder = UnitSensor(white_noise=1e-4, zero_offset=0.1, scale_factor_error=0.01, quantization=1e-3)
    errors = unit_errors(encoder, 10, 6, SEED)
    one_by_one = [read_units(encoder, angle, error) for angle, error in zip(ANGLE, errors, strict=True)]
    np.testing.assert_array_equal(read_units(encoder, ANGLE, errors), one_by_one)
