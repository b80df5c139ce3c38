"""The controller of one platform, or of a batch: track, steer, serve, once every control period.

The rates of M gimbals and the torques of W wheels are steered together, on the scale of `cmg.actuators`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Flags, Units, UnitSeries, Vector3, Vectors3
from testbed.cmg.actuators import Actuators, momentum_and_jacobian
from testbed.cmg.servo_law import next_commanded_angle
from testbed.cmg.steering import SteeringLaw, limit_rates, preferred_rates, steer
from testbed.control.servo import GimbalServo, rate_set_point, torque_demand
from testbed.control.tracker import Tracker, feedback_momentum_rate
from testbed.control.wheels import (
    WheelDrive,
    WheelReference,
    next_commanded_momentum,
    preferred_torques,
    wheel_demand,
)


@dataclass(frozen=True, kw_only=True)
class Controller:
    """The controller: its model, which is the nominal one, and its gains.

    Attributes:
        actuators: nominal units, wheels and the gimbals' rate limit.
        tracker: body-rate tracker.
        law: steering law.
        servo: gimbal servo.
        drive: of the wheels.
        momentum_gain: of the loop on the actuators' momentum as encoders and tachometers show it, 1/s.
        null_motion_gain: k of the null motion toward the preferred gimbal angles, 1/s.
        period: of the control loop, s.
    """

    actuators: Actuators
    tracker: Tracker
    law: SteeringLaw
    servo: GimbalServo
    drive: WheelDrive
    momentum_gain: float
    null_motion_gain: float
    period: float


class Target(NamedTuple):
    """The reference of one control period; rates of change are means over it, so that holding costs no delay.

    Attributes:
        body_rate: in the middle of the period, shape (3,), rad/s, body axes.
        body_acceleration: shape (3,), rad/s².
        momentum_B: spin momentum of all actuators at the start of the period, shape (3,), N·m·s, body axes.
        momentum_rate_B: its rate of change, shape (3,), N·m.
        gimbal_angle: preferred angles at the start of the period, shape (M,), rad.
        gimbal_rate: their rate, shape (M,), rad/s.
        wheel_momentum: that the maneuver prescribes at the start of the period, shape (W,), N·m·s.
        wheel_momentum_rate: its rate, shape (W,), N·m.
    """

    body_rate: Vector3
    body_acceleration: Vector3
    momentum_B: Vector3
    momentum_rate_B: Vector3
    gimbal_angle: Units
    gimbal_rate: Units
    wheel_momentum: Units
    wheel_momentum_rate: Units


class ControllerState(NamedTuple):
    """What the controller remembers from one period to the next.

    Attributes:
        feedback_momentum_B: what the gyro's feedback has added to the reference momentum, shape (..., 3), N·m·s.
        commanded_angle: integral of the commanded gimbal rates, shape (..., M), rad.
        commanded_rate: of the last period, shape (..., M), rad/s.
        commanded_momentum: integral of the commanded rates of the wheels' momenta, shape (..., W), N·m·s.
    """

    feedback_momentum_B: Vectors3
    commanded_angle: UnitSeries
    commanded_rate: UnitSeries
    commanded_momentum: UnitSeries


class Seen(NamedTuple):
    """What the actuators' sensors show at the start of a control period.

    Attributes:
        gimbal_angle: measured, shape (..., M), rad.
        wheel_momentum: Jw Ω by the tachometers, shape (..., W), N·m·s.
    """

    gimbal_angle: UnitSeries
    wheel_momentum: UnitSeries


class Command(NamedTuple):
    """The commands of one control period to gimbals and wheels.

    Attributes:
        gimbal_rate: after the limit, shape (..., M), rad/s.
        torque: demand on each gimbal motor, shape (..., M), N·m.
        rate_saturated: which units were cut to their rate limit, shape (..., M).
        wheel_torque: that each wheel's motor should give, shape (..., W), N·m.
        wheel_demand: what each wheel's drive is sent for it, shape (..., W), N·m.
    """

    gimbal_rate: UnitSeries
    torque: UnitSeries
    rate_saturated: Flags
    wheel_torque: UnitSeries
    wheel_demand: UnitSeries


def controller_at_rest(gimbal_angle: UnitSeries, wheel_momentum: UnitSeries) -> ControllerState:
    """Return the state of a controller whose gimbals stand still at given angles and whose wheels keep their speed.

    Args:
        gimbal_angle: shape (..., M), rad.
        wheel_momentum: shape (..., W), N·m·s.
    """
    feedback_B = np.zeros((*gimbal_angle.shape[:-1], 3))
    return ControllerState(feedback_B, gimbal_angle, np.zeros_like(gimbal_angle), wheel_momentum)


def command(
    controller: Controller,
    state: ControllerState,
    target: Target,
    rate_error: Vectors3,
    seen: Seen,
    time: float,
) -> tuple[ControllerState, Command]:
    """Run one control period.

    Args:
        controller: model and gains.
        state: from the period before.
        target: of this period.
        rate_error: ω_ref - ω̄ at the last gyro sample, shape (..., 3), rad/s.
        seen: by encoders and tachometers.
        time: start of the period, s.
    """
    actuators, units = controller.actuators, controller.actuators.units
    momentum_B, jacobian = momentum_and_jacobian(actuators, *seen)
    momentum_rate_B = _momentum_rate(controller, state, target, momentum_B)
    wanted = _steered(controller, target, jacobian, momentum_rate_B, seen, time)
    asked, limited = limit_rates(wanted, actuators.gimbal_rate_limit)
    rate, saturated = asked[..., :units], limited[..., :units]
    set_point, cut = rate_set_point(controller.servo, rate, state.commanded_angle - seen.gimbal_angle)
    torque = torque_demand(
        controller.servo,
        actuators.cluster,
        set_point,
        (rate - state.commanded_rate) / controller.period,
        jacobian[..., :units],
        target.body_rate,
        target.body_acceleration,
    )
    wheel_rate = asked[..., units:] * actuators.wheel_scale
    wheel_torque, demand = wheel_demand(
        controller.drive,
        actuators.wheels,
        wheel_rate,
        seen.wheel_momentum,
        state.commanded_momentum,
        target.body_acceleration,
    )
    following = _next_state(controller, state, rate_error, seen, rate, wheel_rate, limited)
    return following, Command(rate, torque, saturated | cut, wheel_torque, demand)


def _momentum_rate(
    controller: Controller,
    state: ControllerState,
    target: Target,
    momentum_B: Vectors3,
) -> Vectors3:
    """ḣ = ḣ_ref + k_h (h_ref + h_fb - h(d̄)): what the cluster should gain, and what it is behind by.

    The gyro's feedback comes in through h_fb alone: this loop takes the edge off its noise before the gimbals feel it.
    """
    behind_B = target.momentum_B + state.feedback_momentum_B - momentum_B
    return target.momentum_rate_B + controller.momentum_gain * behind_B


def _steered(
    controller: Controller, target: Target, jacobian: Array, momentum_rate_B: Vectors3, seen: Seen, time: float
) -> UnitSeries:
    """Return gimbal rates and wheel commands, shape (..., M + W), rad/s."""
    actuators = controller.actuators
    preferred = preferred_rates(seen.gimbal_angle, target.gimbal_angle, target.gimbal_rate, controller.null_motion_gain)
    if len(actuators.wheel_scale):
        reference = WheelReference(target.wheel_momentum, target.wheel_momentum_rate)
        torques = preferred_torques(controller.drive, actuators.wheels, seen.wheel_momentum, reference)
        preferred = np.concatenate([preferred, torques / actuators.wheel_scale], axis=-1)
    return steer(controller.law, jacobian, momentum_rate_B, preferred, actuators.momentum_scale, time)


def _next_state(
    controller: Controller,
    state: ControllerState,
    rate_error: Vectors3,
    seen: Seen,
    rate: UnitSeries,
    wheel_rate: UnitSeries,
    limited: Flags,
) -> ControllerState:
    """Integrate feedback and commands, without wind-up.

    The feedback waits while an actuator is at its limit, and what is commanded never runs away from a motor that cannot
    follow.
    """
    free = ~limited.any(axis=-1, keepdims=True)
    feedback_rate_B = feedback_momentum_rate(controller.tracker, rate_error) * free
    bound = controller.servo.angle_error_bound
    period, wheels = controller.period, controller.actuators.wheels
    return ControllerState(
        feedback_momentum_B=state.feedback_momentum_B + feedback_rate_B * period,
        commanded_angle=next_commanded_angle(state.commanded_angle, seen.gimbal_angle, bound, rate, period),
        commanded_rate=rate,
        commanded_momentum=next_commanded_momentum(
            controller.drive, wheels, state.commanded_momentum, seen.wheel_momentum, wheel_rate, period
        ),
    )
