"""A platform as a file for other programs, MJCF or URDF, with every digit of its mass and inertia."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import scipy

from testbed.arrays import Array, Matrix3, Quaternion
from testbed.errors import InputError
from testbed.plant.build import build
from testbed.plant.extended import extended_platform
from testbed.plant.geometry import composite_inertia, composite_mass
from testbed.plant.properties import PlatformProperties


def platform_mjcf(properties: PlatformProperties, path: Path | None) -> str:
    """Return the MJCF of a platform.

    MuJoCo writes six digits; what they lose of the whole platform's mass and inertia is given to the bus, whose own
    numbers are written with all digits.

    Args:
        properties: its numbers; None fields keep the MJCF's.
        path: the MJCF; the shipped platform where absent.

    Raises:
        InputError: as `testbed.plant.build.build`.
    """
    exact = build(properties, path, visuals=False)
    root = ElementTree.fromstring(extended_platform(properties, path, ()))
    inertial = root.find(".//body[@name='bus']/inertial")
    assert inertial is not None
    bus = exact.body("bus")
    mass, inertia = float(bus.mass[0]), _inertia(exact, bus.id)
    for _ in range(2):  # the second time the numbers are the first's, and what the first left is 1e-6 of 1e-6
        inertial.attrib = {"pos": _numbers(bus.ipos), "mass": repr(mass), "fullinertia": _numbers(_six(inertia))}
        written = mujoco.MjModel.from_xml_string(_text(root))
        mass += composite_mass(exact) - composite_mass(written)
        inertia += composite_inertia(exact) - composite_inertia(written)
    return _text(root)


def body_mjcf(name: str, mass: float, inertia: Matrix3) -> str:
    """Return the MJCF of a free body without actuators.

    Args:
        name: of the model.
        mass: kg.
        inertia: about its centre of mass, where its axes begin, shape (3, 3), kg·m².
    """
    root = ElementTree.Element("mujoco", model=name)
    ElementTree.SubElement(root, "option", gravity="0 0 0", integrator="RK4")
    body = ElementTree.SubElement(ElementTree.SubElement(root, "worldbody"), "body", name="bus")
    ElementTree.SubElement(body, "freejoint")
    moments = _numbers(_six(inertia))
    ElementTree.SubElement(body, "inertial", pos="0 0 0", mass=repr(mass), fullinertia=moments)
    return _text(root)


def body_urdf(name: str, mass: float, inertia: Matrix3) -> str:
    """Return the URDF of a free body without actuators; as `body_mjcf`."""
    robot = ElementTree.Element("robot", name=name)
    _add_inertial(ElementTree.SubElement(robot, "link", name="bus"), np.zeros(3), mass, inertia)
    return _text(robot)


def platform_urdf(properties: PlatformProperties, path: Path | None) -> str:
    """Return the URDF of a platform: a link for the bus, each gimbal and each rotor, with a joint between them.

    URDF knows neither motors nor a rotor's momentum: both stay in the MJCF. The bus is the root, free to move.

    Args:
        properties: its numbers; None fields keep the MJCF's.
        path: the MJCF; the shipped platform where absent.

    Raises:
        InputError: as `testbed.plant.build.build`; or a joint of the MJCF is none that URDF knows.
    """
    model = build(properties, path, visuals=False)
    robot = ElementTree.Element("robot", name="platform")
    # Without it MuJoCo would weld the root to the world, and its inertia be lost.
    ElementTree.SubElement(
        ElementTree.SubElement(robot, "mujoco"), "compiler", fusestatic="false", balanceinertia="false"
    )
    bus = model.body("bus").id
    for body in (body for body in range(model.nbody) if model.body_rootid[body] == bus):
        _add_link(robot, model, body)
        if body != bus:
            _add_joint(robot, model, body)
    return _text(robot)


def _add_link(robot: ElementTree.Element, model: mujoco.MjModel, body: int) -> None:
    link = ElementTree.SubElement(robot, "link", name=model.body(body).name)
    _add_inertial(link, model.body_ipos[body], float(model.body_mass[body]), _inertia(model, body))


def _add_inertial(link: ElementTree.Element, center_B: Array, mass: float, inertia: Matrix3) -> None:
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_numbers(center_B), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    moments = zip(names, _six(inertia), strict=True)
    ElementTree.SubElement(inertial, "inertia", {name: repr(float(moment)) for name, moment in moments})


def _add_joint(robot: ElementTree.Element, model: mujoco.MjModel, body: int) -> None:
    """Add the joint that holds a body to its parent.

    Raises:
        InputError: it is none that URDF knows.
    """
    name, count = model.body(body).name, int(model.body_jntnum[body])
    first = int(model.body_jntadr[body])
    hinge = count == 1 and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_HINGE and not model.jnt_pos[first].any()
    if count and not hinge:
        raise InputError(f"{name}: URDF has no such joint, only a hinge through its body's origin: write MJCF instead")
    joint = ElementTree.SubElement(robot, "joint", name=f"{name}_joint", type="continuous" if hinge else "fixed")
    ElementTree.SubElement(joint, "parent", link=model.body(int(model.body_parentid[body])).name)
    ElementTree.SubElement(joint, "child", link=name)
    rpy = _roll_pitch_yaw(model.body_quat[body])
    ElementTree.SubElement(joint, "origin", xyz=_numbers(model.body_pos[body]), rpy=_numbers(rpy))
    if hinge:
        ElementTree.SubElement(joint, "axis", xyz=_numbers(model.jnt_axis[first]))


def _roll_pitch_yaw(quat: Quaternion) -> Array:
    """Return the turns about the fixed axes x, y and z, in this order, rad."""
    return np.asarray(
        scipy.spatial.transform.Rotation.from_quat(quat, scalar_first=True).as_euler("xyz", suppress_warnings=True)
    )


def _inertia(model: mujoco.MjModel, body: int) -> Matrix3:
    """Return the inertia of one body about its own centre of mass, kg·m², in its axes."""
    rotation = scipy.spatial.transform.Rotation.from_quat(model.body_iquat[body], scalar_first=True).as_matrix()
    return np.asarray(rotation @ np.diag(model.body_inertia[body]) @ rotation.T)


def _six(inertia: Matrix3) -> Array:
    """Return the entries xx, yy, zz, xy, xz, yz, as both formats have them."""
    return np.array([*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]])


def _numbers(values: Sequence[float] | Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _text(root: ElementTree.Element) -> str:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
