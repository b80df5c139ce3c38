"""Flights of a craft with wheels, whose speeds are commanded open-loop as a planned motion of the nominal one needs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from concealing.craft import Array, cross
from concealing.flight import Clock, Instruments, Trace, through_period
from concealing.inner_effects import point_inertia
from concealing.library import with_effects
from concealing.sensors import Noise, draw_noise
from concealing.wheel_case import WheelCase, WheelPlatform, WheelRun, platform_of
from concealing.wheels import WheelCraft, WheelInputs, WheelMechanics, wheel_craft

_ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
_NOISE, _WHEELS, _BIAS, _EPOCH, _ANGLE = 0, 10, 11, 12, 13
"""Purposes of a case's random numbers; 3 to 5 are those of `concealing.sealing`."""
SPEED_GAIN = 1.0
"""1/s, of the loop that holds the wheels' speeds: a tenth of the slower platform's control rate."""
_TONES = 3
_FREE = (np.array([0.5, 0.5, 0.8]), (0.015, 0.045))
_STANDING = (np.array([0.1, 0.1, 0.4]), (0.03, 0.15))
"""rad about each axis, and Hz between which the sines lie, before limits: some turns of the CubeSat's shipped maneuver
in a minute, tilts of the table's as it is shipped."""
_USED = 0.7
"""Share of the wheels' limits and of the tilt limit that a planned motion uses at most: what is hidden has the rest."""
_TRIES = 6
"""Of making a motion smaller until it keeps the limits; the share that it uses is nearly in proportion to it."""
_ROLLED_IN = 3.0
"""s in which the motion of a craft that is released at rest sets in."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What the wheels of a run are commanded, at the control ticks.

    Attributes:
        speed: of the wheels, (K, W), rad/s.
        released: body rate at release, (3,), rad/s.
    """

    speed: Array
    released: Array


@dataclass(frozen=True, kw_only=True)
class WheelLog:
    """What happened, one row per control tick, K in all, of B runs.

    Attributes:
        time: (K,), s.
        gyro: (K, B, 3), rad/s; NaN between samples.
        body_rate: true, (K, B, 3), rad/s.
        wheel_speed: true, (K, B, W), rad/s.
        reading: of the tachometers on board, (K, B, W), rad/s.
        command: from each tick on, (K, B, W), N·m.
        torque: that the motors' currents show at the end of the period before, (K, B, W), N·m.
        state: (K, B, n).
    """

    time: Array
    gyro: Array
    body_rate: Array
    wheel_speed: Array
    reading: Array
    command: Array
    torque: Array
    state: Array


@dataclass(frozen=True, kw_only=True)
class FlownWheels:
    """The flights of a case; runs that are shorter than the longest have to be cut.

    Attributes:
        case: as ordered.
        platform: nominal.
        craft: as flown.
        mechanics: the equations.
        clock: ticks of the longest run.
        log: of all runs side by side.
    """

    case: WheelCase
    platform: WheelPlatform
    craft: WheelCraft
    mechanics: WheelMechanics
    clock: Clock
    log: WheelLog

    @property
    def rows(self) -> list[Array]:
        """Ticks of each run's gyro samples."""
        period, every = self.clock.period, self.clock.gyro_ticks
        return [np.arange(0, round(run.duration / period) + 1, every) for run in self.case.runs]


def true_craft(case: WheelCase) -> WheelCraft:
    """Return the craft with its own inertia and all hidden effects."""
    platform, error = platform_of(case.scenario), np.zeros((3, 3))
    for (row, column), value in zip(_ENTRIES, case.theta_error, strict=True):
        error[row, column] = error[column, row] = value
    bare = wheel_craft(platform.inertia + error, platform.mass, platform.wheels, platform.pivot)
    return with_effects(bare, case.effects, platform.kinds)


def theta(craft: WheelCraft) -> list[float]:
    """Return J11, J22, J33, J23, J13, J12 about the centre of mass, kg·m²."""
    return [float(craft.inertia[entry]) for entry in _ENTRIES]


