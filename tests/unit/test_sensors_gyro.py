"""The gyro's deterministic errors, one at a time and in their order, against closed forms."""

import numpy as np
import pytest

from testbed.errors import InputError
from testbed.sensors.gyro import GyroParameters
from testbed.sensors.gyro_response import gyro_at_start, gyro_on_clock, sample_gyro

CONTROL_RATE = 80.0
TIME = np.arange(400) / CONTROL_RATE


def readings(true_body_rate, errors=None, **parameters):
    """Fly a gyro along a true body rate, shape (N, ..., 3), sampled at the control rate unless asked otherwise."""
    gyro = gyro_on_clock(GyroParameters(**{"sample_rate": CONTROL_RATE, **parameters}), CONTROL_RATE)
    state = gyro_at_start(gyro, true_body_rate[0])
    errors = np.zeros_like(true_body_rate) if errors is None else errors
    measured = []
    for tick, rate in enumerate(true_body_rate):
        state, reading = sample_gyro(gyro, state, rate, tick, errors)
        measured.append(np.full_like(rate, np.nan) if reading is None else reading)
    return np.array(measured)


def turning(frequency=1.0):
    phase = 2 * np.pi * frequency * TIME[:, None] + np.array([0.0, 1.0, 2.0])
    return 0.3 * np.sin(phase)


def test_a_perfect_gyro_reads_the_true_rate_exactly():
    np.testing.assert_array_equal(readings(turning()), turning())


def test_readings_come_at_the_gyros_own_rate():
    measured = readings(turning(), sample_rate=16.0)
    sampled = ~np.isnan(measured).any(axis=1)
    assert np.flatnonzero(sampled)[:3].tolist() == [0, 5, 10]
    np.testing.assert_array_equal(measured[sampled], turning()[::5])


@pytest.mark.parametrize(
    ("sample_rate", "remedy"),
    [(30.0, "use 26.6667 or 40 Hz"), (16.001, "use 16 or 20 Hz"), (100.0, "use 80 Hz"), (79.9, "use 40 or 80 Hz")],
)
def test_a_sample_rate_that_does_not_divide_the_control_rate_is_refused(sample_rate, remedy):
    with pytest.raises(InputError, match=f"gyro: a sample rate of {sample_rate:g} Hz does not divide.*{remedy}"):
        gyro_on_clock(GyroParameters(sample_rate=sample_rate), CONTROL_RATE)


def test_scale_and_misalignment_mix_the_axes():
    misalignment = np.array([[0.0, 0.01, 0.0], [0.0, 0.0, 0.0], [-0.02, 0.0, 0.0]])
    measured = readings(turning(), scale_factor_error=np.array([0.1, 0.0, -0.2]), misalignment=misalignment)
    x, y, z = turning().T
    np.testing.assert_allclose(measured, np.stack([1.1 * x + 0.01 * y, y, 0.8 * z - 0.02 * x], axis=1), atol=1e-15)


@pytest.mark.parametrize("bandwidth", [0.5, 5.0, 30.0])
def test_the_low_pass_is_exact_on_a_ramp(bandwidth):
    """The ramp starts at tick 3, so that no tick before shares a cubic with its corner."""
    pole = 2 * np.pi * bandwidth
    ramp = np.maximum(0.0, TIME - TIME[3])[:, None] * np.array([1.0, -2.0, 0.5])
    measured = readings(ramp, bandwidth=bandwidth)
    since = TIME - TIME[200]
    steady = ramp - np.array([1.0, -2.0, 0.5]) / pole
    transient = (measured[200] - steady[200]) * np.exp(-pole * since)[:, None]
    np.testing.assert_allclose(measured[200:], (steady + transient)[200:], atol=1e-12)


@pytest.mark.parametrize("bandwidth", [*np.logspace(-2, 9, 23), np.inf])
def test_a_steady_rate_passes_any_bandwidth(bandwidth):
    """Pole and taps sum to one within rounding; far above the control rate the gyro shows the present rate alone."""
    gyro = gyro_on_clock(GyroParameters(sample_rate=CONTROL_RATE, bandwidth=bandwidth), CONTROL_RATE)
    assert gyro.pole + gyro.taps.sum() == pytest.approx(1.0, abs=1e-14)
    if bandwidth > 1e6:  # the lag 1 / (2π bandwidth), in ticks, is what is left
        np.testing.assert_allclose(gyro.taps[:1], 1.0, atol=2 * CONTROL_RATE / (2 * np.pi * bandwidth))


