"""The gimbal servo: torque demands that make each gimbal follow its commanded rate and angle, by `cmg.servo_law`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Flags, Units, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster
from testbed.cmg.servo_law import ServoLaw, set_point, stiffness_of, within

_MOMENTUM_LOOP_SHARE = 0.5
"""Of what the actuators are behind by, at most so much is asked for in one control period: sampled once a period, the
loop would oscillate beyond 1."""


@dataclass(frozen=True, kw_only=True)
class GimbalServo:
    """Gains of the servo around each motor's tachometer loop.

    Attributes:
        inertia: Jg + Jt that each motor turns, shape (6,), kg·m².
        rate_gain: kv of the tachometer loop inside the motor, shape (6,), N·m·s/rad.
        angle_gain: ki on the encoder, the integral of the rate error, shape (6,), N·m/rad.
        rate_limit: largest set point of the tachometer loop, rad/s.
        angle_error_bound: how far the commanded angle may run ahead of a motor at its torque limit (anti-wind-up), rad.
    """

    inertia: Units
    rate_gain: Units
    angle_gain: Units
    rate_limit: float
    angle_error_bound: float


def gimbal_servo(cluster: Cluster, bandwidth: float, damping_ratio: float, rate_limit: float) -> GimbalServo:
    """Place the servo's poles: s² + ω_b s + ω_n², ω_b the tachometer loop's bandwidth and ω_n = ω_b / (2 ζ).

    Args:
        cluster: nominal units.
        bandwidth: ω_b, rad/s.
        damping_ratio: ζ.
        rate_limit: of a gimbal, rad/s.
    """
    law = ServoLaw(bandwidth=bandwidth, stiffness=stiffness_of(bandwidth, damping_ratio), rate_limit=rate_limit)
    inertia = cluster.gimbal_axis_inertia
    return GimbalServo(
        inertia=inertia,
        rate_gain=inertia * law.bandwidth,
        angle_gain=inertia * law.stiffness,
        rate_limit=law.rate_limit,
        angle_error_bound=law.angle_error_bound,
    )


def momentum_gain(servo: GimbalServo, period: float) -> float:
    """Return the gain of the momentum loop, 1/s: a quarter of the servos' natural frequency, or less if they are fast.

    Args:
        servo: of the gimbals; of none on a platform with wheels alone, whose torque is there at once.
        period: of the control loop, s.
    """
    slowest = np.sqrt(servo.angle_gain / servo.inertia).min(initial=4.0 * _MOMENTUM_LOOP_SHARE / period)
    return float(slowest) / 4.0


def rate_set_point(servo: GimbalServo, commanded_rate: UnitSeries, angle_error: UnitSeries) -> tuple[UnitSeries, Flags]:
    """Return the tachometer loop's set point ḋ_c + (ki / kv)(d_c - d̄) within the rate limit, and where it was cut.

    Args:
        servo: gains.
        commanded_rate: ḋ_c, shape (..., 6), rad/s.
        angle_error: d_c - d̄, shape (..., 6), rad.
    """
    wanted = set_point(commanded_rate, angle_error, servo.angle_gain / servo.rate_gain)
    limited = within(wanted, servo.rate_limit)
    return limited, limited != wanted


def torque_demand(
    servo: GimbalServo,
    cluster: Cluster,
    set_point: UnitSeries,
    commanded_acceleration: UnitSeries,
    momentum_jacobian: Array,
    reference_rate: Vectors3,
    reference_acceleration: Vectors3,
) -> UnitSeries:
    """Return the torque demand of every gimbal motor, shape (..., 6), N·m.

    τ = kv ḋ_s + (Jg + Jt)(d̈_c + g·ω̇_ref) - ω_ref·A_i: the tachometer loop's set point, and the feed-forward of inertia
    and of the gyroscopic load Js Ω ω·t(d). The load comes from the reference rate: from the noisy gyro it would shake
    the gimbals (docs/explanation/pitfalls.md, gimbal servo).

    Args:
        servo: gains.
        cluster: nominal units.
        set_point: ḋ_s, shape (..., 6), rad/s.
        commanded_acceleration: d̈_c, shape (..., 6), rad/s².
        momentum_jacobian: A at the measured gimbal angles, columns Js Ω t, shape (..., 3, 6), N·m·s/rad.
        reference_rate: ω_ref, shape (..., 3), rad/s, body axes.
        reference_acceleration: ω̇_ref, shape (..., 3), rad/s².
    """
    inertial = commanded_acceleration + reference_acceleration @ cluster.gimbal_axis_B.T
    load = (reference_rate[..., None, :] @ momentum_jacobian)[..., 0, :]
    return np.asarray(servo.rate_gain * set_point + servo.inertia * inertial - load)
