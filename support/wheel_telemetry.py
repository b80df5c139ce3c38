"""Telemetry of four wheels that follow their commands, on a body at rest."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Units
from testbed.cmg.wheels import Wheels
from testbed.estimation.telemetry import Telemetry, WheelMotors, WheelTelemetry

PERIOD, NOISE, SPIN, WHEELS, TICKS = 0.1, 7.5e-7, 1.5e-5, 4, 601  # s, N·m·s, kg·m²
MOTORS = WheelMotors(
    viscous_friction=np.zeros(WHEELS), coulomb_friction=np.zeros(WHEELS), loop_bandwidth=np.zeros(WHEELS), period=PERIOD
)
ARRAY = Wheels(
    axis_B=np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], np.full(3, 3.0**-0.5)]),
    spin_inertia=np.full(WHEELS, SPIN),
    momentum_limit=np.full(WHEELS, 0.1),
    torque_limit=np.full(WHEELS, 0.1),
)
ONE_WAY = np.full(WHEELS, 0.02)
"""N·m·s, from which a wheel never turns round: its commands change its momentum by a tenth of it."""


def commanded_wheels(phase: float, seed: int, lag: Units | None = None, start: Units = ONE_WAY) -> Telemetry:
    """Return a minute of wheels that follow their commands.

    Args:
        phase: share of a period by which these change before they are sampled.
        seed: of the commands and of the tachometers' noise.
        lag: of the motors, shape (4,), s; none where absent.
        start: momenta at first, shape (4,), N·m·s.
    """
    rng = np.random.default_rng(seed)
    ticks = PERIOD * np.arange(TICKS)
    command = 1e-3 * np.cos(0.9 * ticks[:, None] + np.arange(WHEELS)) + 5e-5 * rng.standard_normal((TICKS, WHEELS))
    lag = np.zeros(WHEELS) if lag is None else lag
    behind = np.concatenate([np.zeros((1, WHEELS)), lag * np.diff(command, axis=0)])  # T (u_k - u_(k-1)), each period
    gained = command * PERIOD - behind
    at_ticks = start + np.concatenate([np.zeros((1, WHEELS)), np.cumsum(gained[:-1], axis=0)])
    momentum = at_ticks + phase * gained + NOISE * rng.standard_normal((TICKS, WHEELS))
    return wheels_at_rest(momentum, command, ticks + phase * PERIOD)


def undersampled_wheels(periods: int, seed: int, scatter: float = 5e-5, rates: tuple[float, ...] = (0.9,)) -> Telemetry:
    """Return two minutes of wheels whose commands change so many times between samples, each with noise of its own.

    Args:
        periods: between samples.
        seed: of all noise.
        scatter: standard deviation of the commands' noise, N·m.
        rates: at which they swing, rad/s.
    """
    rng = np.random.default_rng(seed)
    ticks = PERIOD / periods * np.arange(2 * TICKS * periods)
    smooth = sum(1e-3 * np.cos(rate * ticks[:, None] + np.arange(WHEELS)) for rate in rates)
    command = smooth + scatter * rng.standard_normal(smooth.shape)
    momentum = ONE_WAY + np.concatenate([np.zeros((1, WHEELS)), np.cumsum(command * PERIOD / periods, axis=0)[:-1]])
    shown = momentum[::periods] + NOISE * rng.standard_normal((2 * TICKS, WHEELS))
    return wheels_at_rest(shown, command[::periods], ticks[::periods])


def wheels_at_rest(momentum: Array, command: Array, time: Array) -> Telemetry:
    """Return telemetry of wheels on a body at rest, momenta and commands of shape (K, 4), N·m·s and N·m."""
    return Telemetry(
        gyro_time=time,
        body_rate=np.zeros((len(time), 3)),
        gyro_noise=4e-4,
        actuator_time=time,
        gimbals=None,
        applied_torque=None,
        wheels=WheelTelemetry(wheels=ARRAY, momentum=momentum, torque_command=command, motors=MOTORS),
    )
