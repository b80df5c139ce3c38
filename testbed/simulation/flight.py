"""What one closed-loop flight needs besides its plant: clock, controller, sensors with their errors, and targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from testbed.arrays import Array, Series, Units, UnitSeries, Vector3, Vectors3
from testbed.cmg.actuators import momentum_of_actuators
from testbed.control.controller import Controller, Target
from testbed.control.tracker import momentum_of_rates
from testbed.errors import InputError
from testbed.maneuver.maneuver import Maneuver, Reference
from testbed.sensors.gyro_response import Gyro
from testbed.sensors.units import UnitSensor

_ERRORS = (
    "gyro_errors",
    "encoder_errors",
    "tachometer_errors",
    "torque_errors",
    "wheel_speed_errors",
    "wheel_torque_errors",
)


@dataclass(frozen=True, kw_only=True)
class Clock:
    """Integer clocks of a flight: every period is a whole number of integrator steps (docs/explanation/pitfalls.md).

    Attributes:
        step: of the integrator, s.
        control_steps: integrator steps in one control period.
        telemetry_ticks: control periods from one telemetry sample to the next.
        ticks: control periods in the flight.
    """

    step: float
    control_steps: int
    telemetry_ticks: int
    ticks: int

    @property
    def period(self) -> float:
        """Control period, s."""
        return self.step * self.control_steps

    @property
    def tick_times(self) -> Series:
        """Start of every control period and the end of the last, shape (ticks + 1,), s, from the step counter."""
        return np.asarray(np.arange(self.ticks + 1) * self.control_steps * self.step, dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """Sensors of a flight and the additive errors drawn for it.

    Of platforms side by side, errors have shape (samples, B, ...), the gyro's response (B, 3, 3), and the tachometers'
    scale (B, M).

    Attributes:
        gyro: on the control clock.
        gyro_errors: shape (samples, 3), rad/s.
        encoder: gimbal encoders, read at every control tick.
        encoder_errors: shape (ticks + 1, M), rad.
        encoder_dead_zone: play between each encoder and its axis, shape (M,), rad.
        tachometer: rotor speed.
        tachometer_errors: shape (ticks + 1, M), rad/s.
        torque_sensor: gimbal motor torque.
        torque_errors: shape (ticks + 1, M), N·m.
        wheel_tachometer: speed of the reaction wheels, read at every control tick.
        wheel_speed_errors: shape (ticks + 1, W), rad/s.
        wheel_torque_sensor: torque of their motors.
        wheel_torque_errors: shape (ticks + 1, W), N·m.
    """

    gyro: Gyro
    gyro_errors: Vectors3
    encoder: UnitSensor
    encoder_errors: UnitSeries
    encoder_dead_zone: Units
    tachometer: UnitSensor
    tachometer_errors: UnitSeries
    torque_sensor: UnitSensor
    torque_errors: UnitSeries
    wheel_tachometer: UnitSensor
    wheel_speed_errors: UnitSeries
    wheel_torque_sensor: UnitSensor
    wheel_torque_errors: UnitSeries


@dataclass(frozen=True, kw_only=True)
class Targets:
    """A maneuver sampled for the controller.

    Attributes:
        tick_rate: ω_ref at the start of every control period and the end, shape (ticks + 1, 3), rad/s.
        tick_gimbal_angle: preferred angles there, shape (ticks + 1, M), rad.
        by_tick: what each control period asks for, and one more behind the end.
        has_gimbal_reference: whether the maneuver itself prescribes gimbal angles.
        tick_wheel_momentum: of the wheels, as the maneuver prescribes it, shape (ticks + 1, W), N·m·s.
        has_wheel_reference: whether it does.
    """

    tick_rate: Vectors3
    tick_gimbal_angle: UnitSeries
    by_tick: tuple[Target, ...]
    has_gimbal_reference: bool
    tick_wheel_momentum: UnitSeries
    has_wheel_reference: bool


@dataclass(frozen=True, kw_only=True)
class Flight:
    """All that defines a flight except the plant.

    Attributes:
        clock: integer clocks.
        controller: model and gains.
        sensors: with the errors of this flight.
        targets: of the maneuver.
    """

    clock: Clock
    controller: Controller
    sensors: Sensors
    targets: Targets


def side_by_side(sensors: Sequence[Sensors]) -> Sensors:
    """Put the sensors of several flights beside each other.

    They may differ in errors, in the gyro's response and in the tachometers' scale.
    """
    first = sensors[0]
    errors: dict[str, Any] = {name: np.stack([getattr(each, name) for each in sensors], axis=1) for name in _ERRORS}
    gyro = replace(first.gyro, response=np.stack([each.gyro.response for each in sensors]))
    scales = np.stack([each.tachometer.scale_factor_error for each in sensors])
    return replace(first, gyro=gyro, tachometer=replace(first.tachometer, scale_factor_error=scales), **errors)


def flight_of(flight: Flight, platform: int) -> Flight:
    """Return the flight of one platform among those side by side."""
    sensors = flight.sensors
    errors: dict[str, Any] = {name: getattr(sensors, name)[:, platform] for name in _ERRORS}
    gyro = replace(sensors.gyro, response=sensors.gyro.response[platform])
    tachometer = replace(
        sensors.tachometer, scale_factor_error=np.asarray(sensors.tachometer.scale_factor_error)[platform]
    )
    return replace(flight, sensors=replace(sensors, gyro=gyro, tachometer=tachometer, **errors))


def targets_of(
    maneuver: Maneuver,
    clock: Clock,
    controller: Controller,
    *,
    preferred_gimbal_angle: UnitSeries | None,
    initial_momentum_B: Vector3,
    outside_torque_B: Vectors3 | None = None,
) -> Targets:
    """Sample a maneuver: at the ticks for errors, in the middle of each period for what is held through it.

    Args:
        maneuver: the reference.
        clock: of the flight.
        controller: its model turns body rates into cluster momentum.
        preferred_gimbal_angle: constant preferred angles, shape (M,), rad; None to follow the maneuver's own.
        initial_momentum_B: total angular momentum that the controller expects at the start, shape (3,), N·m·s, body.
        outside_torque_B: what it expects to act on the platform at the ticks, shape (ticks + 1, 3), N·m, body axes;
            nothing where None.
    """
    at_ticks = maneuver.reference(clock.tick_times)
    middle = maneuver.reference(clock.tick_times[:-1] + clock.period / 2)
    actuators, ticks = controller.actuators, clock.ticks
    wheel_momenta, wheel_rate, wheels_follow = _wheel_reference(controller, at_ticks, middle)
    if preferred_gimbal_angle is None and at_ticks.gimbal_angle is not None and middle.gimbal_rate is not None:
        angle, rate, follows = at_ticks.gimbal_angle, middle.gimbal_rate, True
    else:
        constant = np.zeros(actuators.units) if preferred_gimbal_angle is None else preferred_gimbal_angle
        angle, rate, follows = np.tile(constant, (ticks + 1, 1)), np.zeros((ticks, actuators.units)), False
    if (follows or not actuators.units) and (wheels_follow or not len(actuators.wheel_scale)):
        momentum_B = momentum_of_actuators(actuators, angle, wheel_momenta)
    else:
        inertia = controller.tracker.inertia
        momentum_B = momentum_of_rates(
            inertia, clock.tick_times, at_ticks.body_rate, initial_momentum_B, outside_torque_B
        )
    momentum_rate_B = np.diff(momentum_B, axis=0) / clock.period
    by_tick = map(
        Target,
        middle.body_rate,
        middle.body_acceleration,
        momentum_B[:-1],
        momentum_rate_B,
        angle[:-1],
        rate,
        wheel_momenta[:-1],
        wheel_rate,
    )
    return Targets(
        tick_rate=at_ticks.body_rate,
        tick_gimbal_angle=angle,
        by_tick=_with_one_more(tuple(by_tick)),
        has_gimbal_reference=follows,
        tick_wheel_momentum=wheel_momenta,
        has_wheel_reference=wheels_follow,
    )


def _with_one_more(targets: tuple[Target, ...]) -> tuple[Target, ...]:
    """Return targets with that of the period behind the maneuver's end, on a line through the last two."""
    before, last = targets[-2:] if len(targets) > 1 else 2 * targets
    return *targets, Target(*(2.0 * value - earlier for value, earlier in zip(last, before, strict=True)))


def _wheel_reference(controller: Controller, at_ticks: Reference, middle: Reference) -> tuple[Array, Array, bool]:
    """Return the wheels' momenta at the ticks, their rates between them, and whether null motion goes along them."""
    if controller.drive.null_motion != "maneuver":
        wheels, ticks = len(controller.actuators.wheel_scale), len(middle.time)
        return np.zeros((ticks + 1, wheels)), np.zeros((ticks, wheels)), False
    if at_ticks.wheel_momentum is None or middle.wheel_momentum_rate is None:
        raise InputError(
            'controller.wheels.null_motion is "maneuver", but the maneuver prescribes no momenta of wheels; design it '
            'with parametrization = "actuator", give its wheel speeds, or write "none" there'
        )
    return at_ticks.wheel_momentum, middle.wheel_momentum_rate, True