@pytest.mark.parametrize("bandwidth", [1.0, 10.0, 30.0])
@pytest.mark.parametrize("latency", [0.0, 0.0031, 0.0125, 0.04])
def test_bandwidth_and_latency_respond_as_in_continuous_time(bandwidth, latency):
    """At 1 Hz on an 80 Hz grid the cubics of low-pass and latency are each good to 1e-6 to 2e-6 of the amplitude."""
    measured = readings(turning(), bandwidth=bandwidth, latency=latency)
    gain = np.exp(-2j * np.pi * latency) / (1 + 1j / bandwidth)
    phase = 2 * np.pi * TIME[:, None] + np.array([0.0, 1.0, 2.0])
    # The start-up transient has died out to exp(-2π·4) = 1e-11 at the lowest bandwidth.
    np.testing.assert_allclose(measured[320:], 0.3 * (gain * np.exp(1j * phase)).imag[320:], atol=0.3 * 4e-6)


def test_half_the_power_is_left_at_the_bandwidth():
    measured = readings(turning(2.0), bandwidth=2.0)[200:]
    # The cubic is good to 2e-5 of the amplitude at 2 Hz; whole turns are averaged.
    np.testing.assert_allclose(np.mean(measured**2, axis=0), 0.3**2 / 4, rtol=1e-4)


@pytest.mark.parametrize("ticks", [1, 2, 7])
def test_a_latency_of_whole_ticks_shifts_the_samples(ticks):
    measured = readings(turning(), latency=ticks / CONTROL_RATE)
    np.testing.assert_allclose(measured[ticks:], turning()[:-ticks], atol=1e-15)
    np.testing.assert_allclose(measured[:ticks], np.broadcast_to(turning()[0], (ticks, 3)), atol=1e-15)


def test_errors_are_added_after_the_low_pass():
    errors = np.zeros((TIME.size, 3))
    errors[100] = 0.5
    measured = readings(np.zeros((TIME.size, 3)), errors=errors, bandwidth=1.0, latency=0.05)
    np.testing.assert_array_equal(measured, errors)


def test_saturation_clips_what_noise_and_scale_have_made_of_the_rate():
    measured = readings(turning(), errors=np.full((TIME.size, 3), 0.2), saturation=0.25)
    np.testing.assert_array_equal(measured, np.clip(turning() + 0.2, -0.25, 0.25))
    assert (measured == 0.25).any()


def test_a_clipped_reading_is_still_a_multiple_of_the_step():
    measured = readings(turning(), saturation=0.27, quantization=0.04)
    assert measured.max() == pytest.approx(0.28)
    np.testing.assert_allclose(measured / 0.04, np.rint(measured / 0.04), atol=1e-12)
    assert np.abs(measured - np.clip(turning(), -0.27, 0.27)).max() <= 0.02 + 1e-12


def test_a_batch_reads_what_its_flights_read_alone():
    flights = np.stack([turning(), turning(0.5), -turning(2.0)], axis=1)
    errors = np.random.default_rng(1).normal(size=(80, 3, 3)) * 0.01
    parameters = {
        "sample_rate": 16.0, "bandwidth": 10.0, "latency": 0.017, "quantization": 1e-3,
        "misalignment": np.array([[0.0, 0.01, 0.0], [0.0, 0.0, 0.03], [-0.02, 0.0, 0.0]]),
    }  # fmt: skip
    together = readings(flights, errors, **parameters)
    for number in range(3):
        alone = readings(flights[:, number], errors[:, number], **parameters)
        np.testing.assert_allclose(together[:, number], alone, atol=1e-15)


def test_the_state_does_not_follow_the_callers_array():
    """The caller may hand over a view into the simulator's own state."""
    gyro = gyro_on_clock(GyroParameters(sample_rate=80.0, latency=1 / 80, bandwidth=1.0), CONTROL_RATE)
    held = np.array([0.1, 0.2, 0.3])
    view = held.copy()
    state = gyro_at_start(gyro, view)
    for tick in range(3):
        view[:] = 9.0
        view = held.copy()
        state, reading = sample_gyro(gyro, state, view, tick, np.zeros((3, 3)))
        np.testing.assert_allclose(reading, held, atol=1e-15)


def test_a_state_can_be_continued_twice():
    gyro = gyro_on_clock(GyroParameters(sample_rate=80.0, latency=0.02, bandwidth=5.0), CONTROL_RATE)
    state = gyro_at_start(gyro, np.zeros(3))
    first = sample_gyro(gyro, state, np.ones(3), 0, np.zeros((1, 3)))[1]
    second = sample_gyro(gyro, state, np.ones(3), 0, np.zeros((1, 3)))[1]
    np.testing.assert_array_equal(first, second)
