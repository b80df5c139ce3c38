"""A user's own model as it is read: compiled, as drawn, with what its motors and joints can do."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import mujoco
import numpy as np

from testbed.arrays import Matrix3, Vector3
from testbed.errors import InputError
from testbed.plant.bounds import require_bounded, xml_root
from testbed.plant.geometry import inertia_about

MOST_JOINTS = 200
"""More than twice the joints of as many gyros and wheels as are flown."""
_MOST = 1e9
"""kg and kg·m², more than anything has that flies; their products would overflow."""
_LEFT_OUT = ("visual", "collision")
"""Elements of a URDF's link that name meshes, which may lie anywhere, and say nothing of its motion."""


class Composite(NamedTuple):
    """Some bodies as one rigid one.

    Attributes:
        mass: kg.
        center_N: of mass, shape (3,), m, inertial axes.
        inertia_N: about it, shape (3, 3), kg·m², inertial axes.
    """

    mass: float
    center_N: Vector3
    inertia_N: Matrix3


class Rotor(NamedTuple):
    """What a hinge turns, about its axis.

    Attributes:
        mass: kg.
        center_N: of mass, shape (3,), m, inertial axes.
        offset: of the centre of mass from the axis, m.
        spin_inertia: about the axis through the centre of mass, kg·m².
        transverse_inertia: the mean of those across the axis, kg·m².
        asymmetry: what keeps the axis from being one of symmetry, as a share of the spin inertia: half the difference
            of the moments across it, and the products of inertia with it.
    """

    mass: float
    center_N: Vector3
    offset: float
    spin_inertia: float
    transverse_inertia: float
    asymmetry: float

    @property
    def gyration(self) -> float:
        """Radius of gyration about the axis, m."""
        return float(np.sqrt(self.spin_inertia / self.mass))


@dataclass(frozen=True, kw_only=True)
class OwnModel:
    """A compiled model, as drawn. Every joint has a name: its own, or else its body's.

    Attributes:
        path: of the file.
        spec: of which it was compiled.
        model: compiled.
        speeds: largest speed of joints that state one, rad/s, by name.
        rooted: name of the root of a URDF that says of nothing that it is free; empty otherwise.
    """

    path: Path
    spec: mujoco.MjSpec
    model: mujoco.MjModel
    speeds: Mapping[str, float]
    rooted: str

    @cached_property
    def drawn(self) -> mujoco.MjData:
        """All positions, as drawn."""
        data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        return data

    def name(self, joint: int) -> str:
        """Return the name of a joint."""
        return str(self.model.joint(joint).name)

    def body(self, joint: int) -> int:
        """Return the body that a joint moves."""
        return int(self.model.jnt_bodyid[joint])

    def joints(self, body: int) -> range:
        """Return the joints of a body."""
        first = int(self.model.body_jntadr[body])
        return range(first, first + int(self.model.body_jntnum[body]))

    def ancestors(self, body: int) -> Iterator[int]:
        """Yield the bodies that carry a body, the nearest first, the world last."""
        while body:
            body = int(self.model.body_parentid[body])
            yield body

    def subtree(self, body: int) -> list[int]:
        """Return a body and all that it carries."""
        carried = np.zeros(self.model.nbody, dtype=np.bool_)
        carried[body] = True
        for each in range(body + 1, self.model.nbody):  # what carries a body comes before it
            carried[each] = carried[self.model.body_parentid[each]]
        return [int(each) for each in np.flatnonzero(carried)]

    def composite(self, bodies: Iterable[int]) -> Composite:
        """Return some bodies as one."""
        chosen, data, model = list(bodies), self.drawn, self.model
        mass = float(model.body_mass[chosen].sum())
        center = model.body_mass[chosen] @ data.xipos[chosen] / mass if mass > 0.0 else data.xipos[chosen[0]]
        return Composite(mass, np.asarray(center), inertia_about(model, data, chosen, center))

    def rotor(self, joint: int, without: Collection[int] = ()) -> Rotor:
        """Return what a hinge turns about its axis.

        Args:
            joint: the hinge.
            without: bodies of it that are left out.
        """
        axis, turned = self.drawn.xaxis[joint], self.subtree(self.body(joint))
        mass, center, inertia = self.composite(body for body in turned if body not in without)
        arm = center - self.drawn.xanchor[joint]
        spin = float(axis @ inertia @ axis)
        transverse = 0.5 * (np.trace(inertia) - spin)
        symmetric = transverse * np.eye(3) + (spin - transverse) * np.outer(axis, axis)
        return Rotor(
            mass=mass,
            center_N=center,
            offset=float(np.linalg.norm(arm - (arm @ axis) * axis)),
            spin_inertia=spin,
            transverse_inertia=float(transverse),
            asymmetry=float(np.abs(np.linalg.eigvalsh(inertia - symmetric)).max() / spin) if spin > 0.0 else 0.0,
        )

    def motors(self, joint: int) -> list[int]:
        """Return the actuators of a joint that can turn it: without a gear they give no torque."""
        model = self.model
        kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
        of_joints = np.isin(model.actuator_trntype, [int(kind) for kind in kinds])
        of_this = of_joints & (model.actuator_trnid[:, 0] == joint) & (model.actuator_gear[:, 0] != 0.0)
        return [int(each) for each in np.flatnonzero(of_this)]

    def is_driven(self, joint: int) -> bool:
        """Return whether a joint has a motor; URDF, which knows none, states the effort of one."""
        return bool(self.motors(joint)) or bool(self.model.jnt_actfrclimited[joint])

    def torque_limit(self, joint: int) -> float | None:
        """Return the largest torque of a joint's motor, N·m; None where the model states none."""
        model, limits = self.model, []
        if model.jnt_actfrclimited[joint]:
            limits.append(np.abs(model.jnt_actfrcrange[joint]).max())
        for motor in self.motors(joint):
            gear = abs(model.actuator_gear[motor, 0])
            if model.actuator_forcelimited[motor]:
                limits.append(gear * np.abs(model.actuator_forcerange[motor]).max())
            if model.actuator_ctrllimited[motor] and model.actuator_biastype[motor] == mujoco.mjtBias.mjBIAS_NONE:
                gain = abs(model.actuator_gainprm[motor, 0])
                limits.append(gear * gain * np.abs(model.actuator_ctrlrange[motor]).max())
        return float(min(limits)) if limits and min(limits) > 0.0 else None

    def speed_limit(self, joint: int) -> float | None:
        """Return the largest speed of a joint, rad/s: as stated, or as its drive can be commanded; None without one."""
        model, limits = self.model, [self.speeds.get(self.name(joint), inf)]
        for motor in self.motors(joint):
            loop, gear = -model.actuator_biasprm[motor, 2], abs(model.actuator_gear[motor, 0])
            if self.loop_gain(joint) > 0.0 and model.actuator_ctrllimited[motor]:
                gain = abs(model.actuator_gainprm[motor, 0])
                limits.append(gain * np.abs(model.actuator_ctrlrange[motor]).max() / (loop * gear))
        return float(min(limits)) if min(limits) < inf else None

    def loop_gain(self, joint: int) -> float:
        """Return the torque of a joint's drives against its speed, N·m·s/rad; 0 where they give torque as commanded."""
        model = self.model
        affine = [m for m in self.motors(joint) if model.actuator_biastype[m] == mujoco.mjtBias.mjBIAS_AFFINE]
        return float(sum(-model.actuator_biasprm[each, 2] * model.actuator_gear[each, 0] ** 2 for each in affine))


