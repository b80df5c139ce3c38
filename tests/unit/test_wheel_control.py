"""Wheels in the control loop: they give the wanted torque, share it as asked, and stay within their limits."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from testbed.cmg.actuators import Actuators, envelope_share, momentum_and_jacobian
from testbed.cmg.cluster import Cluster
from testbed.cmg.steering import MoorePenrose
from testbed.cmg.wheels import Wheels, minimax_allocation, wheel_axes, wheel_momentum
from testbed.control.controller import Controller, ControllerState, Seen, Target, command, controller_at_rest
from testbed.control.servo import gimbal_servo, momentum_gain
from testbed.control.tracker import Tracker
from testbed.control.wheels import WheelDrive

INERTIA = np.diag([0.035, 0.035, 0.007])
SPIN, PERIOD = 1.5e-5, 0.1
NONE = np.zeros(0)
WHEELS = Wheels(
    axis_B=wheel_axes("pyramid", 4, radians(54.74)),
    spin_inertia=np.full(4, SPIN),
    momentum_limit=np.full(4, 0.01),
    torque_limit=np.full(4, 1e-3),
)
NO_GYROS = Cluster(
    gimbal_axis_B=np.zeros((0, 3)),
    spin_axis_B=np.zeros((0, 3)),
    rotor_momentum=NONE,
    rotor_spin_inertia=NONE,
    rotor_transverse_inertia=NONE,
    gimbal_inertia=NONE,
)
AT_REST = np.zeros(4)
MOMENTUM = np.array([2e-3, -1e-3, 3e-3, 0.0])


def controller(loop_gain=0.0, friction=0.0, null_motion="none", preferred=0.0) -> Controller:
    servo = gimbal_servo(NO_GYROS, 1.0, 0.7, 1.0)
    return Controller(
        actuators=Actuators(cluster=NO_GYROS, wheels=WHEELS, gimbal_rate_limit=1.0),
        tracker=Tracker(inertia=INERTIA, gain=1.0),
        law=MoorePenrose(),
        servo=servo,
        drive=WheelDrive(
            viscous_friction=np.full(4, friction),
            loop_gain=np.full(4, loop_gain),
            null_motion=null_motion,
            null_gain=0.5,
            preferred=np.broadcast_to(preferred, 4),
        ),
        momentum_gain=momentum_gain(servo, PERIOD),
        null_motion_gain=0.0,
        period=PERIOD,
    )


def target(acceleration=(0.0, 0.0, 0.0), momentum=MOMENTUM, reference=AT_REST, rate=AT_REST) -> Target:
    held_B, torque_B = wheel_momentum(WHEELS, momentum), INERTIA @ np.array(acceleration)
    return Target(np.zeros(3), np.array(acceleration), held_B, -torque_B, NONE, NONE, reference, rate)


def asked(controlled: Controller, wanted: Target, momentum=MOMENTUM) -> tuple[ControllerState, np.ndarray, np.ndarray]:
    state = controller_at_rest(NONE, momentum)
    following, order = command(controlled, state, wanted, np.zeros(3), Seen(NONE, momentum), 0.0)
    return following, order.wheel_torque, order.wheel_demand


def test_momentum_and_jacobian_are_those_of_the_wheels():
    actuators = controller().actuators
    momentum_B, jacobian = momentum_and_jacobian(actuators, NONE, MOMENTUM)
    np.testing.assert_allclose(momentum_B, MOMENTUM @ WHEELS.axis_B, atol=1e-16)
    slopes = [
        momentum_and_jacobian(actuators, NONE, MOMENTUM + each * actuators.wheel_scale)[0] - momentum_B
        for each in np.eye(4)
    ]
    np.testing.assert_allclose(jacobian, np.transpose(slopes), rtol=1e-9, atol=1e-17)


def test_motors_give_the_wanted_torque_and_turn_their_wheels_along():
    """The body feels the reaction of what the wheel gains; the motor gives that and Jw a·ω̇ too."""
    acceleration = np.array([0.01, -0.008, 0.02])
    _, torque, demand = asked(controller(), target(acceleration))
    gained = torque - SPIN * WHEELS.axis_B @ acceleration
    np.testing.assert_allclose(-gained @ WHEELS.axis_B, INERTIA @ acceleration, rtol=1e-9)
    np.testing.assert_array_equal(torque, demand)


def test_friction_that_is_known_is_made_up_for():
    _, torque, _ = asked(controller(friction=1e-6), target())
    np.testing.assert_allclose(torque, 1e-6 * MOMENTUM / SPIN, atol=1e-15)


def test_a_torque_beyond_a_limit_keeps_its_direction():
    acceleration = np.array([0.2, -0.1, 0.3])
    _, torque, _ = asked(controller(), target(acceleration))
    gained = torque - SPIN * WHEELS.axis_B @ acceleration
    assert np.abs(gained).max() == pytest.approx(1e-3)
    given_B, wanted_B = -gained @ WHEELS.axis_B, INERTIA @ acceleration
    assert given_B @ wanted_B / np.linalg.norm(given_B) / np.linalg.norm(wanted_B) == pytest.approx(1.0)


@pytest.mark.parametrize("null_motion", ["minimax", "preferred"])
def test_null_motion_shares_the_momentum_without_torque(null_motion):
    preferred = np.array([3e-3, -2e-3, 2e-3, 1e-3])
    controlled, momentum = controller(null_motion=null_motion, preferred=preferred), MOMENTUM
    held_B = wheel_momentum(WHEELS, momentum)
    for _ in range(300):
        _, torque, _ = asked(controlled, target(), momentum)
        momentum = momentum + torque * PERIOD
    np.testing.assert_allclose(wheel_momentum(WHEELS, momentum), held_B, atol=1e-12)
    if null_motion == "minimax":
        wanted = minimax_allocation(WHEELS, held_B, WHEELS.momentum_limit)
    else:
        null = np.linalg.svd(WHEELS.axis_B.T)[2][3]
        wanted = MOMENTUM + null * (null @ (preferred - MOMENTUM))
    np.testing.assert_allclose(momentum, wanted, atol=1e-7)


def test_null_motion_along_the_maneuver_follows_a_moving_reference_without_torque():
    null, momentum = np.linalg.svd(WHEELS.axis_B.T)[2][3], MOMENTUM
    controlled, held_B = controller(null_motion="maneuver"), wheel_momentum(WHEELS, MOMENTUM)
    for period in range(100):
        at = MOMENTUM + 2e-5 * period * PERIOD * null
        _, torque, _ = asked(controlled, target(reference=at, rate=2e-5 * null), momentum)
        momentum = momentum + torque * PERIOD
    np.testing.assert_allclose(momentum, MOMENTUM + 2e-5 * 100 * PERIOD * null, atol=1e-12)
    np.testing.assert_allclose(wheel_momentum(WHEELS, momentum), held_B, atol=1e-12)


def test_a_drive_with_a_speed_loop_is_sent_what_it_is_at_rest_with():
    """In its loop the drive takes off the gain times the true speed: what is left is the torque that was wanted."""
    gain = 1e-4
    _, torque, demand = asked(controller(loop_gain=gain), target((0.01, 0.0, 0.0)))
    np.testing.assert_allclose(demand - gain * MOMENTUM / SPIN, torque, atol=1e-15)


def test_the_commanded_speed_does_not_run_away_from_a_wheel_that_stands_still():
    controlled = controller(loop_gain=1e-4)
    state, still = controller_at_rest(NONE, np.zeros(4)), Seen(NONE, np.zeros(4))
    for _ in range(500):
        state, _ = command(controlled, state, target((0.02, 0.0, 0.0)), np.zeros(3), still, 0.0)
    ahead = WHEELS.torque_limit * SPIN / 1e-4
    assert np.all(np.abs(state.commanded_momentum) <= ahead + 1e-3 * PERIOD)


def test_the_envelope_is_met_where_a_wheel_of_the_minimax_allocation_is_at_its_limit():
    momentum_B = np.array([0.004, -0.006, 0.005])
    most = np.abs(minimax_allocation(WHEELS, momentum_B, WHEELS.momentum_limit)).max() / 0.01
    assert envelope_share(NO_GYROS, WHEELS, momentum_B, np.eye(3)) == pytest.approx(most)
