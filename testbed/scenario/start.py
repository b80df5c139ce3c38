"""What the start of a flight must agree with: locked gimbals, the room, the maneuver, the momentum that is assumed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from testbed.arrays import Units, Vector3
from testbed.cmg.misalignment import turned_axes
from testbed.scenario.actuators import ReactionWheels, wheel_count
from testbed.scenario.dispersion import Dispersion
from testbed.scenario.estimation import Estimation
from testbed.scenario.gyros import Gyros
from testbed.scenario.maneuver import ActuatorPoints, GimbalDesign, GimbalPoints, Maneuver
from testbed.scenario.platform import Cabin, Initial, Platform, Truth
from testbed.scenario.section import Conflict
from testbed.scenario.values import per_unit

_NO_MOMENTUM = 1e-4
"""Share of the rotors' momenta that is as good as none: it moves an estimate by less than its scatter."""
_SAME_ANGLE = 1e-6
"""rad. Six decimals written in the file pass."""
_SAME_MOMENTUM = 1e-9
"""N·m·s. Six figures of a wheel of 1 mN·m·s pass."""


def locked_conflicts(initial: Initial, gyros: Gyros | None) -> Iterator[Conflict]:
    """Find failed units that start off their lock."""
    for unit in gyros.failed if gyros else ():
        angle = per_unit(initial.gimbal_angle_rad, gyros.units, 0.0)[unit - 1] if gyros else 0.0
        if angle != 0.0:
            text = f"has {angle} for unit {unit}, which has failed and is locked at zero; write 0 there"
            yield Conflict(key="initial.gimbal_angle_rad", text=text)


def wheel_start_conflicts(initial: Initial, wheels: Sequence[ReactionWheels] | None) -> Iterator[Conflict]:
    """Find wheels that start with more momentum than they may carry."""
    if not wheels or len(initial.wheel_momentum_N_m_s) != wheel_count(wheels):
        return
    limits = [each.momentum_limit_N_m_s for each in wheels for _ in range(each.wheels)]
    for number, (momentum, limit) in enumerate(zip(initial.wheel_momentum_N_m_s, limits, strict=True), start=1):
        if abs(momentum) > limit:
            text = f"is {momentum} for wheel {number}, beyond its momentum_limit_N_m_s = {limit}; lower it"
            yield Conflict(key="initial.wheel_momentum_N_m_s", text=text)


def room_conflicts(cabin: Cabin, platform: Platform | None, initial: Initial | None) -> Iterator[Conflict]:
    """Find walls that the cube touches at the start, or would touch when it turns there."""
    edge = (platform and platform.edge_m) or 0.0
    position = initial.position_m if initial else (0.0, 0.0, 0.0)
    for axis, size, place in zip("xyz", cabin.size_m, position, strict=True):
        if abs(place) + math.sqrt(3.0) / 2.0 * edge >= size / 2.0:
            text = (
                f"{size} m along {axis} leaves no room for a platform of {edge} m, {math.sqrt(3.0) * edge:.3g} m from "
                f"corner to corner, to turn at {place} m; enlarge it"
            )
            yield Conflict(key="cabin.size_m", text=text)


def first_point_conflicts(
    maneuver: Maneuver, initial: Initial | None, gyros: Gyros | None, wheels: Sequence[ReactionWheels] | None
) -> Iterator[Conflict]:
    """Find a spline that starts elsewhere than the actuators, or is of others than there are.

    A clamped spline starts at its first point.
    """
    if initial is None or gyros is None or wheels is None:
        return
    if isinstance(maneuver, GimbalDesign | GimbalPoints) and (wheels or not gyros.units):
        text = 'is "gimbal", but the platform has wheels; use "actuator", which describes all of them'
        yield Conflict(key="maneuver.parametrization", text=text)
    elif isinstance(maneuver, GimbalPoints | ActuatorPoints):
        yield from _rows_conflicts(maneuver, gyros)
        starts = {
            "gimbal_angle_rad": ("gimbals", per_unit(initial.gimbal_angle_rad, gyros.units, 0.0), _SAME_ANGLE),
            "wheel_momentum_N_m_s": (
                "wheels",
                per_unit(initial.wheel_momentum_N_m_s, wheel_count(wheels), 0.0),
                _SAME_MOMENTUM,
            ),
        }
        for key, (kind, start, same) in starts.items():
            rows = getattr(maneuver, key, ())
            if rows and len(rows[0]) == len(start) and np.abs(np.subtract(rows[0], start)).max(initial=0.0) > same:
                text = f"starts at {list(rows[0])}, the {kind} at {list(start)}; make them equal"
                yield Conflict(key=f"maneuver.{key}", text=f"{text}, here or in initial.{key}")


