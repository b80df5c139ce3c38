"""Every estimator recovers the truth from exact records of every kind that the records' format allows."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from support.synthetic_telemetry import (
    NOMINAL_THETA,
    TRUE_THETA,
    exact_telemetry,
    noisy,
    nominal_flight,
    sample_times,
)
from testbed.cmg.cluster import cluster_momentum
from testbed.errors import InputError
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.registry import ESTIMATORS

MOMENTUM_B = np.array([0.003, -0.004, 0.006])
FLIGHT = nominal_flight(MOMENTUM_B)
TIMES = sample_times(16.0)
WHOLE = exact_telemetry(FLIGHT, TIMES, TIMES)
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
INTERPOLATION = 2e-7
"""kg·m²; what 16 Hz samples leave between them."""


def without(samples, array):
    return np.delete(array, samples, axis=0)


def jittered():
    time = TIMES.copy()
    time[1:-1] += np.random.default_rng(0).uniform(-0.01, 0.01, len(TIMES) - 2)
    return exact_telemetry(FLIGHT, time, TIMES)


def with_gyro_gaps():
    lost = [10, 20, 21, *range(40, 46)]
    return replace(WHOLE, gyro_time=without(lost, TIMES), body_rate=without(lost, WHOLE.body_rate))


def with_encoder_gaps():
    lost = [30, *range(50, 55)]
    return WHOLE.with_actuator_samples(without(lost, TIMES), partial(without, lost))


RECORDS = {
    "whole": WHOLE,
    "cut at both ends": exact_telemetry(FLIGHT, sample_times(16.0, 1.3, 4.2), sample_times(16.0, 1.3, 4.2)),
    "encoders start late": exact_telemetry(FLIGHT, TIMES, sample_times(16.0, 1.5)),
    "jitter": jittered(),
    "gyro at 100 Hz": exact_telemetry(FLIGHT, sample_times(100.0), TIMES),
    "encoders at 100 Hz": exact_telemetry(FLIGHT, TIMES, sample_times(100.0)),
}


@pytest.mark.parametrize("record", RECORDS)
@pytest.mark.parametrize("name", ESTIMATORS)
def test_truth_is_recovered(name, record):
    telemetry = RECORDS[record]
    estimate = ESTIMATORS[name](telemetry, SETTINGS)
    first = max(telemetry.gyro_time[0], telemetry.actuator_time[0])
    momentum_B = FLIGHT.momentum(np.array([first, 5.0]))[0]
    np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=INTERPOLATION)
    np.testing.assert_allclose(estimate.initial_momentum_B, momentum_B, atol=INTERPOLATION)


@pytest.mark.parametrize("telemetry", [with_gyro_gaps(), with_encoder_gaps()], ids=["gyro", "encoders"])
@pytest.mark.parametrize("name", ESTIMATORS)
def test_gaps_cost_little(name, telemetry):
    estimate = ESTIMATORS[name](telemetry, SETTINGS)
    np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=1e-5)  # momentum form: the attitude across 0.4 s


@pytest.mark.parametrize("factor", [0.4, 2.0])
@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_nominal_model_far_off_does_not_matter(name, factor):
    noisy_run = noisy(replace(WHOLE, gyro_noise=0.025), 3, 1e-4)
    far, near = (
        ESTIMATORS[name](noisy_run, EstimationSettings(nominal_theta=theta)).theta
        for theta in (factor * NOMINAL_THETA, NOMINAL_THETA)
    )
    np.testing.assert_allclose(far, near, atol=1e-6)  # of a standard deviation of 2e-4 to 5e-4


@pytest.mark.parametrize("name", ESTIMATORS)
def test_known_zero_momentum_is_not_estimated(name):
    at_rest = exact_telemetry(nominal_flight(), sample_times(16.0, 1.3, 4.2), TIMES)
    estimate = ESTIMATORS[name](replace(at_rest, initial_momentum="zero"), SETTINGS)
    np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=INTERPOLATION)
    assert not estimate.initial_momentum_B.any()
    assert not estimate.initial_momentum_covariance.any()


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_platform_turned_by_thrusters(name):
    flight = nominal_flight()
    time = sample_times(64.0)
    fine = np.linspace(0.0, 5.0, 5001)
    rate = flight.body_rate(fine)
    inertia = np.diag(TRUE_THETA[:3])
    torque = np.gradient(rate, fine, axis=0, edge_order=2) @ inertia + np.cross(rate, rate @ inertia)
    thrusters = replace(
        exact_telemetry(flight, time, time),
        actuator_time=fine,
        gimbals=None,
        applied_torque=torque,
    )
    estimate = ESTIMATORS[name](thrusters, SETTINGS)
    np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=1e-6)  # the torque is a difference quotient at 1 kHz


@pytest.mark.parametrize("name", ESTIMATORS)
def test_the_platforms_own_momentum_gives_the_same_but_for_the_inertias_change(name):
    momentum_B = cluster_momentum(FLIGHT.cluster, FLIGHT.gimbals.angle(TIMES), FLIGHT.gimbals.rate(TIMES))
    reported = replace(WHOLE, gimbals=None, cluster_momentum=momentum_B)
    estimate = ESTIMATORS[name](reported, SETTINGS)
    np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=3e-5)  # J(d) - J(0) is up to 3e-5 kg·m²


@pytest.mark.parametrize("instrument", ["reference", "nominal", "iterated"])
@pytest.mark.parametrize("name", ["iv", "iv_momentum"])
def test_every_instrument_answers_without_bias(name, instrument):
    settings = EstimationSettings(nominal_theta=NOMINAL_THETA, instrument=instrument, reference_rate=FLIGHT.body_rate)
    estimate = ESTIMATORS[name](WHOLE, settings)
    np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=INTERPOLATION)
    assert estimate.iterations == (3 if instrument == "iterated" else 1)


@pytest.mark.parametrize("name", ["iv", "iv_momentum"])
def test_a_reference_that_is_missing_is_named(name):
    with pytest.raises(InputError, match="reference rate"):
        ESTIMATORS[name](WHOLE, EstimationSettings(nominal_theta=NOMINAL_THETA, instrument="reference"))


@pytest.mark.parametrize("name", ["iv_momentum", "output_error"])
def test_residual_is_measured_minus_predicted_rate(name):
    kicked = WHOLE.body_rate.copy()
    kicked[40, 1] += 0.01
    estimate = ESTIMATORS[name](replace(WHOLE, body_rate=kicked), SETTINGS)
    assert estimate.residual_unit == "rad/s"
    assert np.unravel_index(np.argmax(np.abs(estimate.residual)), estimate.residual.shape) == (40, 1)
    np.testing.assert_allclose(estimate.residual[40, 1], 0.01, rtol=0.1)  # the fit takes a part of one sample's kick


@pytest.mark.parametrize("name", ["ls", "iv"])
def test_filtered_residual_is_a_torque_of_the_noises_size(name):
    telemetry = noisy(replace(WHOLE, gyro_noise=0.025), 1, 0.0)
    estimate = ESTIMATORS[name](telemetry, SETTINGS)
    assert estimate.residual_unit == "N·m"
    assert estimate.residual.shape == (len(TIMES), 3)
    assert estimate.residual_sigma == pytest.approx(0.025 * 0.0238 / 0.8, rel=0.15)  # σ J/γ, by the spread of 240 rows
