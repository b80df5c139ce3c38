"""The gyro's noise, estimated from all of a residual that is white, otherwise from its fastest changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.effects.fast_changes import noise_ratio, variance_ratio
from testbed.effects.gyro_noise import GyroNoise
from testbed.effects.noise_effect import Readings
from testbed.estimation.telemetry import Telemetry

ALL = np.ones(3, dtype=bool)
SAMPLES, PARAMETERS = 400, 9


def run_of(residual):
    time = np.arange(float(len(residual)))
    return Telemetry(gyro_time=time, body_rate=residual, gyro_noise=2.0, actuator_time=time, gimbals=None)


def readings(residual, white=True):
    return Readings(
        measured=[residual],
        residual=[residual],
        sigma=np.full((1, 3), 2.0),
        runs=[run_of(residual)],
        inertia=np.eye(3),
        parameters=PARAMETERS,
        white=white,
    )


def noise(seed):
    return 2.0 * np.random.default_rng(seed).normal(size=(SAMPLES, 3))


def test_white_noise_is_estimated_from_all_of_the_residual():
    ratios = [noise_ratio(readings(1.2 * noise(seed)), ALL) for seed in range(40)]
    ratio, freedom = np.transpose(ratios)
    usual = 3 * SAMPLES - PARAMETERS
    assert np.median(freedom) == usual
    assert abs(ratio.mean() - 1.44) < 4.0 * 1.44 * np.sqrt(2.0 / usual / 40)
    fast = [variance_ratio(readings(1.2 * noise(seed)), ALL)[0] for seed in range(40)]
    assert ratio.std() < 0.85 * np.std(fast)


def test_no_noise_is_beyond_one_that_nobody_states():
    loud = readings(1.5 * noise(6))
    assert GyroNoise().found("gyro", loud).p_value < 1e-6
    assert GyroNoise().found("gyro", replace(loud, stated=False)) is None


def test_what_is_slow_is_not_taken_for_noise():
    slow = 2.0 * np.sin(np.linspace(0.0, 12.0, SAMPLES))[:, None] * np.array([1.0, 1.0, 1.0])
    moved = readings(noise(1) + slow)
    assert noise_ratio(moved, ALL) == variance_ratio(moved, ALL)
    assert noise_ratio(moved, ALL)[0] < 1.2


def test_noise_of_one_axis_takes_its_share_of_the_parameters():
    residual = noise(3) * np.array([1.5, 1.0, 1.0])
    ratio, freedom = noise_ratio(readings(residual), np.array([True, False, False]))
    assert freedom == SAMPLES - PARAMETERS / 3
    assert 1.8 < ratio < 2.8


def test_until_all_else_is_explained_only_the_fastest_changes_count():
    early = readings(1.2 * noise(5), white=False)
    assert noise_ratio(early, ALL) == variance_ratio(early, ALL)