def _rows_conflicts(maneuver: GimbalPoints | ActuatorPoints, gyros: Gyros) -> Iterator[Conflict]:
    """Find splines of gimbals and wheels that have different knots."""
    if isinstance(maneuver, ActuatorPoints):
        points = len(maneuver.wheel_momentum_N_m_s) if gyros.units else 0
        if len(maneuver.gimbal_angle_rad) != points:
            why = "as many as of the wheels' momenta" if gyros.units else "because there are no gimbals"
            text = f"has {len(maneuver.gimbal_angle_rad)} rows instead of {points}, {why}"
            yield Conflict(key="maneuver.gimbal_angle_rad", text=text)


def momentum_conflicts(
    estimation: Estimation | None,
    initial: Initial | None,
    gyros: Gyros | None,
    wheels: Sequence[ReactionWheels] | None,
    platform: Platform | None,
    truth: Truth | None,
) -> Iterator[Conflict]:
    """Find a flight that starts with momentum which the estimators take to be zero: their estimates would be biased."""
    if not _starts_at_rest(estimation) or not (initial and gyros and platform and truth) or wheels is None:
        return
    rotors = _rotor_momenta(gyros, truth)
    actuators = _of_rotors(rotors, initial, gyros, truth) + _of_wheels(initial, wheels)
    momentum = np.linalg.norm(_of_body(initial, platform, truth) + actuators)
    capacity = rotors.sum() + sum(each.wheels * each.momentum_limit_N_m_s for each in wheels)
    if momentum > _NO_MOMENTUM * capacity:
        amount = f" of {momentum:.3g} N·m·s" if math.isfinite(momentum) else ""
        text = f'is "zero", but the flight starts with momentum{amount}; use "estimated"'
        yield Conflict(key="estimation.initial_momentum", text=text)


def dispersion_conflicts(estimation: Estimation | None, dispersion: Dispersion | None) -> Iterator[Conflict]:
    """Find flights that draw a momentum to start with while the estimators take it to be zero."""
    if not _starts_at_rest(estimation) or dispersion is None:
        return
    for key in ("body_rate_rad_s", "rotor_momentum_relative"):
        if np.any(getattr(dispersion, key)):
            text = f'is "zero", but dispersion.{key} gives each flight a momentum to start with; use "estimated"'
            yield Conflict(key="estimation.initial_momentum", text=text)


def _starts_at_rest(estimation: Estimation | None) -> bool:
    return estimation is not None and estimation.initial_momentum == "zero"


def _rotor_momenta(gyros: Gyros, truth: Truth) -> Units:
    """Rotor momenta as flown, shape (M,), N·m·s; those of failed units are zero."""
    flown = gyros.rotor_momentum if truth.rotor_momentum_N_m_s is None else truth.rotor_momentum_N_m_s
    momenta = np.array(np.broadcast_to(flown, gyros.units), dtype=np.float64)
    momenta[[unit - 1 for unit in gyros.failed]] = 0.0
    return momenta


def _of_body(initial: Initial, platform: Platform, truth: Truth) -> Vector3:
    """J ω, N·m·s, body axes; infinite where the body turns with an inertia that only the MJCF knows."""
    rate, inertia = np.array(initial.body_rate_rad_s), truth.inertia_kg_m2 or platform.inertia_kg_m2
    if not rate.any():
        return np.zeros(3)
    return np.full(3, np.inf) if inertia is None else np.array(inertia) @ rate


def _of_wheels(initial: Initial, wheels: Sequence[ReactionWheels]) -> Vector3:
    """Σ Jw·Ω a, N·m·s, body axes."""
    if not wheels or not initial.wheel_momentum_N_m_s:
        return np.zeros(3)
    return np.asarray(np.array(initial.wheel_momentum_N_m_s) @ np.concatenate([each.axes_B for each in wheels]))


def _of_rotors(momenta: Units, initial: Initial, gyros: Gyros, truth: Truth) -> Vector3:
    """Σ Js·Ω s(d), s(d) = s0 cos d + t0 sin d, N·m·s, body axes; zero where it takes a skew of the MJCF's own."""
    units = gyros.units
    if units == 0:
        return np.zeros(3)
    angle = np.array(per_unit(initial.gimbal_angle_rad, units, 0.0))
    turned = np.array(per_unit(truth.gimbal_axis_misalignment_rad, units, (0.0, 0.0)))
    if not gyros.skewed and (angle.any() or turned.any()):
        return np.zeros(3)
    # Where the skew is omitted all angles are zero, and it has no effect.
    axes = turned_axes(gyros.places.gimbal_axis_B, gyros.places.spin_axis_B, turned)
    along, across = momenta * np.cos(angle), momenta * np.sin(angle)
    return np.asarray(along @ axes.spin_axis_B + across @ axes.transverse_axis_B)
