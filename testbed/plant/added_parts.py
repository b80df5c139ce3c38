"""Parts that effects add to the bus, whose mass and inertia at rest they leave as they were, and further inertia."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np
from typing_extensions import override

from testbed.arrays import Matrix3, Vector3
from testbed.errors import InputError
from testbed.plant.additions import Addition

_POINT_INERTIA = 1e-10
"""kg·m². MuJoCo moves no body without; it is 1e-8 of the platform's."""
_DISC_MASS = 1e-3
"""kg; a hinged disc's centre stays where the platform's is, so that its mass has no effect."""


@final
@dataclass(frozen=True, kw_only=True)
class AddedInertia(Addition):
    """Inertia that the whole platform has beyond what is believed.

    Attributes:
        inertia: symmetric, kg·m², body axes.
    """

    inertia: Matrix3

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        _change_bus(spec, self.inertia, name)


@final
@dataclass(frozen=True, kw_only=True)
class HingedMode(Addition):
    """A disc about the platform's centre that turns about its axis on a spring and damper: one mode of an appendage.

    Attributes:
        inertia: about the axis, kg·m².
        axis_B: unit vector.
        stiffness: N·m/rad.
        damping: N·m·s/rad.
    """

    inertia: float
    axis_B: Vector3
    stiffness: float
    damping: float

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        disc = self.inertia / 2.0 * (np.eye(3) + np.outer(self.axis_B, self.axis_B))
        bus = spec.body("bus")
        bus.mass -= _DISC_MASS
        _change_bus(spec, -disc, name)
        body = bus.add_body(name=name, ipos=np.zeros(3), mass=_DISC_MASS, fullinertia=_six(disc))
        body.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=self.axis_B,
            stiffness=[self.stiffness, 0.0, 0.0],
            damping=[self.damping, 0.0, 0.0],
        )


@final
@dataclass(frozen=True, kw_only=True)
class SprungMass(Addition):
    """A point mass that a spring and damper hold to the rest of the platform in every direction.

    Attributes:
        reduced_mass: m (M - m)/M of a mass m in a platform of M, kg.
        arm_B: from the centre of mass of the rest to the mass at rest, shape (3,), m.
        stiffness: N/m.
        damping: N·s/m.
    """

    reduced_mass: float
    arm_B: Vector3
    stiffness: float
    damping: float

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        bus, total = spec.body("bus"), _total_mass(spec)
        mass = total / 2.0 * (1.0 - np.sqrt(1.0 - 4.0 * self.reduced_mass / total))
        place_B = self.arm_B * (1.0 - mass / total)
        bus.mass -= mass
        bus.ipos = -mass / bus.mass * place_B  # the common centre of mass stays at the bus frame's origin
        _change_bus(spec, -_about_origin(mass, place_B) - _about_origin(bus.mass, bus.ipos), name)
        body = bus.add_body(name=name, pos=place_B, ipos=np.zeros(3), mass=mass, inertia=[_POINT_INERTIA] * 3)
        for axis in range(3):
            body.add_joint(
                name=f"{name}_{'xyz'[axis]}",
                type=mujoco.mjtJoint.mjJNT_SLIDE,
                axis=np.eye(3)[axis],
                stiffness=[self.stiffness, 0.0, 0.0],
                damping=[self.damping, 0.0, 0.0],
            )


def _about_origin(mass: float, place: Vector3) -> Matrix3:
    return np.asarray(mass * (place @ place * np.eye(3) - np.outer(place, place)))


def _total_mass(spec: mujoco.MjSpec) -> float:
    model = spec.compile()
    return float(model.body_subtreemass[model.body("bus").id])


def _change_bus(spec: mujoco.MjSpec, change: Matrix3, name: str) -> None:
    """Add to the inertia of the bus body about its own centre of mass, kg·m², body axes.

    Raises:
        InputError: nothing that a body can have remains.
    """
    bus, model = spec.body("bus"), spec.compile()
    turned = np.empty(9)
    mujoco.mju_quat2Mat(turned, model.body("bus").iquat)
    axes = turned.reshape(3, 3)
    inertia = axes * model.body("bus").inertia @ axes.T + change
    moments = np.linalg.eigvalsh(inertia)
    if bus.mass <= 0.0 or moments[0] <= 0.0 or moments[0] + moments[1] < moments[2]:
        raise InputError(
            f"{name}: leaves the bus {bus.mass:.4g} kg and principal moments of {moments} kg m2, which no body has; "
            "the effect's size does not belong to this platform"
        )
    bus.inertia, bus.iquat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])  # MuJoCo takes one form of inertia only
    bus.fullinertia = _six(inertia)


def _six(inertia: Matrix3) -> list[float]:
    return [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
