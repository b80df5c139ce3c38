"""What vouches for an estimate: each test accepts what is right as often as it says, and refuses what is wrong."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom, kstest

from support.synthetic_telemetry import (
    NOMINAL_THETA,
    TRUE_THETA,
    exact_telemetry,
    noisy,
    nominal_flight,
    sample_times,
    with_gimbals,
)
from testbed.estimation.agreement import REFUSED, runs_agreement
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.gyro_noise import gyro_noise_of, noise_freedom
from testbed.estimation.momentum_test import zero_momentum_p_value
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.residual_check import MOST_LOOKED_AT, checked_rows, residual_check
from testbed.experiment.checking import checks_of, considered
from testbed.report.doubts import estimation_doubts

TIMES = sample_times(16.0)
NOISE = 0.001658
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
REST = replace(exact_telemetry(nominal_flight(), TIMES, TIMES, NOISE), initial_momentum="zero")
SEEDS = range(100)


def flown(exact, seed):
    return noisy(exact, seed, 1e-4)


def checks(telemetry):
    by_name = {name: ESTIMATORS[name](telemetry, SETTINGS) for name in ("iv", "output_error")}
    return checks_of(considered(by_name, telemetry, SETTINGS), telemetry, SETTINGS)


@pytest.fixture(scope="module")
def sound():
    """Checks of flights in which all is as stated."""
    return [checks(flown(REST, seed)) for seed in SEEDS]


@pytest.mark.parametrize("what", ["size_p_value", "whiteness_p_value"])
def test_p_values_of_sound_residuals_are_uniform(sound, what):
    assert kstest([getattr(each.residual, what) for each in sound], "uniform").pvalue > 1e-3


def test_p_values_of_estimators_that_should_agree_are_uniform(sound):
    assert kstest([each.compared.agreement.p_value for each in sound], "uniform").pvalue > 1e-3


def test_p_values_of_a_zero_momentum_are_uniform():
    values = []
    for seed in SEEDS:
        telemetry = flown(REST, seed)
        values.append(zero_momentum_p_value(telemetry, ESTIMATORS["output_error"](telemetry, SETTINGS).theta))
    assert kstest(values, "uniform").pvalue > 1e-3


def test_runs_of_one_platform_agree_as_often_as_chance_has_it():
    estimates = [ESTIMATORS["output_error"](flown(REST, seed), SETTINGS) for seed in range(150)]
    values = [runs_agreement(estimates[first : first + 3]).p_value for first in range(0, 150, 3)]
    assert kstest(values, "uniform").pvalue > 1e-3


def test_a_run_of_another_platform_is_found():
    estimates = [ESTIMATORS["output_error"](flown(REST, seed), SETTINGS) for seed in range(3)]
    other = replace(estimates[2], theta=estimates[2].theta + 8.0 * estimates[2].std)
    agreement = runs_agreement([*estimates[:2], other])
    assert agreement.refused
    assert agreement.excess > 1.0
    assert runs_agreement(estimates).excess == 0.0


def test_what_is_considered_in_common_does_not_make_runs_differ():
    estimates = [ESTIMATORS["output_error"](flown(REST, seed), SETTINGS) for seed in range(3)]
    shift = 50.0 * np.outer(estimates[0].std, [1.0])
    moved = [replace(each, theta=each.theta + shift[:, 0], considered=shift) for each in estimates]
    assert not runs_agreement(moved).refused


def test_noise_that_is_larger_than_stated_is_found():
    assert checks(replace(flown(REST, 1), gyro_noise=NOISE / 1.3)).residual.size_p_value < REFUSED


def test_a_gyro_that_drifts_leaves_a_residual_that_is_not_white():
    telemetry = flown(REST, 1)
    drift = 4.0 * NOISE * np.sin(2.0 * np.pi * TIMES / 1.3)[:, None] * np.array([1.0, 0.0, 0.0])
    assert checks(replace(telemetry, body_rate=telemetry.body_rate + drift)).residual.whiteness_p_value < REFUSED


def test_a_doubtful_residual_is_first_asked_for_a_trim_where_none_is_estimated(sound):
    """Of a healthy quadcopter `testbed estimate` sent one to a diagnosis, which found nothing but the trim."""
    doubtful = checks(replace(flown(REST, 1), gyro_noise=NOISE / 1.3))
    assert doubtful.neglected
    assert 'try estimation.constant_torque = "body" first' in doubts_of(doubtful)[-1]
    estimated = replace(doubtful, neglected=())
    assert not any("constant_torque" in each for each in doubts_of(estimated))
    assert not any("constant_torque" in each for each in doubts_of(sound[0]))


def test_what_is_rare_of_one_record_is_not_of_forty(sound):
    """One record of 40 with p = 0.0008 put all of them in doubt."""
    (found, *_) = sound
    rare = replace(found, residual=replace(found.residual, whiteness_p_value=0.8 * REFUSED))
    one = SimpleNamespace(checks=rare, by_name={})
    assert any("not white" in each for each in estimation_doubts(one))
    assert not any("not white" in each for each in estimation_doubts(one, 40))


def test_noise_that_nobody_stated_is_not_said_to_be_stated_too_large(sound):
    """Of a walk beside no noise at all, which is all that differences show, `gyro.noise_rad_s` was to be corrected."""
    (found, *_) = sound
    small = replace(found.residual, size=0.6)
    (stated,) = doubts_of(replace(found, residual=small))
    (shown,) = doubts_of(replace(found, residual=replace(small, noise_is_stated=False)))
    assert "stated too large" in stated
    assert "stated too large" not in shown
    assert "gyro_noise_rad_s beside the record" in shown


def doubts_of(found):
    return list(estimation_doubts(SimpleNamespace(checks=found, by_name={})))


def test_a_momentum_that_is_taken_for_zero_is_found():
    spinning = exact_telemetry(nominal_flight(np.array([0.0005, 0.0, 0.0])), TIMES, TIMES, NOISE)
    telemetry = flown(replace(spinning, initial_momentum="zero"), 3)
    theta = ESTIMATORS["output_error"](telemetry, SETTINGS).theta
    assert zero_momentum_p_value(telemetry, theta) < 1e-6


def test_a_residual_that_uncertain_actuators_explain_is_accepted():
    rng = np.random.default_rng(2)
    errors = NOISE * np.sin(np.outer(np.arange(240.0), [0.03, 0.05, 0.07]))
    residual = NOISE * rng.standard_normal(240) + errors @ np.array([2.0, -1.5, 1.0])
    found = residual_check(residual.reshape(-1, 3), np.full(3, NOISE), 2.0 * errors, 0, np.inf)
    blind = residual_check(residual.reshape(-1, 3), np.full(3, NOISE), np.zeros((240, 0)), 0, np.inf)
    assert found.size_p_value > 0.01
    assert found.whiteness_p_value > 0.01
    assert blind.size_p_value < REFUSED


def test_long_records_are_tested_in_blocks():
    rows = checked_rows(2_000_000)
    assert len(rows) == MOST_LOOKED_AT
    assert rows[0] == 0
    assert rows[-1] == 1_999_999
    assert np.mean(np.diff(rows) == 1) > 0.99


@pytest.mark.parametrize("samples", [64, 300])
def test_noise_that_samples_show_is_as_certain_as_stated(samples):
    """Of 1,000 series, the variance's own variance lies within four standard errors of what its freedom says."""
    rng, time = np.random.default_rng(3), np.arange(samples) / 16.0
    variance = np.array([gyro_noise_of(time, rng.standard_normal((samples, 3))) ** 2 for _ in range(1000)])
    freedom = 2.0 * variance.mean() ** 2 / variance.var()
    assert freedom == pytest.approx(noise_freedom(time), rel=4.0 * np.sqrt(2.0 / 1000))


