"""A craft as an MJCF: the shipped platform with what is true of it written in by hand, and compiled by MuJoCo.

Nothing here is shared with the effects of the testbed, which write the same physics into the same file another way.
"""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from concealing.craft import Array, Craft, Units, nominal_craft
from concealing.guidance import Software
from concealing.inner_effects import HingedMode, LooseMass, point_inertia
from testbed.assembly.platform import nominal_properties
from testbed.plant.build import shipped_model, specification

_SPECK = 1e-9
"""kg, or kg·m²: what MuJoCo wants of a body that has none."""
_THICK = 1e-6
"""By which a disc is no flat one: MuJoCo refuses a body whose A + B falls short of C by rounding."""


def compiled(craft: Craft, known: Software) -> mujoco.MjModel:
    """Return a craft's MuJoCo model; its drag, fields, cables and blows are applied by whoever flies it.

    Args:
        craft: as it is.
        known: the nominal platform's numbers.

    Raises:
        ValueError: something of the craft that no MJCF element stands for.
    """
    _require_representable(craft)
    inner = [_loose_part(attachment) for attachment in craft.attachments]
    inertia = craft.inertia - sum((part for part, _ in inner), np.zeros((3, 3)))
    mass = craft.mass - sum(weight for _, weight in inner)
    scenario = known.scenario
    spec = specification(
        replace(nominal_properties(scenario), inertia=inertia, mass=mass), scenario.platform.model or shipped_model()
    )
    for index, attachment in enumerate(craft.attachments):
        _attach(spec.body("bus"), f"loose{index}", attachment, craft.mass)
    _write_units(spec, craft, nominal_craft(known.platform).units)
    return spec.compile()


def _require_representable(craft: Craft) -> None:
    units = craft.units
    inside = (units.lag, units.stribeck, units.static_imbalance, units.dynamic_imbalance, craft.encoders.backlash)
    loose = all(isinstance(each, HingedMode | LooseMass) for each in craft.attachments)
    if not len(units.spin_inertia) or any(np.any(each) for each in inside) or not loose:
        raise ValueError("no MJCF element stands for an effect of this case: fly it by the equations of motion")


def _whole_mass(reduced: float, total: float) -> float:
    """Return m of μ = m (1 - m/M)."""
    return total / 2.0 * (1.0 - np.sqrt(1.0 - 4.0 * reduced / total))


def _loose_part(attachment: HingedMode | LooseMass) -> tuple[Array, float]:
    """Return what of the platform's inertia about its centre of mass, and of its mass, is an attachment's."""
    if isinstance(attachment, HingedMode):
        return _disc(attachment), _SPECK
    return point_inertia(attachment.mass, attachment.place), attachment.mass


def _disc(mode: HingedMode) -> Array:
    """Return a round body's inertia, the mode's about its axis, half as much across, and a hair more."""
    across, along = 1.0 + _THICK, 1.0 - _THICK
    return 0.5 * mode.inertia * (across * np.eye(3) + along * np.outer(mode.axis, mode.axis))


def _attach(bus: mujoco.MjsBody, name: str, attachment: HingedMode | LooseMass, total: float) -> None:
    if isinstance(attachment, HingedMode):
        disc = _disc(attachment)
        six = [*np.diag(disc), disc[0, 1], disc[0, 2], disc[1, 2]]
        body = bus.add_body(name=name, ipos=np.zeros(3), mass=_SPECK, fullinertia=six)
        joints, kind = {name: attachment.axis}, mujoco.mjtJoint.mjJNT_HINGE
    else:
        mass = _whole_mass(attachment.mass, total)
        body = bus.add_body(name=name, pos=attachment.place, ipos=np.zeros(3), mass=mass, inertia=[_SPECK] * 3)
        joints, kind = (
            dict(zip((f"{name}_{axis}" for axis in "xyz"), np.eye(3), strict=True)),
            mujoco.mjtJoint.mjJNT_SLIDE,
        )
    for joint, axis in joints.items():
        body.add_joint(
            name=joint, type=kind, axis=axis, stiffness=[attachment.stiffness, 0, 0], damping=[attachment.damping, 0, 0]
        )


def _write_units(spec: mujoco.MjSpec, craft: Craft, nominal: Units) -> None:
    """Turn the units in their mounts, and write friction and the speeds that the rotors' servos hold."""
    units = craft.units
    turns = np.einsum("mij,mik->mjk", _frames(nominal), _frames(units))
    for index, turn in enumerate(turns):
        unit = f"cmg{index + 1}"
        joint, servo = spec.joint(f"{unit}_gimbal"), spec.actuator(f"{unit}_rotor_motor")
        joint.damping = [units.viscous[index], 0.0, 0.0]
        joint.frictionloss = units.coulomb[index]
        servo.gainprm[0] = -servo.gainprm[2] * units.rotor_speed[index]
        quat = np.empty(4)
        mujoco.mju_mat2Quat(quat, turn.ravel())
        spec.body(f"{unit}_gimbal").quat = quat


def _frames(units: Units) -> Array:
    """Return spin, transverse and gimbal axes as columns, (M, 3, 3)."""
    return np.stack([units.spin_axis, units.transverse_axis, units.gimbal_axis], axis=-1)
