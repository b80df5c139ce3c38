"""Wheels' telemetry that is sampled between the instants at which commands change."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.arrays import Array
from testbed.cmg.wheels import Wheels
from testbed.estimation.telemetry import Telemetry, WheelMotors, WheelTelemetry
from testbed.prediction.command_phase import command_phase, with_command_phase

PERIOD, NOISE, SPIN, WHEELS = 0.1, 7.5e-7, 1.5e-5, 4  # s, N·m·s, kg·m²
MOTORS = WheelMotors(
    viscous_friction=np.zeros(WHEELS), coulomb_friction=np.zeros(WHEELS), loop_bandwidth=np.zeros(WHEELS), period=PERIOD
)
ARRAY = Wheels(
    axis_B=np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], np.full(3, 3.0**-0.5)]),
    spin_inertia=np.full(WHEELS, SPIN),
    momentum_limit=np.full(WHEELS, 0.1),
    torque_limit=np.full(WHEELS, 0.1),
)


def flown(phase: float, seed: int, lag: Array | None = None) -> Telemetry:
    """A minute of wheels that follow their commands, sampled so long a share of a period after these change."""
    rng = np.random.default_rng(seed)
    ticks = PERIOD * np.arange(601)
    command = 1e-3 * np.cos(0.9 * ticks[:, None] + np.arange(WHEELS)) + 5e-5 * rng.standard_normal((601, WHEELS))
    lag = np.zeros(WHEELS) if lag is None else lag
    behind = np.concatenate([np.zeros((1, WHEELS)), lag * np.diff(command, axis=0)])  # T (u_k - u_(k-1)), each period
    gained = command * PERIOD - behind
    at_ticks = 0.02 + np.concatenate([np.zeros((1, WHEELS)), np.cumsum(gained[:-1], axis=0)])
    momentum = at_ticks + phase * gained + NOISE * rng.standard_normal((601, WHEELS))
    return Telemetry(
        gyro_time=ticks + phase * PERIOD,
        body_rate=np.zeros((601, 3)),
        gyro_noise=4e-4,
        actuator_time=ticks + phase * PERIOD,
        gimbals=None,
        applied_torque=None,
        wheels=WheelTelemetry(wheels=ARRAY, momentum=momentum, torque_command=command, motors=MOTORS),
    )


@pytest.mark.parametrize("phase", [0.04, 0.3, 0.9])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_phase_of_the_commands_is_found(phase, seed):
    runs = with_command_phase([flown(phase, seed), flown(phase, seed + 10)])
    assert command_phase(runs) == pytest.approx(phase * PERIOD, abs=0.015 * PERIOD)  # two standard errors


@pytest.mark.parametrize("seed", range(20, 30))
def test_telemetry_on_the_commands_own_clock_is_left_as_it_is(seed):
    runs = [flown(0.0, seed)]
    assert with_command_phase(runs) == runs


def test_a_motor_that_lags_is_no_phase():
    for lag in (np.array([0.0, 0.0, 0.03, 0.0]), np.full(WHEELS, 0.03)):
        assert command_phase(with_command_phase([flown(0.0, 31, lag)])) == 0.0


def test_too_few_impulses_show_no_phase():
    whole = flown(0.3, 41)
    assert whole.wheels is not None
    short = whole.with_actuator_samples(whole.actuator_time[:30], lambda samples: samples[:30])
    assert command_phase(with_command_phase([short])) == 0.0
