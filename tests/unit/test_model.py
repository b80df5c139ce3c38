"""The MJCF and what is written over it."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from support.platforms import ROTOR_MOMENTUM, shipped
from testbed.errors import InputError
from testbed.plant.build import build, shipped_model
from testbed.plant.geometry import cluster_of, composite_inertia, composite_mass
from testbed.plant.properties import PlatformProperties

NOMINAL = PlatformProperties(
    inertia=np.diag([0.022, 0.022, 0.027]),
    mass=4.0,
    edge=0.18,
    skew=np.radians(63.9),
    mounting_radius=0.06,
    rotor_momentum=np.full(6, ROTOR_MOMENTUM),
    rotor_momentum_limit=0.0052,
    rotor_spin_inertia=1e-5,
    rotor_transverse_inertia=5.3e-6,
    rotor_mass=0.04,
    gimbal_inertia=3e-6,
    gimbal_mass=0.02,
    gimbal_torque_limit=0.015,
    gimbal_servo_bandwidth=50.0,
    step=0.00125,
)


def test_shipped_file_is_the_nominal_platform():
    model = shipped()
    assert np.abs(composite_inertia(model) - np.diag([0.022, 0.022, 0.027])).max() < 1e-9
    assert composite_mass(model) == pytest.approx(4.0, abs=1e-12)
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT


def test_numbers_written_over_the_file_give_the_same_model():
    written, plain = build(NOMINAL), shipped()
    for name in ("body_mass", "body_pos", "actuator_biasprm", "actuator_gainprm", "jnt_actfrcrange"):
        np.testing.assert_allclose(getattr(written, name), getattr(plain, name), rtol=1e-12, atol=1e-15, err_msg=name)
    written_cluster, plain_cluster = cluster_of(written), cluster_of(plain)
    for name, value in vars(plain_cluster).items():
        np.testing.assert_allclose(getattr(written_cluster, name), value, rtol=1e-12, atol=1e-15, err_msg=name)


def test_cluster_geometry_is_the_hexagonal_pyramid():
    cluster = cluster_of(shipped())
    azimuth, skew = np.radians(60.0 * np.arange(6)), np.radians(63.9)
    gimbal = np.stack(
        [np.sin(skew) * np.cos(azimuth), np.sin(skew) * np.sin(azimuth), np.full(6, np.cos(skew))], axis=1
    )
    spin = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros(6)], axis=1)
    np.testing.assert_allclose(cluster.gimbal_axis_B, gimbal, atol=1e-15)
    np.testing.assert_allclose(cluster.spin_axis_B, spin, atol=1e-15)
    np.testing.assert_allclose(cluster.rotor_momentum, ROTOR_MOMENTUM, rtol=1e-12)


def test_a_full_inertia_matrix_is_met():
    inertia = np.array([[0.0208, 1.0e-4, -2.0e-4], [1.0e-4, 0.0215, 3.0e-4], [-2.0e-4, 3.0e-4, 0.026]])
    model = build(PlatformProperties(inertia=inertia, mass=4.7))
    assert np.abs(composite_inertia(model) - inertia).max() < 1e-9
    assert composite_mass(model) == pytest.approx(4.7, abs=1e-12)


def test_inertia_smaller_than_the_units_is_refused():
    with pytest.raises(InputError, match=r"^inertia_kg_m2.*no body has"):
        build(PlatformProperties(inertia=np.diag([1e-4, 1e-4, 1e-4])))


def test_mass_smaller_than_the_units_is_refused():
    with pytest.raises(InputError, match=r"^mass_kg = 0\.3"):  # of [platform] or of [truth]: the plant cannot know
        build(PlatformProperties(mass=0.3))


def test_cabin_turns_contacts_on():
    model = build(PlatformProperties(cabin_size=np.array([2.0, 2.0, 2.0])))
    assert not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
    assert composite_inertia(model) == pytest.approx(np.diag([0.022, 0.022, 0.027]), abs=1e-12)


@pytest.mark.parametrize("text", ["<mujoco><worldbody/></mujoco>", "not xml"])
def test_a_model_that_cannot_serve_is_refused_with_its_path(tmp_path, text):
    path = tmp_path / "other.xml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"other\.xml"):
        build(PlatformProperties(), path)


def renamed(folder: Path, *changes: tuple[str, str]) -> Path:
    """A copy of the shipped model with parts of its text replaced."""
    for name in ("platform.xml", "cmg.xml"):
        text = shipped_model().with_name(name).read_text(encoding="utf-8")
        for old, new in changes:
            text = text.replace(old, new)
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "platform.xml"


def test_any_model_flies_with_rk4_and_shows_divergence(tmp_path):
    """The other integrators lose momentum, and an automatic reset would hide a divergence."""
    path = renamed(tmp_path, ('integrator="RK4"', 'integrator="Euler"'), ('autoreset="disable"', 'autoreset="enable"'))
    model = build(PlatformProperties(), path)
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET


@pytest.mark.parametrize(
    ("old", "new", "missing"),
    [
        ('name="gimbal_motor"', 'name="motor_a"', "the actuator cmg1_gimbal_motor, cmg2_gimbal_motor"),
        ('name="rotor_motor"', 'name="motor_b"', "the actuator cmg1_rotor_motor"),
        ('<freejoint name="bus"/>', '<freejoint name="float"/>', "the free or ball joint bus"),
        ('<freejoint name="bus"/>', "", "the free or ball joint bus"),
        ('<joint name="rotor"', '<joint name="spin"', "the hinge cmg1_rotor"),
        ('name="hull"', 'name="box"', "the geom hull"),
        ('name="cmg3_mount"', 'name="mount3"', "the frame cmg3_mount"),
        ('prefix="cmg6_"', 'prefix="cmg7_"', "the body cmg6_gimbal, cmg6_rotor; the hinge cmg6_gimbal, cmg6_rotor"),
    ],
)
def test_parts_that_a_model_lacks_are_named(tmp_path, old, new, missing):
    path = renamed(tmp_path, (old, new))
    with pytest.raises(InputError, match=r"platform\.xml: needs ") as caught:
        build(PlatformProperties(), path)
    assert missing in str(caught.value)


def test_all_parts_that_a_model_lacks_are_named_at_once(tmp_path):
    path = renamed(tmp_path, ('name="gimbal_motor"', 'name="motor"'), ('name="cmg3_mount"', 'name="mount3"'))
    with pytest.raises(InputError, match=r"frame cmg3_mount; the actuator cmg1_gimbal_motor"):
        build(PlatformProperties(), path)


@pytest.mark.parametrize("cabin", [None, np.full(3, 2.0)], ids=["free", "in a cabin"])
def test_a_model_without_what_is_only_looked_at_moves_alike(tmp_path, cabin):
    """A strut that weighs something keeps its weight; what touches the cabin stays."""
    heavy = renamed(tmp_path, ('<geom name="strut1" class="strut"', '<geom name="strut1" class="strut" mass="0.1"'))
    seen, bare = (build(PlatformProperties(cabin_size=cabin), heavy, visuals=visuals) for visuals in (True, False))
    assert (bare.ngeom, bare.nmesh) == (0 if cabin is None else 7, 0)
    state = [mujoco.MjData(model) for model in (seen, bare)]
    for model, data in zip((seen, bare), state, strict=True):
        data.qvel[:] = np.random.default_rng(3).normal(size=model.nv)
        for _ in range(50):
            mujoco.mj_step(model, data)
    np.testing.assert_array_equal(state[0].qpos, state[1].qpos)
    np.testing.assert_array_equal(state[0].qvel, state[1].qvel)
    np.testing.assert_array_equal(seen.body_inertia, bare.body_inertia)


def test_missing_model_is_refused_with_its_path(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.xml"):
        build(PlatformProperties(), tmp_path / "nowhere.xml")


def test_every_element_has_a_name():
    spec = mujoco.MjSpec.from_file(str(shipped_model()))
    elements = [*spec.bodies, *spec.joints, *spec.geoms, *spec.actuators]
    assert all(element.name for element in elements)
