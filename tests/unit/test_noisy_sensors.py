"""A table whose attitude sensor and tachometers have noise: neither puts a healthy estimate off, nor in doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import testbed as tb
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import nominal_body
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.estimation.output_error import output_error
from testbed.estimation.surroundings import fused, sensor_noise
from testbed.estimation.telemetry_covariance import with_telemetry_noise
from testbed.estimation.telemetry_noise import with_more_noise
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import exponential, matrix_of, quaternion_product

ATTITUDE, GYRO = 5e-4, 4e-4
"""rad, and rad/s at 50 Hz, of the sensors."""
BIAS = np.array([1e-3, -5e-4, 8e-4])
"""rad/s, of the gyro."""
TIME = 0.02 * np.arange(1001)
RATE = 0.1 * np.stack([np.sin(0.5 * TIME), np.cos(0.7 * TIME), np.sin(0.3 * TIME + 1.0)], axis=1)
TRUE = integrate_attitude(TIME, RATE)


def with_noisy_attitude(quaternions, rng):
    return quaternion_product(exponential(ATTITUDE * rng.standard_normal((len(quaternions), 3))), quaternions)


def test_the_start_of_an_attitude_is_known_as_well_as_it_says():
    errors, stds = [], []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        sent, quaternions = TIME[::5], with_noisy_attitude(TRUE[::5], rng)
        measured = RATE + BIAS + GYRO * rng.standard_normal(RATE.shape)
        attitude, std = fused(TIME, measured, sent, quaternions, noise=ATTITUDE, walk=GYRO * np.sqrt(0.02))
        apart = matrix_of(attitude.start) @ matrix_of(TRUE[0]).T
        errors.append([apart[2, 1], apart[0, 2], apart[1, 0]])
        stds.append(std)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.mean(stds), rel=0.25)
    assert np.mean(stds) < 0.4 * ATTITUDE
    assert sensor_noise(attitude, sent, quaternions) == pytest.approx(ATTITUDE, rel=0.2)


@pytest.fixture(scope="module")
def table():
    scenario = tb.read_scenario("air_bearing")
    return scenario, tb.fly(scenario, seed=90311)


def noisy(record, seed):
    """The record of a table whose attitude is sampled at 10 Hz with noise."""
    true = record.channels["true_attitude"]
    sampled = np.full_like(true, np.nan)
    sampled[::5] = with_noisy_attitude(true[::5], np.random.default_rng(seed))
    return replace(record, channels=record.channels | {"attitude": sampled})


def test_noise_of_an_attitude_sensor_is_no_doubt_and_no_error(table):
    scenario, run = table
    found = tb.estimate(scenario, tb.Records((noisy(run.record, 1),))).identification
    best = found.combined.by_name["output_error"]
    errors = (best.theta - theta_of(np.array(scenario.truth.inertia_kg_m2))) / best.std
    assert np.abs(errors).max() < 3.5
    (estimation,) = found.estimations.values()
    assert estimation.checks.residual.whiteness_p_value > 1e-3


def test_what_noise_of_telemetry_does_is_in_the_covariance(table):
    """Estimates from the same flight behind ever other noise of its tachometers scatter as the covariance says."""
    scenario, run = table
    nominal = nominal_body(scenario)
    settings = estimation_settings(scenario, nominal, maneuver=None)
    sent = telemetry_of(run.record, scenario, nominal)
    loud = sent.wheels.momentum + 1e-4 * np.random.default_rng(2).standard_normal(sent.wheels.momentum.shape)
    part = replace(sent, wheels=replace(sent.wheels, momentum=loud))
    stated = with_telemetry_noise(output_error(part, settings), part)
    rng = np.random.default_rng(3)
    scatter = np.std([output_error(with_more_noise(part, rng), settings).theta for _ in range(24)], axis=0)
    ratio = scatter / np.sqrt(np.diag(stated.by_telemetry)[:6])
    assert ((ratio > 0.6) & (ratio < 1.6)).all()
