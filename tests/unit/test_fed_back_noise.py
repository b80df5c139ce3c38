"""A satellite whose controller feeds the gyro's noise back: that makes no late gyro."""

from __future__ import annotations

import numpy as np
import pytest

from support.thrusters import body_scenario
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.record import Record, RunDetails

NOISE, TACHOMETER, PERIOD, SECONDS = 4e-4, 0.05, 0.05, 30.0
INERTIA, SPIN_INERTIA = np.array([0.035, 0.034, 0.009]), 1.5e-5
GAIN = 1.4
"""1/s, of the rate: a sample's noise is turned against by a fourteenth of it until the next one."""
WHEEL = """
[[actuators]]
kind = "reaction_wheel"
axis = {axis}
mass_kg = 0.06
spin_inertia_kg_m2 = 1.5e-5
momentum_limit_N_m_s = 0.01
torque_limit_N_m = 0.001
"""
SCENARIO = """
schema = 1
name = "satellite"
description = "Three wheels at right angles."
seed = 1

[platform]
inertia_kg_m2 = [[0.035, 0.0, 0.0], [0.0, 0.034, 0.0], [0.0, 0.0, 0.009]]
mass_kg = 4.0

[gyro]
sample_rate_hz = 20.0
noise_rad_s = 4e-4

[estimation]
""" + "".join(WHEEL.format(axis=axis) for axis in np.eye(3).tolist())


def run(seed: int) -> Record:
    """Turn by wheels without momentum in all, J ω = -h, whose torques hold from sample to sample.

    About each axis for itself: without momentum nothing couples them.
    """
    rng = np.random.default_rng(seed)
    time = PERIOD * np.arange(round(SECONDS / PERIOD))
    frequency, phase = rng.uniform(0.3, 1.2, (2, 3, 2)), rng.uniform(0.0, 6.0, (3, 2))
    wanted = 0.06 * np.sin(frequency[0] * time[:, None, None] + phase).sum(axis=-1)
    error = NOISE * rng.standard_normal(wanted.shape)
    slope, without_wheel = np.gradient(wanted, PERIOD, axis=0), INERTIA - SPIN_INERTIA
    rate, rates, torques = wanted[0], np.empty_like(wanted), np.empty_like(wanted)
    for index in range(len(time)):
        rates[index] = rate
        torques[index] = -without_wheel * (GAIN * (wanted[index] - rate - error[index]) + slope[index])
        rate = rate - PERIOD * torques[index] / without_wheel
    speed = -INERTIA * rates / SPIN_INERTIA + TACHOMETER * rng.standard_normal(rates.shape)
    channels = {"body_rate": rates + error, "wheel_speed": speed, "wheel_torque_command": torques}
    return Record(time=time, channels=channels, details=RunDetails(name=f"run{seed}", gyro_noise=NOISE))


def data_of(seeds):
    scenario = body_scenario(SCENARIO, "satellite.toml")
    nominal = nominal_body(scenario)
    return data_set_of([run(seed) for seed in seeds], scenario, nominal), theta_of(nominal.inertia)


@pytest.mark.parametrize("seed", [100, 200, 300])
def test_a_gyro_whose_noise_is_fed_back_is_not_late(seed):
    """By splines, whose slope at a sample is half of what follows, it was by 3 standard errors and more."""
    data, theta = data_of(range(seed, seed + 6))
    assert data.runs.grid.momentum_held
    late = Hypothesis(effect=EFFECTS["gyro_latency"], component="gyro")
    fit = fitted(data.runs, [late], theta, [np.array([1e-3])])
    (value,) = fit.effect_values
    assert value < 2.0 * np.sqrt(fit.covariance[6, 6])
