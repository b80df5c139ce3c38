"""Tracker and servo: each term against the physics it stands for."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from support.platforms import initial, plant, shipped
from testbed.cmg.actuators import Actuators, momentum_of_actuators
from testbed.cmg.cluster import cluster_momentum, inertia_change, momentum_jacobian
from testbed.cmg.steering import MoorePenrose
from testbed.cmg.wheels import no_wheels
from testbed.control.controller import Controller, Seen, Target, command, controller_at_rest
from testbed.control.servo import gimbal_servo, torque_demand
from testbed.control.tracker import (
    Tracker,
    feedback_gain,
    feedback_momentum_rate,
    momentum_of_rates,
)
from testbed.control.wheels import WheelDrive
from testbed.plant.geometry import cluster_of, composite_inertia
from testbed.plant.layout import layout_of
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import turned

MODEL = shipped()
CLUSTER = cluster_of(MODEL)
INERTIA = composite_inertia(MODEL)
ANGLE = np.array([0.3, -1.1, 0.8, 0.7, -0.9, 1.4])


NONE = np.zeros(0)
ACTUATORS = Actuators(cluster=CLUSTER, wheels=no_wheels(), gimbal_rate_limit=2.0)
NO_DRIVE = WheelDrive(viscous_friction=NONE, loop_gain=NONE, null_motion="none", null_gain=0.0, preferred=NONE)


def controller(**changes) -> Controller:
    settings = {
        "actuators": Actuators(cluster=CLUSTER, wheels=no_wheels(), gimbal_rate_limit=changes.pop("limit", 2.0)),
        "tracker": Tracker(inertia=INERTIA, gain=1.0),
        "law": MoorePenrose(),
        "servo": gimbal_servo(CLUSTER, 50.0, 0.7, 2.0),
        "drive": NO_DRIVE,
        "momentum_gain": 9.0,
        "null_motion_gain": 0.0,
        "period": 0.0125,
    }
    return Controller(**(settings | changes))


def target(acceleration=(0.0, 0.0, 0.0), angle=ANGLE) -> Target:
    """Speed the body up from rest, gimbals where they are."""
    momentum_B = momentum_of_actuators(ACTUATORS, angle, NONE)
    torque_B = INERTIA @ np.array(acceleration)
    return Target(np.zeros(3), np.array(acceleration), momentum_B, -torque_B, np.zeros(6), np.zeros(6), NONE, NONE)


def test_gain_follows_the_gyros_noise():
    quiet, flight, noisy = (feedback_gain(sigma, 1 / 16) for sigma in (0.0, 0.001658, 0.025))
    assert quiet == 2.0, "bounded by the sample rate"
    assert flight == pytest.approx(1.805, abs=1e-3)
    assert noisy == pytest.approx(0.1197, abs=1e-4)
    assert feedback_gain(0.05, 1 / 16) == pytest.approx(noisy / 2, rel=1e-12)


def test_feedback_takes_momentum_out_of_the_cluster_to_speed_the_body_up():
    error = np.array([0.01, 0.0, 0.0])
    rate_B = feedback_momentum_rate(Tracker(inertia=INERTIA, gain=2.0), error)
    np.testing.assert_allclose(rate_B, -INERTIA @ error * 2.0, atol=1e-18)


def test_momentum_of_rates_balances_the_whole_momentum():
    """R (J ω + h) = H₀ along a turning reference, with H₀ not zero."""
    time = np.linspace(0.0, 2.0, 161)
    rate = np.stack([0.3 * np.sin(2.0 * time), 0.2 * np.cos(1.5 * time), 0.1 + 0.0 * time], axis=1)
    start_B = np.array([2e-3, -1e-3, 4e-3])
    momentum_B = momentum_of_rates(INERTIA, time, rate, start_B)
    total_N = turned(integrate_attitude(time, rate), rate @ INERTIA + momentum_B)
    np.testing.assert_allclose(total_N, np.tile(start_B, (161, 1)), atol=1e-15)
    np.testing.assert_allclose(momentum_of_rates(INERTIA, time, rate, np.zeros(3)), -rate @ INERTIA, atol=1e-18)


def test_torque_demand_holds_the_gimbals_against_the_gyroscopic_load():
    """At a steady body rate the demand for zero gimbal rate equals what MuJoCo needs to keep the gimbals still."""
    rate = np.array([0.25, -0.15, 0.3])
    demand = torque_demand(
        gimbal_servo(CLUSTER, 50.0, 0.7, 2.0),
        CLUSTER,
        np.zeros(6),
        np.zeros(6),
        momentum_jacobian(CLUSTER, ANGLE),
        rate,
        np.zeros(3),
    )
    data, layout = mujoco.MjData(MODEL), layout_of(MODEL)
    data.qpos[layout.attitude] = [1.0, 0.0, 0.0, 0.0]
    data.qpos[layout.gimbal_angle] = ANGLE
    data.qvel[layout.body_rate] = rate
    data.qvel[layout.rotor_speed] = 471.4
    mujoco.mj_inverse(MODEL, data)  # qacc = 0
    needed = data.qfrc_inverse[layout.gimbal_rate]
    # What the feed-forward leaves out is (Js - Jt)(ω·s)(ω·t), below 4.7e-6 kg m² · 0.1 rad²/s².
    np.testing.assert_allclose(demand, needed, atol=5e-7)
    assert np.abs(needed).max() > 5e-4


def test_servo_poles_are_where_they_were_asked_for():
    servo = gimbal_servo(CLUSTER, 50.0, 0.7, 2.0)
    poles = np.roots([1.0, servo.rate_gain[0] / servo.inertia[0], servo.angle_gain[0] / servo.inertia[0]])
    assert np.abs(poles[0]) == pytest.approx(50.0 / 1.4)
    assert -poles[0].real / np.abs(poles[0]) == pytest.approx(0.7)


def test_commanded_rates_give_the_wanted_torque():
    acceleration = (0.3, -0.2, 0.4)
    state = controller_at_rest(ANGLE, NONE)
    _, asked = command(controller(), state, target(acceleration=acceleration), np.zeros(3), Seen(ANGLE, NONE), 0.0)
    torque_B = -momentum_jacobian(CLUSTER, ANGLE) @ asked.gimbal_rate
    np.testing.assert_allclose(torque_B, INERTIA @ acceleration, rtol=1e-9)
    assert not asked.rate_saturated.any()


def test_rates_beyond_the_limit_are_scaled_alike_and_flagged():
    state = controller_at_rest(ANGLE, NONE)
    _, free = command(
        controller(limit=1e3), state, target(acceleration=(3.0, 1.0, 0.0)), np.zeros(3), Seen(ANGLE, NONE), 0.0
    )
    _, limited = command(controller(), state, target(acceleration=(3.0, 1.0, 0.0)), np.zeros(3), Seen(ANGLE, NONE), 0.0)
    assert np.abs(free.gimbal_rate).max() > 2.0
    assert np.abs(limited.gimbal_rate).max() == pytest.approx(2.0)
    cosine = free.gimbal_rate @ limited.gimbal_rate
    cosine /= np.linalg.norm(free.gimbal_rate) * np.linalg.norm(limited.gimbal_rate)
    assert cosine == pytest.approx(1.0)
    assert limited.rate_saturated.tolist() == (np.abs(free.gimbal_rate) > 2.0).tolist()


def test_the_commanded_angle_does_not_run_away_from_a_stuck_gimbal():
    state = controller_at_rest(np.zeros(6), NONE)
    for _ in range(200):
        state, _ = command(
            controller(), state, target((0.5, 0.0, 0.0), np.zeros(6)), np.zeros(3), Seen(np.zeros(6), NONE), 0.0
        )
    bound = controller().servo.angle_error_bound
    assert np.abs(state.commanded_angle).max() <= bound + 2.0 * 0.0125 + 1e-12


def test_a_batch_is_commanded_like_its_members():
    rng = np.random.default_rng(4)
    angles, errors = rng.uniform(-0.5, 0.5, (5, 6)), rng.normal(0.0, 0.02, (5, 3))
    asked_for = target((0.2, 0.1, 0.0))
    state = controller_at_rest(angles, np.zeros((5, 0)))
    _, together = command(controller(), state, asked_for, errors, Seen(angles, np.zeros((5, 0))), 0.0)
    _, alone = command(
        controller(), controller_at_rest(angles[3], NONE), asked_for, errors[3], Seen(angles[3], NONE), 0.0
    )
    for name in ("gimbal_rate", "torque", "rate_saturated"):
        np.testing.assert_allclose(getattr(together, name)[3], getattr(alone, name), rtol=1e-12, err_msg=name)


def test_null_motion_goes_to_the_preferred_angles_without_turning_the_body():
    flown = plant(shipped(), initial(gimbal_angle=np.zeros(6)))
    # A null direction at zero angles: all gimbals alike carry momentum along z only through their tilt, so take the
    # exact null space of A and ask for angles along it.
    null = np.linalg.svd(momentum_jacobian(CLUSTER, np.zeros(6)))[2][3]
    preferred = 0.3 * null / np.abs(null).max()
    wanted = target(angle=np.zeros(6))._replace(gimbal_angle=preferred)
    tuned = controller(null_motion_gain=2.0)
    state = controller_at_rest(flown.gimbal_angle, flown.wheel_speed)
    for tick in range(240):
        state, asked = command(
            tuned,
            state,
            wanted,
            np.zeros(3) - flown.body_rate,
            Seen(flown.gimbal_angle, flown.wheel_speed),
            tick * 0.0125,
        )
        flown.advance(asked.torque, 10)
    moved = flown.gimbal_angle
    assert moved @ preferred / (preferred @ preferred) > 0.9
    assert np.abs(flown.body_rate).max() < 1e-3
    total_B = (INERTIA + inertia_change(CLUSTER, moved)) @ flown.body_rate + cluster_momentum(
        CLUSTER, moved, flown.qvel[flown.layout.gimbal_rate]
    )
    assert np.abs(total_B).max() < 1e-6
