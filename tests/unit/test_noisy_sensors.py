"""A table whose attitude sensor and tachometers have noise: neither puts a healthy estimate off, nor in doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import testbed as tb
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import nominal_body, nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis, evaluated
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.output_error import output_error
from testbed.estimation.surroundings import fused, sensor_noise
from testbed.estimation.telemetry_covariance import with_telemetry_noise
from testbed.estimation.telemetry_noise import with_more_noise
from testbed.records.selection import telemetry_only
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
    errors, stds, lags = [], [], []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        sent, quaternions = TIME[::5], with_noisy_attitude(TRUE[::5], rng)
        measured = RATE + BIAS + GYRO * rng.standard_normal(RATE.shape)
        found = fused(TIME, measured, sent, quaternions, noise=ATTITUDE, walk=GYRO * np.sqrt(0.02))
        apart = matrix_of(found.attitude.start) @ matrix_of(TRUE[0]).T
        errors.append([apart[2, 1], apart[0, 2], apart[1, 0]])
        stds.append(found.start_std)
        lags.append(found.lag / found.lag_std)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.mean(stds), rel=0.25)
    assert np.mean(stds) < 0.4 * ATTITUDE
    assert np.sqrt(np.mean(np.square(lags))) == pytest.approx(1.0, rel=0.35)  # of thirty numbers it scatters by 13 %
    assert sensor_noise(found.attitude, sent, quaternions) == pytest.approx(ATTITUDE, rel=0.2)


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


def test_the_turn_of_the_first_attitude_is_free_in_a_diagnosis(table):
    """An error of 9e-5 rad of it is a torque that five runs show."""
    scenario, _ = table
    records = [noisy(tb.fly(scenario, seed=seed).record, seed) for seed in (61, 62)]
    named = [replace(each, details=replace(each.details, name=f"run{at}")) for at, each in enumerate(records)]
    found = data_set_of([telemetry_only(each) for each in named], scenario, nominal_platform(scenario))
    both = [*found.runs.grid.runs, *found.heldout.grid.runs]
    assert all(0.0 < each.surroundings.start_std < 0.4 * ATTITUDE for each in both)
    theta = theta_of(nominal_platform(scenario).inertia)
    offset = Hypothesis(effect=EFFECTS["center_of_mass_offset"], component="platform")
    fit = fitted(found.runs, [offset], theta, [np.zeros(3)])
    assert fit.values.first_turn.shape == (1, 1, 3)
    turned = fit.values.first_turn[:, 0] / found.runs.first_turn_std[:, None]
    assert 0.0 < np.abs(turned).max() < 4.0
    error = scenario.environment.center_of_mass_offset_m + fit.effect_values - scenario.truth.center_of_mass_offset_m
    assert np.abs(error / np.sqrt(np.diag(fit.covariance))[6:9]).max() < 4.0
    step = 1e-6
    more = replace(fit.values, first_turn=fit.values.first_turn + np.array([step, 0.0, 0.0]))
    difference = (evaluated(found.runs, fit.placed, more).residual - fit.residual)[: -fit.believed] / step
    np.testing.assert_allclose(-fit.jacobian[: -fit.believed, 12], difference, atol=1e-3 * np.abs(difference).max())
