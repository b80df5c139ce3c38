"""How much of what is hidden in a craft with wheels a data set can show.

Everywhere in what of the gyro's readings the nominal model leaves. What happens between a motor's command and its
wheel's speed changes the body as the wheel's speed says; it is counted in standard deviations of the tachometers too.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import cholesky, solve_triangular

from concealing.craft import SIGN_WIDTH, Array
from concealing.inner_effects import point_inertia
from concealing.nominal import DivergedError, Telemetry, nudged, predictions, unexplained
from concealing.sealing import kept_rows
from concealing.wheel_case import WheelCase, platform_of
from concealing.wheel_effects import BY_NAME, IN_DRIVES
from concealing.wheel_flight import SPEED_GAIN, FlownWheels, fly_wheels, shown_speed
from concealing.wheels import Wheels

_COARSE = 0.5
"""Refinement of flights that are only sized, as in `concealing.signature`."""


def signal(case: WheelCase) -> float:
    """Return the norm of the whitened signature of a case's effects, in sigma.

    Raises:
        DivergedError: its flight leaves the finite numbers.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        flown = fly_wheels(case, quiet=True, refinement=_COARSE)
    if not np.isfinite(flown.log.state).all():
        raise DivergedError
    known = platform_of(case.scenario).sensors
    left = left_unexplained(flown) / known.gyro_noise
    shown = float(left @ left)
    if any(effect.effect in IN_DRIVES | BY_NAME for effect in case.effects):
        shown += shown_by_drives(flown)
    return float(np.sqrt(shown))


def left_unexplained(flown: FlownWheels) -> Array:
    """Return what of the gyro's readings the nominal model leaves, with inertia and initial rates its own, flat."""
    released, inertia = flown.log.body_rate[0], flown.craft.inertia
    pivot = flown.platform.pivot
    if pivot is not None:
        inertia = inertia + point_inertia(flown.craft.mass, pivot.offset)
    rates = predictions(_telemetry(flown), flown.clock.period, *nudged(inertia, released))

    def sampled(values: Array) -> Array:
        return np.concatenate([values[ticks, run].ravel() for run, ticks in enumerate(flown.rows)])

    return unexplained(flown.log.gyro, rates, sampled)


def _telemetry(flown: FlownWheels) -> Telemetry:
    """What the tachometers and the nominal drawing say of the wheels; torques jump at ticks, speeds lie on a spline."""
    platform, log = flown.platform, flown.log
    grid = np.arange(2 * flown.clock.ticks + 1) * flown.clock.period / 2
    shown = shown_speed(flown, grid)
    momentum = (platform.wheels.spin_inertia * shown) @ platform.wheels.axis
    pivot = platform.pivot
    arm = None if pivot is None else flown.craft.mass * pivot.gravity * pivot.offset
    runs = log.body_rate.shape[1]
    still = np.zeros((len(grid), runs, 3))
    return Telemetry(momentum, np.zeros((len(grid), runs, 3, 3)), still, arm)


def shown_by_drives(flown: FlownWheels) -> float:
    """Return the squared norm, in sigma, of what of the tachometers' readings nominal motors and bearings leave.

    A speed at release that nobody knows, of each wheel and run, is projected out. Where rows are lost, so is what
    feedback made of the tachometers' noise in them: the wheels carry it on, and nobody knows it.
    """
    log, case = flown.log, flown.case
    left = left_by_motors(flown.platform.wheels, log.time, shown_speed(flown, log.time), log.body_rate, log.command)
    known = platform_of(case.scenario).sensors
    noise, fed_back = np.hypot(known.tachometer_noise, known.gyro_noise), known.tachometer_noise * SPEED_GAIN
    shown = 0.0
    for run, ticks in enumerate(flown.rows):
        recorded = ticks[kept_rows(case.seed, run, case.dropouts, len(ticks))]
        lost = np.diff(recorded, prepend=recorded[0] - 1) - 1
        added_up = np.cumsum(lost) * (fed_back * flown.clock.period) ** 2
        spread = noise**2 * np.eye(len(lost)) + np.minimum.outer(added_up, added_up)
        whitened = solve_triangular(
            cholesky(spread, lower=True), np.column_stack([np.ones(len(lost)), left[recorded, run]]), lower=True
        )
        release = whitened[:, 0] / np.linalg.norm(whitened[:, 0])
        rest = whitened[:, 1:] - np.outer(release, release @ whitened[:, 1:])
        shown += float(np.square(rest).sum())
    return shown


def left_by_motors(wheels: Wheels, time: Array, shown: Array, body_rate: Array, command: Array) -> Array:
    """Return by how much wheels turn faster than their motors have driven them since release, (K, ..., W), rad/s.

    Js (Ω + ω·a) = Js (Ω + ω·a)(0) + ∫ (u - c Ω - d sign Ω) dt, with u as it was commanded; but for the first term.

    Args:
        wheels: nominal ones.
        time: of control ticks, equally spaced, (K,), s.
        shown: speeds, (K, ..., W), rad/s.
        body_rate: (K, ..., 3), rad/s.
        command: from each tick to the next, (K, ..., W), N·m.
    """
    period = time[1] - time[0]
    braked = wheels.viscous * shown + wheels.coulomb * np.tanh(shown / SIGN_WIDTH)
    asked = np.clip(command, -wheels.torque_limit, wheels.torque_limit)
    given = np.concatenate([np.zeros_like(asked[:1]), period * np.cumsum(asked[:-1], axis=0)])
    taken = wheels.spin_inertia * (shown + body_rate @ wheels.axis.T)
    return (taken - given + CubicSpline(time, braked).antiderivative()(time)) / wheels.spin_inertia
