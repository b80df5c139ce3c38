"""The closed loop: measure, track, steer, serve, step, write down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from testbed.arrays import Units, Vectors3
from testbed.control.controller import Command, ControllerState, Seen, command, controller_at_rest
from testbed.plant.plant import Plant
from testbed.sensors.gyro_response import GyroState, gyro_at_start, sample_gyro
from testbed.sensors.units import encoder_side, read_units
from testbed.simulation.flight import Flight
from testbed.simulation.log import FlightLog, empty_log


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How the flight of one platform ended.

    Attributes:
        log: of all ticks that were flown with a finite state.
        divergence: what went wrong, with time and state; empty for a completed flight.
    """

    log: FlightLog
    divergence: str = ""


class LoopState(NamedTuple):
    """What passes from one control tick to the next.

    Attributes:
        controller: commanded angles and rates.
        gyro: its filter and history.
        rate_error: ω_ref - ω̄ at the last gyro sample, shape (B, 3), rad/s.
    """

    controller: ControllerState
    gyro: GyroState
    rate_error: Vectors3


def fly(plant: Plant, flight: Flight) -> list[Outcome]:
    """Fly all platforms side by side to the end of the flight's clock; one that diverges ends there.

    Returns:
        One outcome per platform; what it holds depends on that platform alone, bit for bit.
    """
    platforms = len(plant.models)
    widths = (each.shape[1] for each in (plant.qpos, plant.qvel, plant.gimbal_angle, plant.wheel_speed))
    log = empty_log(flight.clock.ticks + 1, platforms, *widths)
    rows = np.ones(platforms, dtype=np.intp)
    state = _initial_state(plant, flight)
    for tick in range(flight.clock.ticks):
        state, seen = _measure(plant, flight, log, state, tick)
        state = _act(plant, flight, log, state, seen, tick)
        rows += plant.flying
        if not plant.flying.any():
            break
    state, seen = _measure(plant, flight, log, state, flight.clock.ticks)
    _ask(flight, log, state, seen, flight.clock.ticks)  # the last samples of commands are commands like all others
    return [
        Outcome(log=log.of_platform(platform, rows[platform]), divergence=plant.divergence.get(platform, ""))
        for platform in range(platforms)
    ]


def _initial_state(plant: Plant, flight: Flight) -> LoopState:
    return LoopState(
        controller=controller_at_rest(plant.gimbal_angle, plant.wheel_speed * _wheel_inertia(flight)),
        gyro=gyro_at_start(flight.sensors.gyro, plant.body_rate),
        rate_error=np.zeros_like(plant.body_rate),
    )


def _wheel_inertia(flight: Flight) -> Units:
    """Return Jw as the controller believes it, by which it takes a speed for a momentum, shape (W,), kg·m²."""
    return flight.controller.actuators.wheels.spin_inertia


def _measure(plant: Plant, flight: Flight, log: FlightLog, state: LoopState, tick: int) -> tuple[LoopState, Seen]:
    """Write down the true state, read all sensors, and renew the tracking error when the gyro has a sample."""
    sensors = flight.sensors
    _write_state(plant, log, tick)
    seen_angle = encoder_side(plant.gimbal_angle, plant.gimbal_rate, sensors.encoder_dead_zone)
    encoder = read_units(sensors.encoder, seen_angle, sensors.encoder_errors[tick])
    log.encoder[tick] = encoder
    speed = read_units(sensors.wheel_tachometer, plant.wheel_speed, sensors.wheel_speed_errors[tick])
    log.wheel_seen[tick] = speed
    seen = Seen(encoder, speed * _wheel_inertia(flight))
    gyro, reading = sample_gyro(sensors.gyro, state.gyro, plant.body_rate, tick, sensors.gyro_errors)
    if reading is None:
        return state._replace(gyro=gyro), seen
    log.gyro[tick] = reading
    return state._replace(gyro=gyro, rate_error=flight.targets.tick_rate[tick] - reading), seen


def _act(plant: Plant, flight: Flight, log: FlightLog, state: LoopState, seen: Seen, tick: int) -> LoopState:
    """Run the controller on what was measured and let the plant move on for one control period."""
    controller_state, asked = _ask(flight, log, state, seen, tick)
    plant.advance(asked.torque, flight.clock.control_steps, asked.wheel_demand)
    return state._replace(controller=controller_state)


def _ask(flight: Flight, log: FlightLog, state: LoopState, seen: Seen, tick: int) -> tuple[ControllerState, Command]:
    """Run the controller on what was measured, and write down what it asks for from this tick on."""
    controller_state, asked = command(
        flight.controller,
        state.controller,
        flight.targets.by_tick[tick],
        state.rate_error,
        seen,
        tick * flight.clock.period,
    )
    log.rate_command[tick] = asked.gimbal_rate
    log.rate_saturated[tick] = asked.rate_saturated
    log.wheel_torque[tick] = asked.wheel_torque
    return controller_state, asked


def _write_state(plant: Plant, log: FlightLog, tick: int) -> None:
    log.qpos[tick] = plant.qpos
    log.qvel[tick] = plant.qvel
    log.joint_torque[tick] = plant.joint_torque
    log.rotor_clamped[tick] = plant.rotor_clamped
    log.wheel_clamped[tick] = plant.wheel_clamped
    log.contacts[tick] = plant.contacts
