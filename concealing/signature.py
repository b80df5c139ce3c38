"""How much of a hidden effect a data set can show: the norm of what the nominal model leaves unexplained.

Without noise, the body rate is predicted from the telemetry with the nominal model; the inertia and the initial rates
are projected out of the difference, and what is left is counted in standard deviations of the gyro. What stays inside
the units, friction and lag, is counted in standard deviations of motor torque and encoder.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from concealing.case import Case
from concealing.craft import SIGN_WIDTH, Array, nominal_craft
from concealing.flown import FlownCase, applied_torque, fly_case, sensors_of
from concealing.guidance import software_of
from concealing.nominal import DivergedError, Telemetry, nudged, predictions, unexplained

_FRICTION = {"gimbal_viscous_friction", "gimbal_coulomb_friction"}
_SERVO_KNOWN = 5e-3
"""rad; what the nominal servo's answer to its commands leaves unexplained without any effect, at most."""
_COARSE = 0.5
"""Refinement of the flights that are only sized: steps twice as long, still stable, move a norm by 4e-4 at most."""


def signal(case: Case) -> float:
    """Return the norm of the whitened signature of a case's effects, in sigma.

    Args:
        case: with its effects.

    Raises:
        DivergedError: its flight leaves the finite numbers.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        flown, known = fly_case(case, quiet=True, refinement=_COARSE), sensors_of(case)
    if not np.isfinite(flown.log.fine_state).all():
        raise DivergedError
    parts = [_body_rate_signature(flown) / known.gyro_noise]
    hidden = {effect.effect for effect in case.effects}
    if hidden & _FRICTION and case.telemetry.gimbal_torque:
        parts.append(_friction_signature(flown) / known.torque_noise)
    if "gimbal_lag" in hidden and case.telemetry.rate_command:
        parts.append(_servo_signature(flown) / np.hypot(known.encoder_noise, _SERVO_KNOWN))
    return float(np.sqrt(sum(float(part @ part) for part in parts)))


def sampled(flown: FlownCase, values: Array) -> Array:
    """Return what is recorded of values at the control ticks, (K, B, ...), run after run, flat."""
    return np.concatenate([values[ticks, run].ravel() for run, ticks in enumerate(_recorded(flown))])


def _recorded(flown: FlownCase) -> list[Array]:
    period, every = flown.clock.period, flown.clock.gyro_ticks
    return [np.arange(0, round(run.duration / period) + 1, every) for run in flown.case.runs]


def _body_rate_signature(flown: FlownCase) -> Array:
    telemetry = telemetry_of(flown)
    inertia, released = flown.craft.inertia, flown.log.body_rate[0]
    rates = predictions(telemetry, flown.clock.period, *nudged(inertia, released))
    return unexplained(flown.log.gyro, rates, partial(sampled, flown))


def telemetry_of(flown: FlownCase) -> Telemetry:
    """What encoders, tachometers and the nominal drawing say of the cluster."""
    log, mechanics = flown.log, flown.mechanics
    grid = np.arange(2 * flown.clock.ticks + 1) * flown.clock.period / 2
    on_record = np.clip(grid - flown.craft.telemetry_late, 0.0, grid[-1])
    shape = (len(grid), log.body_rate.shape[1])
    if flown.case.actuation == "applied_torque":
        asked = applied_torque(flown.case)
        torque = np.array([asked(time) for time in grid - flown.craft.telemetry_late])
        return Telemetry(np.zeros((*shape, 3)), np.zeros((*shape, 3, 3)), torque)
    units = nominal_craft(software_of(flown.case.scenario).platform).units
    velocities = [mechanics.velocities(time, state) for time, state in zip(log.fine_time, log.fine_state, strict=True)]
    rate = np.array([each.gimbal_rate for each in velocities])
    lead = 0.5 * flown.craft.encoders.backlash * np.sign(rate)
    angle = log.fine_state[:, :, mechanics.slices["angle"]] + flown.craft.encoders.zero + lead
    speed = units.rotor_speed
    if flown.case.telemetry.tachometers:
        shown = zip(log.fine_time, velocities, strict=True)
        speed = np.array([mechanics.shown_speed(time, each.rotor_speed) for time, each in shown])
    cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
    spin = units.spin_axis * cos + units.transverse_axis * sin
    momentum = ((units.spin_inertia * speed)[..., None] * spin).sum(axis=2)
    momentum += (units.turning_inertia * rate) @ units.gimbal_axis
    change = units.spin_inertia - units.transverse_inertia
    turned = np.einsum("m,tbmi,tbmj->tbij", change, spin, spin)
    still = np.einsum("m,mi,mj->ij", change, units.spin_axis, units.spin_axis)
    return Telemetry(
        CubicSpline(log.fine_time, momentum)(on_record),
        CubicSpline(log.fine_time, turned - still)(on_record),
        np.zeros((*shape, 3)),
    )


def _friction_signature(flown: FlownCase) -> Array:
    """What the motors have to do beside moving the gimbals."""
    units = flown.craft.units
    rate = np.array(
        [
            flown.mechanics.velocities(time, state).gimbal_rate
            for time, state in zip(flown.log.time, flown.log.state, strict=True)
        ]
    )
    dry = units.coulomb + units.stribeck * np.exp(-((rate / units.stribeck_rate) ** 2))
    return sampled(flown, units.viscous * rate + dry * np.tanh(rate / SIGN_WIDTH))


def _servo_signature(flown: FlownCase) -> Array:
    """What the nominal servo's answer to the commands leaves unexplained, beside what it always does.

    Only as long as no gimbal of a run was sent its greatest rate, with the effect or without it: behind that the two
    are different flights, all gimbals of which differ by how long they were at their limits.
    """
    prompt = fly_case(replace(flown.case, effects=()), quiet=True, refinement=_COARSE)
    free = _never_at_limit(flown) & _never_at_limit(prompt)
    return sampled(flown, free[..., None] * (_servo_error(flown) - _servo_error(prompt)))


def _never_at_limit(flown: FlownCase) -> Array:
    """Return at which ticks no gimbal has been sent its greatest rate yet, (K, B)."""
    limit = software_of(flown.case.scenario).scenario.cluster.gimbal_rate_limit_rad_s
    at_limit = (np.abs(flown.log.rate_order) >= limit).any(axis=-1)
    return ~np.logical_or.accumulate(at_limit, axis=0)


def _servo_error(flown: FlownCase) -> Array:
    """Angle minus the nominal servo's answer to the rates that were ordered, (K, B, M), rad.

    d̈ = b (ḋ_c - ḋ) + n² (d_c - d) + d̈_c, held over each period, b the tachometer loop's bandwidth, n = b / (2 ζ).
    """
    cluster, period = software_of(flown.case.scenario).scenario.cluster, flown.clock.period
    bandwidth = cluster.gimbal_servo_bandwidth_rad_s
    stiffness = (bandwidth / (2.0 * cluster.gimbal_servo_damping_ratio)) ** 2
    answer = _held_response(bandwidth, period)
    order = flown.log.rate_order
    acceleration = np.diff(order, axis=0, prepend=np.zeros_like(order[:1])) / period
    wanted = np.zeros_like(order[0])
    angle, rate, angles = np.zeros_like(wanted), np.zeros_like(wanted), []
    for asked, change in zip(order, acceleration, strict=True):
        angles.append(angle)
        push = bandwidth * asked + stiffness * (wanted - angle) + change
        angle, rate = answer(angle, rate, push)
        wanted = wanted + asked * period
    return flown.log.encoder - np.array(angles)


def _held_response(bandwidth: float, period: float) -> Callable[[Array, Array, Array], tuple[Array, Array]]:
    """Return angle and rate one period later, of d̈ = push - b ḋ."""
    system = np.zeros((3, 3))
    system[0, 1], system[1, 1], system[1, 2] = 1.0, -bandwidth, 1.0
    passed = expm(system * period)

    def later(angle: Array, rate: Array, push: Array) -> tuple[Array, Array]:
        return angle + passed[0, 1] * rate + passed[0, 2] * push, passed[1, 1] * rate + passed[1, 2] * push

    return later
