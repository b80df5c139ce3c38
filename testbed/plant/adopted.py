"""What a user's own model, MJCF or URDF, has of a platform: its body, its wheels, its control moment gyros."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from testbed.arrays import Matrix3, Quaternion, Vector3
from testbed.errors import InputError
from testbed.plant.adopted_notes import left_out
from testbed.plant.adopted_roles import Corrections, Taken, free_joint, taken_joints
from testbed.plant.own_model import OwnModel, Rotor, read_own_model

_ROUNDED = 1e-5
"""Share by which the six digits that models are written with leave a rotor unbalanced or an axis askew; what is more is
said."""
_NOTHING = 1e-14
"""Component of an axis that is the rounding of a turn by a right angle."""
_LARGEST = 50.0
"""m. √(tr J / m) beyond which a model's lengths are in another unit: of the International Space Station it is 32 (4.3e8
kg·m² of 4.2e5 kg); of a small satellite in millimetres 60 and more."""
_LEAST = 1e-12
"""kg·m²; the least spin inertia that a scenario takes."""


@dataclass(frozen=True, kw_only=True)
class Spinning:
    """A rotor as drawn.

    Attributes:
        name: of its joint.
        axis_B: shape (3,), unit vector, body axes.
        position_B: of its centre of mass from the platform's, shape (3,), m, body axes.
        mass: kg.
        spin_inertia: kg·m².
        transverse_inertia: the mean of those across the axis, kg·m².
        torque_limit: of its motor, N·m; None where the model states none.
        speed_limit: rad/s; None where the model states none.
        speed: in the model's first keyframe, rad/s; 0 without one.
        is_driven: whether it has a motor.
        loop_gain: of its motor against its speed, N·m·s/rad; 0 where it gives torque as commanded.
        viscous_friction: N·m·s/rad.
        dry_friction: N·m.
    """

    name: str
    axis_B: Vector3
    position_B: Vector3
    mass: float
    spin_inertia: float
    transverse_inertia: float
    torque_limit: float | None
    speed_limit: float | None
    speed: float
    is_driven: bool
    loop_gain: float
    viscous_friction: float
    dry_friction: float


@dataclass(frozen=True, kw_only=True)
class FoundGyro:
    """A gimbal and its rotor.

    Attributes:
        name: of the gimbal's joint.
        axis_B: of the gimbal, shape (3,), unit vector, body axes.
        inertia: of the gimbal body about its axis, rotor not included, kg·m².
        mass: of the gimbal body, kg.
        torque_limit: of its motor, N·m; None where the model states none.
        rate_limit: rad/s; None where the model states none.
        rotor: its axis is normal to the gimbal's, its centre of mass on that, and its speed positive.
        is_reversed: whether its axis is for that against the joint's.
    """

    name: str
    axis_B: Vector3
    inertia: float
    mass: float
    torque_limit: float | None
    rate_limit: float | None
    rotor: Spinning
    is_reversed: bool


@dataclass(frozen=True, kw_only=True)
class Bearing:
    """A ball joint that the platform stands on.

    Attributes:
        offset_B: from the pivot to the centre of mass, shape (3,), m, body axes.
        gravity: m/s², along -z of the model's world.
        drag: of the joint, N·m·s/rad.
        attitude: quat_NB as drawn, shape (4,).
    """

    offset_B: Vector3
    gravity: float
    drag: float
    attitude: Quaternion


@dataclass(frozen=True, kw_only=True)
class AdoptedPlatform:
    """A platform as a user's model has it.

    Attributes:
        own: the model.
        mass: of the whole platform, kg.
        inertia: J of the whole platform about its centre of mass, everything locked as drawn, kg·m², body axes.
        wheels: in the order of the model.
        gyros: likewise.
        taken: every joint, and what it was taken for.
        notes: what of the model a scenario cannot say.
        bearing: what it stands on; None of a platform that floats.
    """

    own: OwnModel
    mass: float
    inertia: Matrix3
    wheels: tuple[Spinning, ...]
    gyros: tuple[FoundGyro, ...]
    taken: tuple[Taken, ...]
    notes: tuple[str, ...]
    bearing: Bearing | None

    @property
    def locked(self) -> tuple[Taken, ...]:
        """Joints that were taken for no actuator."""
        return tuple(each for each in self.taken if each.role == "locked")


def adopted_platform(path: Path, corrections: Corrections) -> AdoptedPlatform:
    """Read a model and find the platform in it.

    Args:
        path: MJCF or URDF.
        corrections: what is taken otherwise.

    Raises:
        InputError: the file cannot be read, or lacks something that a platform needs; all of it is listed.
    """
    own = read_own_model(path)
    base, lack = free_joint(own)
    if base is None:
        raise InputError(f"{path}: lacks {lack}")
    taken = taken_joints(own, base, corrections)
    found = _Found(own, base, taken)
    lacks = [*_lacking(taken), *found.lacking()]
    if lacks:
        raise InputError("\n  ".join([f"{path}: lacks what a platform needs:", *lacks]))
    return found.platform()


def _lacking(taken: tuple[Taken, ...]) -> Iterator[str]:
    if any(each.role in {"wheel", "gimbal"} for each in taken):
        return
    yield (
        "actuators: a reaction wheel is a hinge of the platform about an axis of symmetry of what it turns, a control "
        "moment gyro a hinge that carries such a hinge across its axis; give the model one, with a motor"
    )
    for each in taken:
        if each.role == "locked":
            yield f"the joint {each.name} is none: it {each.reason}"
    yield "where a joint is one in spite of that, name it as a wheel"


class _Found:
    """What is read off a model whose joints are known."""

    def __init__(self, own: OwnModel, base: int, taken: tuple[Taken, ...]) -> None:
        self._own, self._base, self._taken = own, base, taken
        self._axes = own.drawn.xmat[own.body(base)].reshape(3, 3)
        self._whole = own.composite(own.subtree(own.body(base)))
        self._size = float(np.sqrt(np.trace(self._whole.inertia_N) / self._whole.mass))

    def lacking(self) -> Iterator[str]:
        """Yield what the bodies lack."""
        if self._size > _LARGEST:
            yield (
                f"lengths in metres: √(tr J / m) is {self._size:.3g} m, more than of any spacecraft; write lengths in "
                "m and inertia in kg·m²"
            )
        for each in self._in("wheel", "rotor"):
            spin = self._own.rotor(each.joint).spin_inertia
            if spin < _LEAST:
                yield f"inertia of {each.name}: it has {spin:.3g} kg·m² about its axis; give its body one"

    def platform(self) -> AdoptedPlatform:
        gyros = tuple(self._gyro(each) for each in self._in("gimbal"))
        return AdoptedPlatform(
            own=self._own,
            mass=self._whole.mass,
            inertia=_symmetric(self._axes.T @ self._whole.inertia_N @ self._axes),
            wheels=tuple(self._spinning(each, self._own.rotor(each.joint)) for each in self._in("wheel")),
            gyros=gyros,
            taken=self._taken,
            notes=tuple(self._notes()),
            bearing=self._bearing(),
        )

    def _bearing(self) -> Bearing | None:
        own, base = self._own, self._base
        if own.model.jnt_type[base] != mujoco.mjtJoint.mjJNT_BALL:
            return None
        gravity_N = own.model.opt.gravity
        return Bearing(
            offset_B=-self._place(own.drawn.xanchor[base]),
            gravity=float(np.linalg.norm(gravity_N)),
            drag=float(own.model.dof_damping[own.model.jnt_dofadr[base]]),
            attitude=np.array(own.drawn.xquat[own.body(base)]),
        )

    def _in(self, *roles: str) -> list[Taken]:
        return [each for each in self._taken if each.role in roles]

    def _rotor_of(self, gimbal: Taken) -> Taken:
        return next(each for each in self._in("rotor") if each.carrier == gimbal.joint)

    def _direction(self, joint: int) -> Vector3:
        axis = self._axes.T @ self._own.drawn.xaxis[joint]
        axis[np.abs(axis) < _NOTHING] = 0.0
        return np.asarray(axis / np.linalg.norm(axis))

    def _place(self, point_N: Vector3) -> Vector3:
        """Return where a point is, from the platform's centre of mass, body axes."""
        return np.asarray(self._axes.T @ (point_N - self._whole.center_N))

    def _spinning(self, taken: Taken, rotor: Rotor) -> Spinning:
        own, joint = self._own, taken.joint
        freedom, keys = int(own.model.jnt_dofadr[joint]), own.model.key_qvel
        return Spinning(
            name=taken.name,
            axis_B=self._direction(joint),
            position_B=self._place(rotor.center_N),
            mass=rotor.mass,
            spin_inertia=rotor.spin_inertia,
            transverse_inertia=rotor.transverse_inertia,
            torque_limit=own.torque_limit(joint),
            speed_limit=own.speed_limit(joint),
            speed=float(keys[0, freedom]) if len(keys) else 0.0,
            is_driven=own.is_driven(joint),
            loop_gain=own.loop_gain(joint),
            viscous_friction=float(own.model.dof_damping[freedom]),
            dry_friction=float(own.model.dof_frictionloss[freedom]),
        )

    def _gimbal_body(self, gimbal: Taken) -> Rotor:
        """Return what a gimbal turns beside its rotor; its spin inertia is about the joint's axis."""
        rotor = self._own.subtree(self._own.body(self._rotor_of(gimbal).joint))
        return self._own.rotor(gimbal.joint, without=rotor)

    def _gyro(self, gimbal: Taken) -> FoundGyro:
        own, taken, body = self._own, self._rotor_of(gimbal), self._gimbal_body(gimbal)
        rotor = self._spinning(taken, own.rotor(taken.joint))
        axis_B, anchor_B = self._direction(gimbal.joint), self._place(own.drawn.xanchor[gimbal.joint])
        spin_B = rotor.axis_B - (rotor.axis_B @ axis_B) * axis_B
        spin_B *= (-1.0 if rotor.speed < 0.0 else 1.0) / np.linalg.norm(spin_B)
        on_axis_B = anchor_B + ((rotor.position_B - anchor_B) @ axis_B) * axis_B
        return FoundGyro(
            name=gimbal.name,
            axis_B=axis_B,
            inertia=body.spin_inertia + body.mass * body.offset**2,
            mass=body.mass,
            torque_limit=own.torque_limit(gimbal.joint),
            rate_limit=own.speed_limit(gimbal.joint),
            rotor=replace(rotor, axis_B=spin_B, position_B=on_axis_B, speed=abs(rotor.speed)),
            is_reversed=rotor.speed < 0.0,
        )

    def _notes(self) -> Iterator[str]:
        """Yield what of the model a scenario cannot say."""
        own = self._own
        for each in self._in("wheel", "rotor"):
            rotor = own.rotor(each.joint)
            if rotor.offset > _ROUNDED * rotor.gyration:
                yield f"{each.name}: its centre of mass is {rotor.offset:.2g} m off its axis; it is flown as balanced"
            if rotor.asymmetry > _ROUNDED:
                yield f"{each.name}: it is not symmetric about its axis; it is flown with the mean of its moments"
        for each in self._in("gimbal"):
            yield from self._gimbal_notes(each)
        yield from left_out(own, self._taken)

    def _gimbal_notes(self, gimbal: Taken) -> Iterator[str]:
        own, taken, body = self._own, self._rotor_of(gimbal), self._gimbal_body(gimbal)
        rotor, axis_B = own.rotor(taken.joint), self._direction(gimbal.joint)
        askew = abs(axis_B @ self._direction(taken.joint))
        if askew > _ROUNDED:
            angle = np.degrees(np.arccos(askew))
            yield f"{taken.name}: its axis is {angle:.4g}° from that of {gimbal.name}; it is flown at 90°"
        arm = self._place(rotor.center_N) - self._place(own.drawn.xanchor[gimbal.joint])
        offset = max(float(np.linalg.norm(arm - (arm @ axis_B) * axis_B)), body.offset)
        if offset > _ROUNDED * self._size:
            yield f"{gimbal.name}: what it turns is {offset:.2g} m off its axis; it is flown on it"
        if body.asymmetry * body.spin_inertia > _ROUNDED * rotor.spin_inertia:
            yield f"{gimbal.name}: its body is not symmetric about its axis; it is flown as if it were"


def _symmetric(matrix: Matrix3) -> Matrix3:
    return np.asarray(0.5 * (matrix + matrix.T))
