"""What each joint of a user's own model is: a wheel, a gimbal, a gyro's rotor, or locked as drawn.

Parts are recognised by structure first: a wheel is a hinge of the platform about an axis of symmetry of what it turns,
a gyro a hinge that carries such a hinge across its own axis. Motors and names decide what is open then.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from typing import Literal, TypeAlias

import mujoco
import numpy as np

from testbed.errors import InputError
from testbed.plant.own_model import OwnModel

_LIKE = 0.05
"""Share of its spin inertia by which the moments across a rotor's axis may differ, of its radius of gyration by which
its centre of mass may lie off the axis, and cosine of the angle between a rotor's and its gimbal's axis: what is beyond
was not meant as a rotor."""
_NAMED = re.compile(r"(?:^|[^a-z])(?:rwa?|reaction|wheel|flywheel|rotor)", re.IGNORECASE)
"""Names of wheels where no motor shows that a hinge is one."""

Role: TypeAlias = Literal["platform", "wheel", "gimbal", "rotor", "locked"]


@dataclass(frozen=True, kw_only=True)
class Corrections:
    """Names of joints, or of their bodies, that are taken otherwise than the structure suggests.

    Attributes:
        wheel: which are reaction wheels.
        rotor: which are rotors of gyros, whose gimbal is the hinge that carries them.
        ignore: which are locked as drawn.
    """

    wheel: Collection[str] = ()
    rotor: Collection[str] = ()
    ignore: Collection[str] = ()


@dataclass(frozen=True, kw_only=True)
class Taken:
    """A joint of the model and what it was taken for.

    Attributes:
        name: of the joint, or of its body where it has none.
        role: what it was taken for.
        reason: why.
        joint: its number in the model.
        carrier: number of the joint that carries it.
    """

    name: str
    role: Role
    reason: str
    joint: int
    carrier: int


def free_joint(own: OwnModel) -> tuple[int | None, str]:
    """Return the free joint, or the ball joint, by which the platform can turn; or None, and what the model lacks."""
    kinds = own.model.jnt_type
    free = [int(joint) for joint in np.flatnonzero(kinds == mujoco.mjtJoint.mjJNT_FREE)]
    carrying = [joint for joint in free if any(own.joints(body) for body in own.subtree(own.body(joint))[1:])]
    chosen = carrying if len(free) > 1 else free
    if len(chosen) == 1:
        return chosen[0], ""
    if chosen:
        names = ", ".join(own.name(joint) for joint in chosen)
        return None, f"a single platform: {names} are free, and carry other bodies; leave one in the file"
    balls = [int(joint) for joint in np.flatnonzero(kinds == mujoco.mjtJoint.mjJNT_BALL)]
    standing = [joint for joint in balls if not any(own.joints(body) for body in own.ancestors(own.body(joint)))]
    if len(standing) == 1:
        return standing[0], ""
    if standing:
        names = ", ".join(own.name(joint) for joint in standing)
        return None, f"a single platform: {names} are ball joints that stand on the ground; leave one in the file"
    return None, "a body that is free to turn: give that of the platform a <freejoint/>, or a ball joint as its bearing"


def taken_joints(own: OwnModel, base: int, corrections: Corrections) -> tuple[Taken, ...]:
    """Return what each joint of the platform is taken for, the platform's own first.

    Args:
        own: the model.
        base: joint by which the platform is free.
        corrections: what is taken otherwise.

    Raises:
        InputError: a name is none of the model's.
    """
    roles = _Roles(own, base, corrections)
    _require_known(roles)
    roles.require_possible()
    return roles.taken


@dataclass(frozen=True)
class _Roles:
    own: OwnModel
    base: int
    corrections: Corrections

    @cached_property
    def joints(self) -> list[int]:
        """All of the platform but that by which it is free."""
        platform = self.own.subtree(self.own.body(self.base))
        return [joint for body in platform for joint in self.own.joints(body) if joint != self.base]

    @cached_property
    def moving(self) -> list[int]:
        return [joint for joint in self.joints if not self.is_named(joint, self.corrections.ignore)]

    @cached_property
    def carriers(self) -> dict[int, int]:
        """The nearest joint that moves what carries each joint."""
        return {joint: self._carrier(joint) for joint in self.joints}

    @cached_property
    def gimbals(self) -> dict[int, int]:
        """Rotors of gyros, by their gimbals: hinges of the platform that carry one rotor, and nothing else."""
        found = {}
        for gimbal in self.moving:
            carried = self.carried[gimbal]
            if self.carriers[gimbal] == self.base and self._is_hinge(gimbal) and len(carried) == 1:
                rotor = carried[0]
                forced = self.is_named(rotor, self.corrections.rotor)
                if not self.carried[rotor] and (
                    forced or (not self._unlike(rotor) and self._lies_across(rotor, gimbal))
                ):
                    found[gimbal] = rotor
        return found

    @cached_property
    def carried(self) -> dict[int, list[int]]:
        """The moving joints that each joint carries."""
        found: dict[int, list[int]] = {joint: [] for joint in self.joints}
        for joint in self.moving:
            if self.carriers[joint] != self.base:
                found[self.carriers[joint]].append(joint)
        return found

    def require_possible(self) -> None:
        """Refuse corrections that no joint of its kind can follow."""
        for joint in self.joints:
            name, carrier = self.own.name(joint), self.carriers[joint]
            wheel, rotor = (self.is_named(joint, names) for names in (self.corrections.wheel, self.corrections.rotor))
            option = f"{'wheel' if wheel else 'rotor'} {name}"
            if (wheel or rotor) and not self._is_hinge(joint):
                raise InputError(f"{option}: it is no hinge, or not the only joint of its body; nothing else turns one")
            if wheel and carrier != self.base:
                stands = self.own.name(carrier)
                raise InputError(
                    f"{option}: it turns on {stands}, not on the platform; ignore {stands}, which locks that"
                )
            if rotor and joint not in self.gimbals.values():
                text = "a gyro's rotor is carried by a hinge of the platform that carries nothing else; ignore the rest"
                raise InputError(f"{option}: {text}")

    @property
    def taken(self) -> tuple[Taken, ...]:
        reason = "root of the URDF, where nothing is said to be free" if self.own.rooted else "free to move"
        if self.own.model.jnt_type[self.base] == mujoco.mjtJoint.mjJNT_BALL:
            reason = "stands on a ball joint, as on an air bearing"
        platform = Taken(
            name=self.own.name(self.base), role="platform", reason=reason, joint=self.base, carrier=self.base
        )
        return (platform, *(self._taken(joint) for joint in self.joints))

    def is_named(self, joint: int, names: Collection[str]) -> bool:
        """Return whether a joint, or its body, is one of some names."""
        return self.own.name(joint) in names or self.own.model.body(self.own.body(joint)).name in names

    def _taken(self, joint: int) -> Taken:
        role, reason = self._role(joint)
        return Taken(name=self.own.name(joint), role=role, reason=reason, joint=joint, carrier=self.carriers[joint])

    def _role(self, joint: int) -> tuple[Role, str]:
        if joint not in self.moving:
            return "locked", "as ignore says"
        if self.is_named(joint, self.corrections.wheel):
            return "wheel", "as wheel says"
        if joint in self.gimbals:
            return "gimbal", f"carries the rotor {self.own.name(self.gimbals[joint])} across its axis"
        for gimbal, rotor in self.gimbals.items():
            if joint == rotor:
                return "rotor", f"turns about an axis of symmetry, across the gimbal {self.own.name(gimbal)}"
        return self._wheel_or_locked(joint)

    def _wheel_or_locked(self, joint: int) -> tuple[Role, str]:
        unlike = self._unlike(joint)
        if unlike:
            return "locked", unlike
        if self.carriers[joint] != self.base:
            return "locked", f"turns on {self.own.name(self.carriers[joint])}, not on the platform itself"
        if self.carried[joint]:
            return "locked", f"carries {', '.join(map(self.own.name, self.carried[joint]))}"
        if self.own.is_driven(joint):
            return "wheel", "turns about an axis of symmetry, and has a motor"
        if _NAMED.search(self._names(joint)):
            return "wheel", "turns about an axis of symmetry, and is named as a wheel"
        return "locked", "has no motor, and is not named as a wheel"

    def _names(self, joint: int) -> str:
        return f"{self.own.name(joint)} {self.own.model.body(self.own.body(joint)).name}"

    def _carrier(self, joint: int) -> int:
        bodies = self.own.ancestors(self.own.body(joint))
        moving = (each for body in bodies for each in self.own.joints(body) if each == self.base or each in self.moving)
        return next(moving, self.base)

    def _is_hinge(self, joint: int) -> bool:
        alone = len(self.own.joints(self.own.body(joint))) == 1
        return alone and self.own.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE

    def _unlike(self, joint: int) -> str:
        """Return why a joint turns no rotor; nothing where it may."""
        if not self._is_hinge(joint):
            return "is no hinge, or not the only joint of its body"
        rotor = self.own.rotor(joint)
        if rotor.spin_inertia <= 0.0 or rotor.mass <= 0.0:
            return "turns nothing that has a mass"
        if rotor.offset > _LIKE * rotor.gyration:
            return f"turns what has its centre of mass {rotor.offset:.3g} m off the axis"
        if rotor.asymmetry > _LIKE:
            return "turns what is not symmetric about the axis"
        return ""

    def _lies_across(self, rotor: int, gimbal: int) -> bool:
        axes = self.own.drawn.xaxis
        return bool(abs(axes[rotor] @ axes[gimbal]) < _LIKE)


def _require_known(roles: _Roles) -> None:
    """Refuse names that are none of the platform's joints, nor of their bodies."""
    own = roles.own
    joints = [own.name(joint) for joint in roles.joints]
    known = {*joints, *(own.model.body(own.body(joint)).name for joint in roles.joints)}
    for option in ("wheel", "rotor", "ignore"):
        for name in getattr(roles.corrections, option):
            if name not in known:
                near = get_close_matches(name, known, n=1)
                hint = f"did you mean {near[0]}?" if near else f"they are {', '.join(joints)}"
                raise InputError(f"{option} {name}: the platform of {own.path} has no such joint or body; {hint}")