def test_intervals_hold_the_truth_with_uncertain_rotors():
    """With each rotor 1 % off, intervals by noise alone hold the truth in few flights, whole ones in 95 %."""
    from testbed.estimation.uncertainty import Uncertainty

    settings = replace(SETTINGS, uncertainty=Uncertainty(rotor_momentum=0.01))
    exact = replace(REST, initial_momentum="estimated")
    whole, noise = [], []
    for seed in range(120):
        rng = np.random.default_rng(seed)
        momentum = exact.gimbals.cluster.rotor_momentum * (1.0 + 0.01 * rng.standard_normal(6))
        telemetry = flown(with_gimbals(exact, cluster=replace(exact.gimbals.cluster, rotor_momentum=momentum)), seed)
        raw = {"output_error": ESTIMATORS["output_error"](telemetry, settings)}
        estimate = considered(raw, telemetry, settings)["output_error"]
        error = np.abs(estimate.theta - TRUE_THETA)
        whole.append(error < 1.96 * estimate.std)
        noise.append(error < 1.96 * estimate.noise_std)
    for hits in np.sum(whole, axis=0):
        assert binom.cdf(hits, 120, 0.95) > 1e-3
        assert binom.sf(hits - 1, 120, 0.95) > 1e-3
    assert np.mean(noise) < 0.6
