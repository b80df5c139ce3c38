"""What the loop writes down while it flies, in arrays allocated up front."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from testbed.arrays import Array, Flags, Series, UnitSeries, Vectors3


@dataclass(frozen=True, kw_only=True)
class FlightLog:
    """One row per control tick, the first at the start, the last at the end of the flight.

    Of platforms side by side, every attribute has shape (N, B, ...); of one, as given here.

    Attributes:
        qpos: MuJoCo's positions, shape (N, nq).
        qvel: MuJoCo's velocities, shape (N, nv).
        joint_torque: actuator torque in the last step before the tick, shape (N, nv), N·m.
        encoder: measured gimbal angles, shape (N, M), rad.
        gyro: measured body rate, shape (N, 3), rad/s; NaN between samples.
        rate_command: gimbal rates asked for from this tick on, shape (N, M), rad/s.
        rate_saturated: shape (N, M).
        rotor_clamped: shape (N, M).
        wheel_seen: measured speeds of the reaction wheels, shape (N, W), rad/s.
        wheel_torque: that their motors should give from this tick on, shape (N, W), N·m.
        wheel_clamped: which of them were at their momentum limit in the control period before, shape (N, W).
        contacts: with the cabin, shape (N,).
    """

    qpos: Array
    qvel: Array
    joint_torque: Array
    encoder: UnitSeries
    gyro: Vectors3
    rate_command: UnitSeries
    rate_saturated: Flags
    rotor_clamped: Flags
    wheel_seen: UnitSeries
    wheel_torque: UnitSeries
    wheel_clamped: Flags
    contacts: Series

    def of_platform(self, platform: int, rows: int) -> FlightLog:
        """Return the first ticks of one platform."""
        return FlightLog(
            **{field.name: np.ascontiguousarray(getattr(self, field.name)[:rows, platform]) for field in fields(self)}
        )


def empty_log(rows: int, platforms: int, nq: int, nv: int, units: int, wheels: int) -> FlightLog:
    """Allocate a log of so many rows for platforms with nq positions, nv velocities, units and wheels each."""
    shape = (rows, platforms)
    return FlightLog(
        qpos=np.zeros((*shape, nq)),
        qvel=np.zeros((*shape, nv)),
        joint_torque=np.zeros((*shape, nv)),
        encoder=np.zeros((*shape, units)),
        gyro=np.full((*shape, 3), np.nan),
        rate_command=np.zeros((*shape, units)),
        rate_saturated=np.zeros((*shape, units), dtype=np.bool_),
        rotor_clamped=np.zeros((*shape, units), dtype=np.bool_),
        wheel_seen=np.zeros((*shape, wheels)),
        wheel_torque=np.zeros((*shape, wheels)),
        wheel_clamped=np.zeros((*shape, wheels), dtype=np.bool_),
        contacts=np.zeros(shape),
    )