def read_own_model(path: Path) -> OwnModel:
    """Read an MJCF or a URDF with MuJoCo.

    Args:
        path: of the file.

    Raises:
        InputError: it is neither, asks for more memory than any platform takes, or MuJoCo cannot compile it.
    """
    root, speeds, rooted = xml_root(path), dict[str, float](), ""
    try:
        if root.tag == "robot":
            spec, speeds, rooted = _urdf(root, path)
        elif root.tag == "mujoco":
            require_bounded(path)
            spec = mujoco.MjSpec.from_file(str(path))
        else:
            raise InputError(f"{path}: begins with <{root.tag}>; give an MJCF (<mujoco>) or a URDF (<robot>)")
        _name_joints(spec)
        model = spec.compile()
    except ValueError as error:
        raise InputError(f"{path}: MuJoCo cannot read it: {' '.join(str(error).split())}; mend it there") from error
    _drop_disabled(model)
    if model.njnt > MOST_JOINTS:
        raise InputError(f"{path}: has {model.njnt} joints; at most {MOST_JOINTS} are read")
    if max(model.body_mass.max(), model.body_inertia.max()) > _MOST:
        raise InputError(f"{path}: has a body of more than {_MOST:g} kg or kg·m²; mend it there")
    return OwnModel(path=path, spec=spec, model=model, speeds=speeds, rooted=rooted)


def _drop_disabled(model: mujoco.MjModel) -> None:
    """Set to zero what the model's own flags keep from acting, so that it is neither flown nor said to be left out."""
    flags = mujoco.mjtDisableBit
    for flag, numbers in (
        (flags.mjDSBL_SPRING, (model.jnt_stiffness, model.jnt_stiffnesspoly)),
        (
            flags.mjDSBL_DAMPER,
            (model.dof_damping, model.dof_dampingpoly, model.actuator_damping, model.actuator_dampingpoly),
        ),
        (flags.mjDSBL_FRICTIONLOSS, (model.dof_frictionloss,)),
        (flags.mjDSBL_LIMIT, (model.jnt_limited,)),
        (flags.mjDSBL_CONSTRAINT, (model.dof_frictionloss, model.jnt_limited)),
        (flags.mjDSBL_GRAVITY, (model.opt.gravity,)),
    ):
        if model.opt.disableflags & flag:
            for each in numbers:
                each[:] = 0


def _urdf(root: ElementTree.Element, path: Path) -> tuple[mujoco.MjSpec, dict[str, float], str]:
    """Return a URDF's model, with its root free to move unless it says otherwise, its joints' speeds, and the root.

    Raises:
        InputError: nothing is said to be free, and it has not one root.
    """
    for link in root.iter("link"):
        for kind in _LEFT_OUT:
            for element in link.findall(kind):
                link.remove(element)
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
    limits = ((joint.get("name", ""), joint.find("limit")) for joint in root.iter("joint"))
    stated = {name: float(limit.get("velocity", "0")) for name, limit in limits if limit is not None}
    speeds = {name: speed for name, speed in stated.items() if speed > 0.0}
    if any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in spec.joints):
        return spec, speeds, ""
    bodies = spec.worldbody.bodies
    if not bodies:
        raise InputError(f"{path}: has no link that could be the platform; give it one with an <inertial>")
    if len(bodies) > 1:
        names = ", ".join(body.name for body in bodies)
        raise InputError(
            f"{path}: has {len(bodies)} root links, {names}, where the only one would be the platform; "
            "join the others to it by joints, or delete them"
        )
    bodies[0].add_freejoint()
    return spec, speeds, str(bodies[0].name)


def _name_joints(spec: mujoco.MjSpec) -> None:
    """Give each joint without a name that of its body, or else a number."""
    names = {joint.name for joint in spec.joints}
    for number, joint in enumerate(spec.joints, start=1):
        if not joint.name:
            own = str(joint.parent.name)
            joint.name = own if own and own not in names else f"joint{number}"
            names.add(joint.name)
