"""From a flight's log to the channels of its record: what telemetry sent, and what only the simulation knows."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Flags, UnitSeries, Vectors3
from testbed.cmg.actuators import dexterity
from testbed.cmg.cluster import Cluster, cluster_momentum, momentum_jacobian
from testbed.cmg.wheels import Wheels, wheel_momentum
from testbed.plant.layout import Layout, layout_of
from testbed.plant.plant import Model
from testbed.sensors.units import UnitSensor, read_units
from testbed.simulation.flight import Flight
from testbed.simulation.log import FlightLog


def channels_of(
    log: FlightLog,
    flight: Flight,
    model: Model,
    true_cluster: Cluster,
    true_wheels: Wheels,
    true_momentum_N: Vectors3,
) -> dict[str, Array]:
    """Return every channel of a flown record by signal name, each of shape (N, width), one row per control tick.

    Args:
        log: of the flight.
        flight: clock, sensors and targets.
        model: the flown platform.
        true_cluster: its units.
        true_wheels: its reaction wheels.
        true_momentum_N: its total angular momentum, shape (N, 3), N·m·s, inertial axes.
    """
    layout = layout_of(model)
    channels = (
        _telemetry(log, flight, layout)
        | _true_state(log, layout)
        | _true_momentum(log, flight, layout, true_cluster, true_wheels)
        | {"true_total_momentum": true_momentum_N}
        | _reference(log, flight)
        | _saturation(log, model, layout)
    )
    return {name: values for name, values in channels.items() if values.shape[1]}  # without units: none of theirs


def _telemetry(log: FlightLog, flight: Flight, layout: Layout) -> dict[str, Array]:
    sensors = flight.sensors
    sampled = np.arange(len(log.gyro)) % flight.clock.telemetry_ticks == 0
    speed = log.qvel[:, layout.rotor_speed]
    torque = log.joint_torque[:, layout.gimbal_rate]
    return {
        "body_rate": log.gyro,
        "gimbal_angle": _where(sampled, log.encoder),
        "gimbal_rate_command": _where(sampled, log.rate_command),
        "gimbal_torque": _where(sampled, _read(sensors.torque_sensor, torque, sensors.torque_errors)),
        "rotor_speed": _where(sampled, _read(sensors.tachometer, speed, sensors.tachometer_errors)),
        "wheel_speed": _where(sampled, log.wheel_seen),
        "wheel_torque_command": _where(sampled, log.wheel_torque),
        "wheel_torque": _where(
            sampled,
            _read(sensors.wheel_torque_sensor, log.joint_torque[:, layout.wheel_speed], sensors.wheel_torque_errors),
        ),
    }


def _read(sensor: UnitSensor, true_value: UnitSeries, errors: UnitSeries) -> UnitSeries:
    return read_units(sensor, true_value, errors[: len(true_value)])


def _where(sampled: Flags, values: Array) -> Array:
    return np.where(sampled[:, None], values, np.nan)


def _true_state(log: FlightLog, layout: Layout) -> dict[str, Array]:
    return {
        "true_body_rate": log.qvel[:, layout.body_rate],
        "true_gimbal_angle": log.qpos[:, layout.gimbal_angle],
        "true_gimbal_rate": log.qvel[:, layout.gimbal_rate],
        "true_gimbal_torque": log.joint_torque[:, layout.gimbal_rate],
        "true_rotor_angle": log.qpos[:, layout.rotor_angle],
        "true_rotor_speed": log.qvel[:, layout.rotor_speed],
        "true_wheel_angle": log.qpos[:, layout.wheel_angle],
        "true_wheel_speed": log.qvel[:, layout.wheel_speed],
        "true_wheel_torque": log.joint_torque[:, layout.wheel_speed],
        "true_attitude": log.qpos[:, layout.attitude],
    } | _true_position(log, layout)


def _true_position(log: FlightLog, layout: Layout) -> dict[str, Array]:
    position = log.qpos[:, layout.position]
    return {"true_position": position} if position.size else {}  # none on an air bearing


def _true_momentum(
    log: FlightLog, flight: Flight, layout: Layout, cluster: Cluster, wheels: Wheels
) -> dict[str, Array]:
    angle, rate = log.qpos[:, layout.gimbal_angle], log.qvel[:, layout.gimbal_rate]
    rotor_momentum = cluster.rotor_spin_inertia * log.qvel[:, layout.rotor_speed]
    jacobian = momentum_jacobian(cluster, angle, rotor_momentum)
    period = flight.clock.period
    momentum_B, torque_B = (
        cluster_momentum(cluster, angle, rate, rotor_momentum),
        -_rate(cluster, jacobian, rate, period),
    )
    if len(wheels.spin_inertia):
        of_wheels_B = wheel_momentum(wheels, wheels.spin_inertia * log.qvel[:, layout.wheel_speed])
        momentum_B, torque_B = momentum_B + of_wheels_B, torque_B - _slope(of_wheels_B, period)
    known = {
        "true_cluster_momentum": momentum_B,
        "true_cluster_torque": torque_B,
    }
    if len(cluster.rotor_momentum):
        known["singularity_measure"] = dexterity(flight.controller.actuators, jacobian, cluster.rotor_momentum)[:, None]
    return known


def _rate(cluster: Cluster, jacobian: Array, rate: UnitSeries, period: float) -> Vectors3:
    """ḣ = A ḋ + Σ (Jg + Jt) d̈ g; the small second term from differences of the simulation's own smooth rates."""
    turning = (jacobian @ rate[..., None])[..., 0]
    return np.asarray(turning + (cluster.gimbal_axis_inertia * _slope(rate, period)) @ cluster.gimbal_axis_B)


def _slope(values: Array, period: float) -> Array:
    return np.gradient(values, period, axis=0) if len(values) > 1 else np.zeros_like(values)


def _reference(log: FlightLog, flight: Flight) -> dict[str, Array]:
    rows = len(log.gyro)
    channels = {"reference_body_rate": flight.targets.tick_rate[:rows]}
    if flight.targets.has_gimbal_reference:
        channels["reference_gimbal_angle"] = flight.targets.tick_gimbal_angle[:rows]
    if flight.targets.has_wheel_reference:
        speed = flight.targets.tick_wheel_momentum[:rows] / flight.controller.actuators.wheels.spin_inertia
        channels["reference_wheel_speed"] = speed
    return channels


def _saturation(log: FlightLog, model: Model, layout: Layout) -> dict[str, Array]:
    limit = model.jnt_actfrcrange[model.dof_jntid[layout.gimbal_rate], 1]
    wheel_torque = log.joint_torque[:, layout.wheel_speed]
    wheel_limit = model.actuator_forcerange[layout.wheel_motor, 1]
    at_limit = np.abs(log.joint_torque[:, layout.gimbal_rate]) >= limit * (1.0 - 1e-9)
    return {
        "gimbal_rate_saturated": log.rate_saturated.astype(np.float64),
        "gimbal_torque_saturated": at_limit.astype(np.float64),
        "rotor_momentum_clamped": log.rotor_clamped.astype(np.float64),
        "wheel_torque_saturated": (np.abs(wheel_torque) >= wheel_limit * (1.0 - 1e-9)).astype(np.float64),
        "wheel_momentum_clamped": log.wheel_clamped.astype(np.float64),
    }