def fly_wheels(case: WheelCase, *, quiet: bool = False, refinement: float = 1.0) -> FlownWheels:
    """Fly all runs of a case.

    Args:
        case: what to fly.
        quiet: without any noise of the sensors, on board and recorded.
        refinement: of the integrator's steps.
    """
    platform, craft = platform_of(case.scenario), true_craft(case)
    if quiet:
        quiet_gyro = replace(craft.gyro, extra_noise=np.zeros(3))
        platform, craft = replace(platform, sensors=platform.sensors.quiet()), replace(craft, gyro=quiet_gyro)
    clock = _clock(case, platform)
    plans = [planned(platform, run, clock) for run in case.runs]
    runs, speed = len(plans), np.stack([plan.speed for plan in plans], axis=1)
    mechanics = WheelMechanics(
        craft=craft,
        epoch=np.random.default_rng([case.seed, _EPOCH]).uniform(0.0, 100.0, runs),
        release_attitude=np.broadcast_to(np.eye(3), (runs, 3, 3)),
        wheel_speed=speed[0],
        wheel_angle=np.random.default_rng([case.seed, _ANGLE]).uniform(
            0.0, 2.0 * np.pi, (runs, len(platform.wheels.axis))
        ),
    )
    released = np.stack([plan.released + run.release_error for plan, run in zip(plans, case.runs, strict=True)])
    state = mechanics.start(released, np.zeros((runs, 0)))
    log = _flown(mechanics, state, speed, clock, platform, _noise(case, platform, craft, clock), refinement)
    return FlownWheels(case=case, platform=platform, craft=craft, mechanics=mechanics, clock=clock, log=log)


class _WheelNoise(NamedTuple):
    """Standard normal numbers: the gyro's, and the tachometers' on board, (K, B, W)."""

    gyro: Noise
    tachometer: Array


def _clock(case: WheelCase, platform: WheelPlatform) -> Clock:
    longest = max(run.duration for run in case.runs)
    return Clock(
        period=1.0 / platform.control_rate,
        ticks=round(longest * platform.control_rate),
        gyro_ticks=round(platform.control_rate / platform.gyro_rate),
    )


def _flown(
    mechanics: WheelMechanics,
    state: Array,
    speed: Array,
    clock: Clock,
    platform: WheelPlatform,
    noise: _WheelNoise,
    refinement: float,
) -> WheelLog:
    """Fly to the end of the clock, the torques held between its ticks."""
    trace, wheels = Trace(mechanics, clock, state), mechanics.craft.wheels
    instruments = Instruments(mechanics=mechanics, trace=trace, clock=clock, sensors=platform.sensors, noise=noise.gyro)
    # The motors were moving the wheels along the plan before the release.
    torque, rows = platform.wheels.spin_inertia * (speed[1] - speed[0]) / clock.period, []
    commands: list[Array] = []
    for tick, time in enumerate(clock.times):
        shown, true = instruments.gyro(tick, state), mechanics.speeds(time, state)
        read = true + wheels.speed_bias + platform.sensors.tachometer_noise * noise.tachometer[tick]
        command = _command(platform, speed, tick, read, clock.period)
        body_rate = mechanics.velocities(time, state).body_rate
        gyro = np.full_like(body_rate, np.nan) if shown is None else shown
        row = {"gyro": gyro, "body_rate": body_rate, "wheel_speed": true, "command": command, "torque": torque}
        rows.append(row | {"reading": read, "state": state})
        if tick < clock.ticks:
            commands.append(np.clip(command, -wheels.torque_limit, wheels.torque_limit))
            asked = _heard(commands, wheels.late / clock.period)
            inputs = WheelInputs(asked, torque, time)
            state = through_period(mechanics, trace, state, time, clock.period, inputs, refinement)
            torque = mechanics.current(time + clock.period, inputs)
    return WheelLog(time=clock.times, **{name: np.array([row[name] for row in rows]) for name in rows[0]})


def _heard(commands: list[Array], late: float) -> Array:
    """Return what motors hear that answer so many periods late, (B, W), N·m: its mean where that changes in between."""
    whole, part = int(late), late % 1.0
    newer, older = (commands[max(len(commands) - 1 - whole - more, 0)] for more in (0, 1))
    return (1.0 - part) * newer + part * older


def _command(platform: WheelPlatform, speed: Array, tick: int, read: Array, period: float) -> Array:
    """Return Js (ΔΩ_ref / T + k (Ω_ref - Ω̄)), (B, W), N·m."""
    ahead = speed[min(tick + 1, len(speed) - 1)]
    return platform.wheels.spin_inertia * ((ahead - speed[tick]) / period + SPEED_GAIN * (speed[tick] - read))


def _noise(case: WheelCase, platform: WheelPlatform, craft: WheelCraft, clock: Clock) -> _WheelNoise:
    """Draw the noise of all sensors; that of the gyro has a wandering bias in it, and a colour where one is hidden."""
    rows, runs = clock.ticks + 1, len(case.runs)
    white = draw_noise(np.random.SeedSequence(case.seed, spawn_key=(_NOISE,)), rows, runs, 0, clock.period)
    gyro, each = white.gyro.copy(), clock.gyro_ticks
    gyro[::each] = _markov(craft.gyro.noise_correlation, gyro[::each])
    if platform.sensors.gyro_noise > 0.0:
        decay = float(np.exp(-clock.period / platform.bias_time))
        wander = _markov(decay, np.random.default_rng([case.seed, _BIAS]).standard_normal((rows, runs, 3)))
        gyro = gyro + platform.bias_instability / platform.sensors.gyro_noise * wander
    count = len(platform.wheels.spin_inertia)
    tachometer = np.random.default_rng([case.seed, _WHEELS]).standard_normal((rows, runs, count))
    return _WheelNoise(white._replace(gyro=gyro), tachometer)


