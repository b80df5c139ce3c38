"""The controller of one platform, or of a batch: track, steer, serve, once every control period."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Flags, Units, UnitSeries, Vector3, Vectors3
from testbed.cmg.cluster import Cluster, spin_momentum_and_jacobian
from testbed.cmg.servo_law import next_commanded_angle
from testbed.cmg.steering import SteeringLaw, limit_rates, preferred_rates, steer
from testbed.control.servo import GimbalServo, rate_set_point, torque_demand
from testbed.control.tracker import Tracker, feedback_momentum_rate


@dataclass(frozen=True, kw_only=True)
class Controller:
    """The controller: its model, which is the nominal one, and its gains.

    Attributes:
        cluster: nominal units.
        tracker: body-rate tracker.
        law: steering law.
        servo: gimbal servo.
        gimbal_rate_limit: rad/s.
        momentum_gain: of the loop on the cluster's momentum as the encoders show it, 1/s.
        null_motion_gain: k of the null motion toward the preferred gimbal angles, 1/s.
        period: of the control loop, s.
    """

    cluster: Cluster
    tracker: Tracker
    law: SteeringLaw
    servo: GimbalServo
    gimbal_rate_limit: float
    momentum_gain: float
    null_motion_gain: float
    period: float

    @cached_property
    def momentum_scale(self) -> float:
        """The largest rotor momentum, by which the steering laws are scaled, N·m·s."""
        return float(np.abs(self.cluster.rotor_momentum).max())


class Target(NamedTuple):
    """The reference of one control period; rates of change are means over it, so that holding costs no delay.

    Attributes:
        body_rate: in the middle of the period, shape (3,), rad/s, body axes.
        body_acceleration: shape (3,), rad/s².
        momentum_B: spin momentum of the cluster at the start of the period, shape (3,), N·m·s, body axes.
        momentum_rate_B: its rate of change, shape (3,), N·m.
        gimbal_angle: preferred angles at the start of the period, shape (6,), rad.
        gimbal_rate: their rate, shape (6,), rad/s.
    """

    body_rate: Vector3
    body_acceleration: Vector3
    momentum_B: Vector3
    momentum_rate_B: Vector3
    gimbal_angle: Units
    gimbal_rate: Units


class ControllerState(NamedTuple):
    """What the controller remembers from one period to the next.

    Attributes:
        feedback_momentum_B: what the gyro's feedback has added to the reference momentum, shape (..., 3), N·m·s.
        commanded_angle: integral of the commanded gimbal rates, shape (..., 6), rad.
        commanded_rate: of the last period, shape (..., 6), rad/s.
    """

    feedback_momentum_B: Vectors3
    commanded_angle: UnitSeries
    commanded_rate: UnitSeries


class Command(NamedTuple):
    """The commands of one control period to the gimbals.

    Attributes:
        gimbal_rate: after the limit, shape (..., 6), rad/s.
        torque: demand on each motor, shape (..., 6), N·m.
        rate_saturated: which units were cut to their rate limit, shape (..., 6).
    """

    gimbal_rate: UnitSeries
    torque: UnitSeries
    rate_saturated: Flags


def controller_at_rest(gimbal_angle: UnitSeries) -> ControllerState:
    """Return the state of a controller whose gimbals stand still at given angles, shape (..., 6), rad."""
    return ControllerState(np.zeros((*gimbal_angle.shape[:-1], 3)), gimbal_angle, np.zeros_like(gimbal_angle))


def command(
    controller: Controller,
    state: ControllerState,
    target: Target,
    rate_error: Vectors3,
    encoder_angle: UnitSeries,
    time: float,
) -> tuple[ControllerState, Command]:
    """Run one control period.

    Args:
        controller: model and gains.
        state: from the period before.
        target: of this period.
        rate_error: ω_ref - ω̄ at the last gyro sample, shape (..., 3), rad/s.
        encoder_angle: measured gimbal angles, shape (..., 6), rad.
        time: start of the period, s.
    """
    cluster = controller.cluster
    momentum_B, jacobian = spin_momentum_and_jacobian(cluster, encoder_angle)
    momentum_rate_B = _momentum_rate(controller, state, target, momentum_B)
    wanted = _gimbal_rates(controller, target, jacobian, momentum_rate_B, encoder_angle, time)
    rate, saturated = limit_rates(wanted, controller.gimbal_rate_limit)
    set_point, cut = rate_set_point(controller.servo, rate, state.commanded_angle - encoder_angle)
    torque = torque_demand(
        controller.servo,
        cluster,
        set_point,
        (rate - state.commanded_rate) / controller.period,
        jacobian,
        target.body_rate,
        target.body_acceleration,
    )
    following = _next_state(controller, state, rate_error, encoder_angle, rate, saturated)
    return following, Command(rate, torque, saturated | cut)


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


def _gimbal_rates(
    controller: Controller,
    target: Target,
    jacobian: Array,
    momentum_rate_B: Vectors3,
    encoder_angle: UnitSeries,
    time: float,
) -> UnitSeries:
    preferred = preferred_rates(encoder_angle, target.gimbal_angle, target.gimbal_rate, controller.null_motion_gain)
    return steer(controller.law, jacobian, momentum_rate_B, preferred, controller.momentum_scale, time)


def _next_state(
    controller: Controller,
    state: ControllerState,
    rate_error: Vectors3,
    encoder_angle: UnitSeries,
    rate: UnitSeries,
    saturated: Flags,
) -> ControllerState:
    """Integrate feedback and commanded angle, without wind-up.

    The feedback waits while a gimbal is at its rate limit, and the commanded angle never runs away from a motor that
    cannot follow.
    """
    free = ~saturated.any(axis=-1, keepdims=True)
    feedback_rate_B = feedback_momentum_rate(controller.tracker, rate_error) * free
    bound = controller.servo.angle_error_bound
    commanded_angle = next_commanded_angle(state.commanded_angle, encoder_angle, bound, rate, controller.period)
    return ControllerState(state.feedback_momentum_B + feedback_rate_B * controller.period, commanded_angle, rate)
