"""Reaction wheels in MuJoCo: mounted as stated, momentum as the formula has it, conserved while motors work."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from support.platforms import initial
from testbed.cmg.wheels import wheel_axes
from testbed.plant.build import build
from testbed.plant.geometry import composite_inertia, composite_mass, total_momentum
from testbed.plant.layout import layout_of
from testbed.plant.plant import Plant
from testbed.plant.properties import PlatformProperties, WheelProperties

INERTIA = np.array([[0.020, 0.001, 0.0], [0.001, 0.022, 0.0005], [0.0, 0.0005, 0.025]])
SPIN, TRANSVERSE, LIMIT = 1.5e-5, 8e-6, 2e-3
AXES = wheel_axes("pyramid", 4, radians(54.74))


def wheels(**changes):
    stated = {"mass": 0.06, "spin_inertia": SPIN, "transverse_inertia": TRANSVERSE, "torque_limit": LIMIT}
    return tuple(WheelProperties(axis_B=axis, position_B=0.05 * axis, **(stated | changes)) for axis in AXES)


def platform(**changes):
    return build(PlatformProperties(units=0, inertia=INERTIA, mass=4.0, wheels=wheels(**changes)))


def flown(model, momentum, torque, seconds=1.0):
    plant = Plant(
        [model],
        initial=[initial(body_rate=(0.1, -0.2, 0.3), gimbal_angle=np.zeros(0))],
        rotor_momentum=np.zeros((1, 0)),
        wheel_momentum=np.array([momentum]),
    )
    states = [(plant.qpos[0].copy(), plant.qvel[0].copy())]
    for _ in range(round(seconds / 0.0125)):
        plant.advance(np.zeros((1, 0)), 10, np.array([torque]))
        states.append((plant.qpos[0].copy(), plant.qvel[0].copy()))
    assert not plant.divergence
    return plant, np.array([each[0] for each in states]), np.array([each[1] for each in states])


def test_the_whole_platform_has_the_stated_inertia_and_mass():
    model = platform()
    np.testing.assert_allclose(composite_inertia(model), INERTIA, atol=1e-12)
    assert composite_mass(model) == pytest.approx(4.0, abs=1e-12)


def test_momentum_is_that_of_the_body_and_of_each_wheel_about_its_axis():
    """J ω with all wheels locked, and Jw Ω a for what they turn relative to it."""
    model, rng = platform(), np.random.default_rng(2)
    layout = layout_of(model)
    qpos, qvel = np.zeros((5, model.nq)), np.zeros((5, model.nv))
    qpos[:, layout.attitude.start] = 1.0
    qpos[:, layout.wheel_angle] = rng.uniform(-3.0, 3.0, (5, 4))
    qvel[:, layout.body_rate] = rate = rng.uniform(-0.5, 0.5, (5, 3))
    qvel[:, layout.wheel_speed] = speed = rng.uniform(-300.0, 300.0, (5, 4))
    expected = rate @ INERTIA + (SPIN * speed) @ AXES
    np.testing.assert_allclose(total_momentum(model, qpos, qvel), expected, atol=1e-13)


def test_momentum_is_conserved_while_motors_work():
    model = platform()
    _, qpos, qvel = flown(model, [4e-3, -2e-3, 1e-3, 3e-3], [1e-3, -5e-4, 2e-4, -1e-3])
    held = total_momentum(model, qpos, qvel)
    drift = np.linalg.norm(held - held[0], axis=1).max()
    assert drift < 1e-10 * 10e-3  # of the wheels' total; RK4 at 1.25 ms


def test_a_motor_gives_its_torque_up_to_its_limit():
    """Jw (Ω̇ + a·ω̇) = τ: what the wheel gains, the body loses."""
    asked = [1e-3, 5e-3, -5e-3, 0.0]
    plant, _, qvel = flown(platform(), [0.0] * 4, asked, seconds=0.0125)
    layout = plant.layout
    gained = SPIN * (np.diff(qvel[:, layout.wheel_speed], axis=0) + np.diff(qvel[:, layout.body_rate], axis=0) @ AXES.T)
    np.testing.assert_allclose(gained[0] / 0.0125, np.clip(asked, -LIMIT, LIMIT), rtol=2e-4, atol=1e-7)


def test_viscous_friction_slows_a_wheel_down():
    friction = 2e-6
    plant, _, qvel = flown(platform(viscous_friction=friction), [3e-3, 0.0, 0.0, 0.0], [0.0] * 4)
    speed = qvel[:, plant.layout.wheel_speed.astype(int)][:, 0]
    assert speed[-1] / speed[0] == pytest.approx(np.exp(-friction / SPIN), rel=5e-3)  # the body takes some of it up