def _markov(decay: float, white: Array) -> Array:
    """Return a first-order autoregression of unit variance, driven by white numbers."""
    values = [white[0]]
    for each in white[1:]:
        values.append(decay * values[-1] + np.sqrt(1.0 - decay**2) * each)
    return np.array(values)


def planned(platform: WheelPlatform, run: WheelRun, clock: Clock) -> Plan:
    """Return wheel speeds that turn the nominal platform along a smooth motion within its limits.

    Args:
        platform: nominal.
        run: seed of the motion, and how it is released.
        clock: its ticks.
    """
    size, (slowest, fastest) = _FREE if platform.pivot is None else _STANDING
    rng = np.random.default_rng(run.motion)
    amplitude = size[:, None] * rng.uniform(0.3, 1.0, (3, _TONES)) * rng.choice((-1.0, 1.0), (3, _TONES))
    rate, phase = 2.0 * np.pi * rng.uniform(slowest, fastest, (3, _TONES)), rng.uniform(-0.5, 0.5, (3, _TONES))
    waves = rate[None] * clock.times[:, None, None] + phase
    turn = (amplitude * (np.sin(waves) - np.sin(phase))).sum(axis=-1)
    if run.at_rest:
        turn = turn * -np.expm1(-((clock.times / _ROLLED_IN) ** 2))[:, None]
    scale = 1.0
    for _ in range(_TRIES):
        plan, load = _plan(platform, scale * turn, clock)
        if load <= _USED:
            return plan
        scale *= 0.95 * _USED / load
    raise ValueError(f"no motion of seed {run.motion} keeps the limits: the platform at rest uses {load:.0%} of one")


def _plan(platform: WheelPlatform, turn: Array, clock: Clock) -> tuple[Plan, float]:
    """Return the plan of rotation vectors since release, (K, 3), rad, and the largest share of a limit that it uses."""
    body_rate = _body_rate(turn, CubicSpline(clock.times, turn)(clock.times, 1))
    attitude = Rotation.from_rotvec(turn).as_matrix()
    inertia, pulled = platform.inertia, np.zeros_like(turn)
    if platform.pivot is not None:
        arm = platform.mass * platform.pivot.gravity * platform.pivot.offset
        inertia = inertia + point_inertia(platform.mass, platform.pivot.offset)
        weight_N = np.einsum("kij,kj->ki", attitude, cross(attitude[:, 2], arm))
        pulled = CubicSpline(clock.times, weight_N).antiderivative()(clock.times)
    held, axis = platform.held_momentum, platform.wheels.axis
    whole_N = inertia @ body_rate[0] + held @ axis + pulled
    share = (np.einsum("kji,kj->ki", attitude, whole_N) - body_rate @ inertia) @ np.linalg.pinv(axis)
    momentum = share + held - held @ axis @ np.linalg.pinv(axis)
    torque = np.diff(momentum, axis=0) / clock.period
    tilt = np.arccos(np.clip(attitude[:, 2, 2], -1.0, 1.0)).max() / platform.tilt_limit
    used = (np.abs(momentum) / platform.momentum_limit, np.abs(torque) / platform.wheels.torque_limit)
    load = max(float(used[0].max()), float(used[1].max()), float(tilt))
    return Plan(speed=momentum / platform.wheels.spin_inertia, released=body_rate[0]), load


def _body_rate(turn: Array, change: Array) -> Array:
    """Return ω, (K, 3), rad/s, body axes, of rotation vectors φ and their derivatives.

    ω = φ̇ - (1 - cos φ)/φ² φ × φ̇ + (φ - sin φ)/φ³ φ × (φ × φ̇).
    """
    angle = np.maximum(np.linalg.norm(turn, axis=1, keepdims=True), 1e-4)
    across = cross(turn, change)
    along = (angle - np.sin(angle)) / angle**3
    return change - (1.0 - np.cos(angle)) / angle**2 * across + along * cross(turn, across)


def shown_speed(flown: FlownWheels, time: Array) -> Array:
    """Return what noise-free tachometers are recorded with at times, (T, B, W), rad/s: late where telemetry is."""
    log = flown.log
    when = np.clip(time - flown.craft.telemetry_late, 0.0, log.time[-1])
    return CubicSpline(log.time, log.wheel_speed)(when) + flown.craft.wheels.speed_bias
