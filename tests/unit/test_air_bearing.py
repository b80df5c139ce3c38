"""A platform on a pivot: the laws of a pivoted body, without any other engine."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from support.platforms import initial
from testbed.plant.build import build
from testbed.plant.extended import extended_platform
from testbed.plant.geometry import composite_inertia, composite_mass
from testbed.plant.layout import layout_of
from testbed.plant.plant import Plant
from testbed.plant.properties import AirBearing, PlatformProperties

INERTIA = np.array([[0.020, 0.001, 0.0], [0.001, 0.022, 0.0005], [0.0, 0.0005, 0.025]])
OFFSET, GRAVITY = np.array([1e-3, -2e-3, -4e-3]), 9.81


def platform(offset=OFFSET, drag=0.0, **changes):
    bearing = AirBearing(center_of_mass_B=np.asarray(offset), gravity=GRAVITY, drag=drag)
    return PlatformProperties(**({"units": 0, "inertia": INERTIA, "mass": 4.0} | changes), air_bearing=bearing)


def flown(model, seconds, body_rate):
    plant = Plant(
        [model],
        initial=[initial(body_rate=np.array(body_rate), gimbal_angle=np.zeros(0))],
        rotor_momentum=np.zeros((1, 0)),
    )
    states = [(plant.qpos[0].copy(), plant.qvel[0].copy())]
    for _ in range(round(seconds / 0.0125)):
        plant.advance(np.zeros((1, 0)), 10)
        states.append((plant.qpos[0].copy(), plant.qvel[0].copy()))
    assert not plant.divergence
    return tuple(np.array(each) for each in zip(*states, strict=True))


def test_mass_and_inertia_stay_those_about_the_centre_of_mass():
    model = build(platform())
    np.testing.assert_allclose(composite_inertia(model), INERTIA, atol=1e-12)
    assert composite_mass(model) == pytest.approx(4.0)


def test_the_pivot_stays_where_it_is_and_the_centre_of_mass_goes_around_it():
    model = build(platform())
    data = mujoco.MjData(model)
    for qpos in flown(model, 3.0, (0.3, -0.2, 0.4))[0]:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        axes = data.xmat[model.body("bus").id].reshape(3, 3)
        np.testing.assert_allclose(data.xpos[model.body("bus").id], axes @ OFFSET, atol=1e-15)


def test_energy_and_the_momentum_about_the_vertical_are_kept():
    qpos, qvel = flown(build(platform()), 5.0, (0.3, -0.2, 0.4))
    about_pivot = INERTIA + 4.0 * (OFFSET @ OFFSET * np.eye(3) - np.outer(OFFSET, OFFSET))
    energy, vertical = [], []
    for quaternion, rate in zip(qpos, qvel, strict=True):
        turned = np.empty(9)
        mujoco.mju_quat2Mat(turned, quaternion)
        up_B = turned.reshape(3, 3)[2]
        energy.append(rate @ about_pivot @ rate / 2.0 + 4.0 * GRAVITY * up_B @ OFFSET)
        vertical.append(up_B @ about_pivot @ rate)
    assert np.ptp(qvel, axis=0).min() > 0.3
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-10)
    np.testing.assert_allclose(vertical, vertical[0], rtol=0, atol=1e-10)


def test_drag_slows_down_a_body_that_turns_about_the_vertical():
    drag, below = 2e-3, (0.0, 0.0, -0.004)
    _, qvel = flown(build(platform(below, drag, inertia=np.diag([0.02, 0.022, 0.025]))), 5.0, (0.0, 0.0, 0.5))
    time = 0.0125 * np.arange(len(qvel))
    np.testing.assert_allclose(qvel[:, 2], 0.5 * np.exp(-drag / 0.025 * time), atol=1e-12)


def test_a_layout_has_attitude_and_body_rate_but_no_place():
    layout, model = layout_of(build(platform(units=6))), build(platform(units=6))
    assert (model.nq - 4, model.nv - 3) == (12, 12)
    assert layout.attitude == slice(0, 4)
    assert layout.body_rate == slice(0, 3)
    assert layout.position == layout.velocity == slice(0, 0)


def test_an_extended_platform_on_a_bearing_is_read_again(tmp_path):
    path = tmp_path / "platform.xml"
    path.write_text(extended_platform(platform(units=6), None, ()), encoding="utf-8")
    model = build(PlatformProperties(), path)
    assert model.joint("bus").type == mujoco.mjtJoint.mjJNT_BALL
    assert model.opt.gravity[2] == pytest.approx(-GRAVITY)
    np.testing.assert_allclose(-model.joint("bus").pos, OFFSET)
