"""What additions do to a compiled platform: torques by hand calculation, parts by mass, inertia and frequency."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from testbed.arrays import Array
from testbed.errors import InputError
from testbed.plant.added_parts import AddedInertia, HingedMode, SprungMass
from testbed.plant.added_torques import BodyTorque, InertialTorque, QuadraticRateTorque, RateTorque, Tether
from testbed.plant.additions import Addition
from testbed.plant.build import shipped_model, specification
from testbed.plant.extended import extended_platform
from testbed.plant.geometry import composite_inertia, composite_mass
from testbed.plant.properties import PlatformProperties
from testbed.rotation.quaternion import exponential, matrix_of, quaternion_inverse, quaternion_product

RATE = np.array([0.5, -0.3, 0.2])
VALUES = np.array([1.2e-3, 2e-3, 3e-3])
RELEASED = exponential(np.array([0.1, 0.4, -0.2]))
TURN = np.array([0.3, -0.8, 0.5])
ATTITUDE = quaternion_product(RELEASED, exponential(TURN))
INERTIA = np.array([[0.02204, 0.00108, 0.00004], [0.00108, 0.02126, 0.00009], [0.00004, 0.00009, 0.02575]])


def written(*additions: Addition) -> mujoco.MjModel:
    """The platform as read back from the file that is written of it."""
    properties = PlatformProperties(inertia=INERTIA, mass=4.0)
    return mujoco.MjModel.from_xml_string(extended_platform(properties, None, additions))


def torque_on(model: mujoco.MjModel) -> Array:
    data = mujoco.MjData(model)
    data.qpos[3:7], data.qvel[3:6] = ATTITUDE, RATE
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.qfrc_actuator[:3], 0.0, atol=1e-15)  # torques push nothing away
    return np.array(data.qfrc_actuator[3:6])


@pytest.mark.parametrize(
    ("addition", "expected"),
    [
        (RateTorque(coefficient=VALUES), -VALUES * RATE),
        (QuadraticRateTorque(coefficient=VALUES), -VALUES * RATE * np.abs(RATE)),
        (BodyTorque(torque_B=VALUES), VALUES),
        (
            InertialTorque(torque=VALUES, quat_NA=RELEASED),
            matrix_of(quaternion_inverse(ATTITUDE)) @ matrix_of(RELEASED) @ VALUES,
        ),
        (
            Tether(stiffness=VALUES, damping=VALUES[::-1], quat_NB=RELEASED),
            -VALUES * TURN - VALUES[::-1] * RATE,
        ),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Addition) else "",
)
def test_torques(addition, expected):
    np.testing.assert_allclose(
        torque_on(written(addition)), expected, atol=1e-8
    )  # six digits of 4e-3 N·m and of a quaternion


def test_torques_add_up():
    both = torque_on(written(RateTorque(coefficient=VALUES), BodyTorque(torque_B=VALUES)))
    np.testing.assert_allclose(both, VALUES - VALUES * RATE, atol=4e-9)


@pytest.mark.parametrize(
    "addition",
    [
        HingedMode(inertia=1e-3, axis_B=np.array([0.6, 0.0, 0.8]), stiffness=0.2, damping=1e-4),
        SprungMass(reduced_mass=0.1, arm_B=np.array([0.05, 0.03, -0.02]), stiffness=20.0, damping=0.1),
    ],
    ids=lambda addition: type(addition).__name__,
)
def test_parts_leave_the_platform_at_rest_as_it_was(addition):
    model = written(addition)
    assert composite_mass(model) == pytest.approx(4.0, abs=1e-5)  # six digits
    np.testing.assert_allclose(composite_inertia(model), INERTIA, atol=1e-7)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.subtree_com[model.body("bus").id], 0.0, atol=1e-6)


def test_inertia_is_added():
    change = 1e-3 * np.diag([1.0, 2.0, -1.0])
    np.testing.assert_allclose(composite_inertia(written(AddedInertia(inertia=change))), INERTIA + change, atol=1e-7)


def test_a_part_that_the_bus_cannot_give_is_refused():
    too_much = HingedMode(inertia=0.05, axis_B=np.array([0.0, 0.0, 1.0]), stiffness=1.0, damping=0.0)
    with pytest.raises(InputError, match="which no body has"):
        too_much.write(specification(PlatformProperties(), shipped_model()), "added1")


def test_a_part_that_no_body_can_carry_is_refused_whatever_is_added_after_it():
    heavy = HingedMode(inertia=1.2e-2, axis_B=np.array([0.6, 0.0, 0.8]), stiffness=0.2, damping=1e-4)
    mass = SprungMass(reduced_mass=0.1, arm_B=np.array([0.05, 0.03, -0.02]), stiffness=20.0, damping=0.1)
    for additions in ([heavy], [heavy, mass]):
        with pytest.raises(InputError, match="no platform that could fly"):
            written(*additions)
