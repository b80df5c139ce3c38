"""A satellite whose wheels send their speeds at 4 Hz, as often as its computer commands them, under a gyro at 10 Hz."""

from __future__ import annotations

import numpy as np
import pandas as pd

import testbed as tb
from support.vectors import cross
from testbed.dynamics.inertia import theta_of

KEYS = {
    "platform.inertia_kg_m2": [[60.0, 0.0, 0.0], [0.0, 47.0, 0.0], [0.0, 0.0, 75.0]],
    "platform.mass_kg": 200.0,
    "actuators": [
        {
            "kind": "reaction_wheel",
            "array": "orthogonal",
            "mass_kg": 5.0,
            "spin_inertia_kg_m2": 0.03,
            "momentum_limit_N_m_s": 20.0,
            "torque_limit_N_m": 5.0,
        }
    ],
    "initial.wheel_momentum_N_m_s": [0.0, 0.0, 0.0],
    "gyro.noise_rad_s": 2.1e-4,
    "wheel_tachometer.noise_rad_s": 0.0,
    "estimation.estimators": ["output_error"],
    "estimation.initial_momentum": "estimated",
}
INERTIA = np.array([[62.0, 2.1, -3.2], [2.1, 45.0, 1.7], [-3.2, 1.7, 78.0]])
WHEEL, STEP, HELD = 0.03, 0.01, 25


def flown(seed: int) -> pd.DataFrame:
    """Return two minutes without noise; the motors' torque is held for 0.25 s, and shows nowhere but in the motion."""
    rng = np.random.default_rng(seed)
    frequency, phase = rng.uniform(0.1, 0.5, (3, 3)), rng.uniform(0.0, 2.0 * np.pi, (3, 3))
    body = np.linalg.inv(INERTIA - WHEEL * np.eye(3))
    rate, speed, torque = np.zeros(3), rng.uniform(80.0, 150.0, 3), np.zeros(3)

    def slope(rate, speed):
        turning = cross(rate, INERTIA @ rate + WHEEL * speed)
        return body @ (-torque - turning)

    rows = []
    for step in range(12_001):
        time = step * STEP
        if step % HELD == 0:
            wanted = 0.03 * np.sin(frequency * time + phase).sum(axis=1)
            torque = -(INERTIA @ (0.8 * (wanted - rate)) + cross(rate, INERTIA @ rate + WHEEL * speed))
        if step % 5 == 0:
            gyro = rate if step % 10 == 0 else np.full(3, np.nan)
            wheels = speed if step % HELD == 0 else np.full(3, np.nan)
            rows.append([time, *gyro, *wheels])
        middle = rate + 0.5 * STEP * slope(rate, speed)
        change = STEP * slope(middle, speed + 0.5 * STEP * torque / WHEEL)
        rate, speed = rate + change, speed + STEP * torque / WHEEL - change
    names = [f"body_rate_{axis}_rad_s" for axis in "xyz"] + [f"wheel_speed_{unit}_rad_s" for unit in (1, 2, 3)]
    return pd.DataFrame(rows, columns=["time_s", *names])


def test_torque_that_is_held_between_slow_samples_biases_no_estimate():
    """It put J off by 0.04 kg·m², sixty standard deviations by the gyro's noise: a spline stood for the chords."""
    records = tb.records_from({f"flight {seed}": flown(seed) for seed in (3, 4)}, gyro_noise_rad_s=2.1e-4)
    estimate = tb.estimate(tb.read_scenario("cubesat_wheels", KEYS), records)
    error = estimate.combined["output_error"].theta - theta_of(INERTIA)
    assert np.abs(error).max() < 0.01
    assert any("lie between samples of the actuators" in each for each in estimate.identification.notices)
