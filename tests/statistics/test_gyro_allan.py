"""Allan deviation of the generated noise, by allantools, against the curves of IEEE Std 952."""

import allantools
import numpy as np
import pytest

from testbed.sensors.gyro import GyroParameters, gyro_errors
from testbed.sensors.gyro_response import gyro_at_start, gyro_on_clock, sample_gyro

RATE = 16.0
SAMPLES = 2**16
AVERAGED = 2 ** np.arange(9)  # samples per average: τ from 1/16 to 16 s
TAU = AVERAGED / RATE


def allan_deviation(errors):
    """Pooled over the three axes, at TAU."""
    by_axis = [allantools.oadev(axis, rate=RATE, data_type="freq", taus=TAU)[1] for axis in errors.T]
    return np.sqrt(np.mean(np.square(by_axis), axis=0))


def generated(**parameters):
    gyro = GyroParameters(sample_rate=RATE, **parameters)
    return gyro_errors(gyro, SAMPLES, np.random.SeedSequence(952))


def assert_follows(errors, theory):
    """Four standard errors, of no more than SAMPLES / averaged independent pairs on each of three axes."""
    tolerance = 4 / np.sqrt(2 * 3 * SAMPLES / AVERAGED)
    np.testing.assert_array_less(np.abs(allan_deviation(errors) / theory - 1), tolerance)


def test_white_noise_is_an_angle_random_walk():
    gyro = GyroParameters(sample_rate=RATE, white_noise=0.001658)
    assert gyro.angle_random_walk == pytest.approx(0.001658 / 4)
    assert_follows(generated(white_noise=0.001658), gyro.angle_random_walk / np.sqrt(TAU))


@pytest.mark.parametrize("correlation_time", [0.5, 3.0])
def test_bias_instability_is_exponentially_correlated(correlation_time):
    """The curve is that of the sampled process; it tends to IEEE's, of the continuous one, as τ/dt grows."""
    errors = generated(bias_instability=1e-3, bias_correlation_time=correlation_time)
    assert_follows(errors, sampled_markov_deviation(1e-3, correlation_time))
    ratio = TAU[4:] / correlation_time
    ieee = 2 * 1e-3**2 / ratio * (1 - (3 - 4 * np.exp(-ratio) + np.exp(-2 * ratio)) / (2 * ratio))
    np.testing.assert_allclose(sampled_markov_deviation(1e-3, correlation_time)[4:], np.sqrt(ieee), rtol=0.01)


def sampled_markov_deviation(std, correlation_time):
    """Half the mean square of the difference of neighbouring averages, from the autocovariance itself."""
    deviations = []
    for count in AVERAGED:
        weights = np.concatenate([-np.ones(count), np.ones(count)]) / count
        lags = np.abs(np.subtract.outer(np.arange(2 * count), np.arange(2 * count))) / RATE
        deviations.append(std * np.sqrt(weights @ np.exp(-lags / correlation_time) @ weights / 2))
    return np.array(deviations)


def test_rate_random_walk_grows_with_the_root_of_tau():
    """A walk sampled m times per average has K²τ/3·(1 + 1/(2m²)); without the factor it is IEEE's."""
    errors = generated(rate_random_walk=1e-3)
    assert_follows(errors, 1e-3 * np.sqrt(TAU / 3 * (1 + 1 / (2 * AVERAGED**2))))


def test_angle_quantization_falls_with_tau():
    assert_follows(generated(angle_quantization=1e-5), np.sqrt(3) * 1e-5 / TAU)


def test_a_coarse_reading_of_a_busy_signal_adds_an_angle_random_walk():
    """Rounding to a step q with several levels of noise under it is white, of q/√12 per sample."""
    step, signal = 2e-3, generated(white_noise=0.02)
    gyro = gyro_on_clock(GyroParameters(sample_rate=RATE, quantization=step), RATE)
    state = gyro_at_start(gyro, np.zeros(3))
    read = [sample_gyro(gyro, state, np.zeros(3), tick, signal)[1] for tick in range(SAMPLES)]
    assert_follows(np.array(read) - signal, step / np.sqrt(12 * RATE) / np.sqrt(TAU))


def test_all_noises_together_add_their_variances():
    together = generated(white_noise=1e-3, rate_random_walk=1e-4, angle_quantization=2e-5)
    walk = 1e-4**2 * TAU / 3 * (1 + 1 / (2 * AVERAGED**2))
    assert_follows(together, np.sqrt(1e-3**2 / RATE / TAU + walk + 3 * 2e-5**2 / TAU**2))
