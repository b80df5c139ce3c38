"""Inertia and centre of mass together, on a pivot: exact without noise, slopes as differences, bound, attitude."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.diagnosis.windows import attitude_notices
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.estimation.bound import cramer_rao_bound, rate_columns
from testbed.estimation.motion import drive_of, simulate, with_torque
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.surroundings import integrated
from testbed.estimation.telemetry import covered_part
from testbed.estimation.uncertainty import USUAL
from testbed.experiment.conduct import conduct
from testbed.experiment.experiment import Experiment
from testbed.experiment.running_estimators import run_estimators
from testbed.rotation.quaternion import exponential, matrix_of, quaternion_inverse, quaternion_product, turned
from testbed.scenario.body import BodyScenario
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario


@cache
def scenario() -> Scenario:
    """The first fifteen seconds of the shipped table without noise, its centre of mass farther off than shipped."""
    shipped = read_scenario(shipped_scenario("air_bearing"))
    keys = shipped.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    keys["gyro"] = {"sample_rate_hz": 50.0, "noise_rad_s": 0.0}
    keys["wheel_tachometer"] = {"noise_rad_s": 0.0}
    keys["truth"]["center_of_mass_offset_m"] = [1.4e-4, -1.0e-4, -4e-4]
    keys["environment"]["center_of_mass_offset_m"] = [1.2e-4, -1.1e-4, -3e-4]
    keys["simulation"] |= {"duration_s": 15.0, "control_rate_hz": 200.0, "telemetry_rate_hz": 200.0}
    return Scenario.model_validate(keys)


@cache
def flight() -> Experiment:
    return conduct(scenario(), seed=1)


@cache
def telemetry():
    return covered_part(telemetry_of(flight().flown.record, scenario(), nominal_platform(scenario())))


def truth():
    """θ about the pivot, momentum about it at the first sample, and what acts beside what is believed."""
    true, channels = true_platform(scenario()), flight().flown.record.channels
    momentum_B = turned(quaternion_inverse(channels["true_attitude"][0]), channels["true_total_momentum"][0])
    return theta_of(true.turned_inertia), momentum_B, true.environment.offset_B - telemetry().pivot.offset_B


def test_the_true_inertia_and_offset_predict_the_flight():
    theta, momentum_B, acting = truth()
    motion = simulate(with_torque(drive_of(telemetry()), acting), theta, momentum_B)
    np.testing.assert_allclose(motion.body_rate, telemetry().body_rate, atol=2e-6)
    assert np.abs(simulate(drive_of(telemetry()), theta, momentum_B).body_rate - motion.body_rate).max() > 1e-3


def test_a_long_run_is_integrated_by_machine_code_to_the_same_motion(monkeypatch):
    theta, momentum_B, acting = truth()
    drive = with_torque(drive_of(telemetry()), acting)
    plain = simulate(drive, theta, momentum_B)
    monkeypatch.setattr("testbed.estimation.motion.LONG", 10)
    np.testing.assert_array_equal(simulate(drive, theta, momentum_B).momentum_B, plain.momentum_B)


def test_slopes_agree_with_differences():
    theta, momentum_B, acting = truth()
    run, at = telemetry(), np.concatenate([theta, momentum_B, acting])

    def rates(unknowns):
        drive = with_torque(drive_of(run), unknowns[9:])
        return simulate(drive, unknowns[:6], unknowns[6:9])

    drive = with_torque(drive_of(run), acting)
    exact = rate_columns(run, drive, rates(at)).reshape(-1, 3, 12)
    for index, size in enumerate([1e-5] * 9 + [1e-7] * 3):
        step = size * np.eye(12)[index]
        difference = (rates(at + step).body_rate - rates(at - step).body_rate) / 2.0
        np.testing.assert_allclose(size * exact[..., index], difference, atol=5e-10)


@pytest.mark.parametrize(("name", "close"), [("output_error", 1e-5), ("iv_momentum", 1e-3), ("iv", 1e-3), ("ls", 1e-3)])
def test_an_estimator_finds_both(name, close):
    part = replace(telemetry(), gyro_noise=1e-6)
    settings = estimation_settings(scenario(), nominal_platform(scenario()), maneuver=None)
    estimate = ESTIMATORS[name](part, settings).about_center_of_mass(part.pivot)
    true = true_platform(scenario())
    np.testing.assert_allclose(estimate.theta, theta_of(true.inertia), atol=close)
    np.testing.assert_allclose(
        part.pivot.offset_B + estimate.offset_error, true.environment.offset_B, atol=close * 1e-3
    )


def test_the_bound_is_of_inertia_and_offset_and_what_is_considered_widens_both():
    part = replace(telemetry(), gyro_noise=4e-4)
    theta, momentum_B, acting = truth()
    bound = np.sqrt(np.diag(cramer_rao_bound(part, theta, momentum_B, acting)))
    assert bound.shape == (9,)
    assert (bound[6:] > 1e-9).all()
    assert (bound[6:] < 1e-5).all()
    settings = replace(estimation_settings(scenario(), nominal_platform(scenario()), maneuver=None), uncertainty=USUAL)
    quiet = scenario().model_copy(
        update={"estimation": scenario().estimation.model_copy(update={"estimators": ("output_error",)})}
    )
    estimate = run_estimators(quiet, part, settings, checked=False).by_name["output_error"]
    assert (estimate.offset_std > np.sqrt(np.diag(estimate.offset_covariance))).all()


def test_a_recorded_attitude_is_used_in_place_of_the_gyros_integral():
    """An attitude that was recorded tilted by 0.1 rad would be found in the offset."""
    record = flight().flown.record
    seen = replace(record, channels=record.channels | {"attitude": record.channels["true_attitude"]})
    first = np.full_like(record.channels["true_attitude"], np.nan)
    first[0] = record.channels["true_attitude"][0]
    started = replace(record, channels=record.channels | {"attitude": first})
    nominal, time = nominal_platform(scenario()), np.array([3.0, 9.0])
    by_sensor, by_gyro = (telemetry_of(each, scenario(), nominal).surroundings for each in (seen, started))
    assert by_sensor.measured
    assert not by_gyro.measured
    np.testing.assert_allclose(by_sensor.up_B(time), by_gyro.up_B(time), atol=1e-5)
    part = replace(covered_part(telemetry_of(seen, scenario(), nominal)), gyro_noise=1e-6)
    estimate = ESTIMATORS["output_error"](part, estimation_settings(scenario(), nominal, maneuver=None))
    true = true_platform(scenario()).environment.offset_B
    np.testing.assert_allclose(part.pivot.offset_B + estimate.offset_error, true, atol=1e-8)


@pytest.mark.parametrize("noise", [0.0, 5e-4])
def test_a_sensor_that_is_late_and_wrong_at_times_moves_no_estimate(noise):
    """By 40 ms, the tilt that it shows is of where the table was; one wrong sample in the exact one is a torque."""
    record, generator = flight().flown.record, np.random.default_rng(7)
    times, true = record.time, record.channels["true_attitude"]
    seen = CubicSpline(times, true)(times - 0.04)
    for index in range(len(seen)):
        seen[index] = quaternion_product(exponential(noise * generator.standard_normal(3)), seen[index])
    seen[[400, 420, 1200]] = true[0]
    seen[times < 0.04] = np.nan  # before it is switched on
    rates = record.channels["body_rate"]
    noisy = rates + generator.normal(0.0, 4e-4, rates.shape)
    late = replace(record, channels=record.channels | {"attitude": seen, "body_rate": noisy})
    around = telemetry_of(late, scenario(), nominal_platform(scenario())).surroundings
    assert around.left_out == 3
    assert around.lag == pytest.approx(0.04, abs=1e-3)
    assert np.abs(around.up_B(times) - matrix_of(true)[:, 2]).max() < 1e-3
    said = list(attitude_notices(telemetry_of(late, scenario(), nominal_platform(scenario()))))
    assert said[0] == "3 samples of the attitude are far from those beside it, and not used"
    assert said[1].endswith("ms later than the gyro: compared so")


def test_a_sensor_on_time_is_taken_as_it_is():
    record = flight().flown.record
    exact = replace(record, channels=record.channels | {"attitude": record.channels["true_attitude"]})
    around = telemetry_of(exact, scenario(), nominal_platform(scenario())).surroundings
    assert (around.lag, around.left_out, around.start_std) == (0.0, 0, 0.0)


def test_a_measured_platform_without_any_attitude_is_refused():
    keys = scenario().model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    body = BodyScenario.model_validate(
        {key: keys[key] for key in keys if key in BodyScenario.model_fields or key == "schema"}
    )
    with pytest.raises(InputError, match="nothing says how it stood: give the columns attitude_w to attitude_z"):
        telemetry_of(flight().flown.record, body, nominal_platform(scenario()))


@pytest.mark.parametrize("name", ["iv", "iv_momentum"])
def test_the_noise_of_a_linear_equation_is_that_of_gravity_along_the_noisy_attitude_too(name):
    """θ̂ and the offset with noise on the gyro, against their influence: to first order they are the same."""
    run = replace(telemetry(), gyro_noise=1e-6)
    settings = replace(
        estimation_settings(scenario(), nominal_platform(scenario()), maneuver=None), instrument="nominal"
    )
    noise = 1e-7 * np.random.default_rng(3).standard_normal(run.body_rate.shape)

    def with_noise(sign: float):
        rate = run.body_rate + sign * noise
        around = replace(run.surroundings, attitude=integrated(run.gyro_time, rate, run_start()))
        return ESTIMATORS[name](replace(run, body_rate=rate, surroundings=around), settings)

    more, less = with_noise(1.0), with_noise(-1.0)
    moved = np.concatenate([more.theta - less.theta, more.offset_error - less.offset_error]) / 2.0
    expected = ESTIMATORS[name](run, settings).influence @ noise.ravel()
    scale = np.sqrt(1e-14 * np.sum(ESTIMATORS[name](run, settings).influence ** 2, axis=1))
    np.testing.assert_allclose(moved / scale, expected / scale, atol=0.1)


def run_start():
    return np.array(scenario().initial.attitude_quat_NB)


def test_output_error_states_the_bound_where_the_believed_offset_is_wrong():
    """The slopes are those of the offset that is found: of the believed one, deviations would be 10 % off."""
    noise = 4e-4 * np.random.default_rng(7).standard_normal(telemetry().body_rate.shape)
    part = replace(telemetry(), gyro_noise=4e-4, body_rate=telemetry().body_rate + noise)
    settings = estimation_settings(scenario(), nominal_platform(scenario()), maneuver=None)
    estimate = ESTIMATORS["output_error"](part, settings)
    theta, momentum_B, acting = truth()
    bound = np.sqrt(np.diag(cramer_rao_bound(part, theta, momentum_B, acting)))
    stated = np.concatenate([estimate.noise_std, np.sqrt(np.diag(estimate.offset_covariance))])
    np.testing.assert_allclose(stated / estimate.residual_sigma, bound / 4e-4, rtol=0.01)
