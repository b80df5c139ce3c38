"""Properties of the gyro that hold for any motion and any parameters."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from testbed.errors import InputError
from testbed.sensors.gyro import GyroParameters
from testbed.sensors.gyro_response import gyro_at_start, gyro_on_clock, sample_gyro
from testbed.sensors.sampling import quantized, ticks_per_sample

BANDWIDTHS = st.floats(0.01, 1e4) | st.just(np.inf)
LATENCIES = st.floats(0.0, 0.2)
MOTIONS = arrays.arrays(np.float64, (30, 3), elements=st.floats(-20, 20, width=32))


def readings(motion, start=None, **parameters):
    gyro = gyro_on_clock(GyroParameters(sample_rate=80.0, **parameters), 80.0)
    state = gyro_at_start(gyro, motion[0] if start is None else start)
    read = []
    for tick, rate in enumerate(motion):
        state, reading = sample_gyro(gyro, state, rate, tick, np.zeros((30, 3)))
        read.append(reading)
    return np.array(read)


@given(rate=arrays.arrays(np.float64, 3, elements=st.floats(-20, 20)), bandwidth=BANDWIDTHS, latency=LATENCIES)
@settings(max_examples=50, deadline=None)
def test_low_pass_and_latency_leave_a_constant_rate_alone(rate, bandwidth, latency):
    np.testing.assert_allclose(
        readings(np.tile(rate, (30, 1)), bandwidth=bandwidth, latency=latency), np.tile(rate, (30, 1)), atol=1e-11
    )


@given(first=MOTIONS, second=MOTIONS, bandwidth=BANDWIDTHS, latency=LATENCIES)
@settings(max_examples=50, deadline=None)
def test_without_rounding_and_clipping_the_gyro_is_linear(first, second, bandwidth, latency):
    chain = {
        "bandwidth": bandwidth,
        "latency": latency,
        "misalignment": np.array([[0, 0.1, 0], [0, 0, 0.2], [0.3, 0, 0]]),
    }
    together = readings(first - 2 * second, **chain)
    np.testing.assert_allclose(together, readings(first, **chain) - 2 * readings(second, **chain), atol=1e-10)


@given(motion=MOTIONS, step=st.floats(1e-4, 1.0), limit=st.floats(0.01, 30.0))
@settings(max_examples=50, deadline=None)
def test_readings_are_steps_within_the_range(motion, step, limit):
    read = readings(motion, quantization=step, saturation=limit)
    assert np.abs(read).max() <= limit + step / 2 * (1 + 1e-9)
    assert np.abs(read - np.clip(motion, -limit, limit)).max() <= step / 2 * (1 + 1e-9)


@given(value=arrays.arrays(np.float64, 6, elements=st.floats(-100, 100)), step=st.floats(1e-3, 1.0))
def test_rounding_twice_changes_nothing(value, step):
    once = quantized(value, step)
    np.testing.assert_array_equal(quantized(once, step), once)


@given(clock=st.integers(1, 10_000), sample=st.integers(1, 10_000))
def test_a_rate_is_taken_exactly_where_it_divides_the_clock(clock, sample):
    try:
        ticks = ticks_per_sample(float(clock), float(sample), "gyro")
    except InputError:
        assert clock % sample
    else:
        assert ticks * sample == clock
