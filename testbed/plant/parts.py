"""The named parts that any MJCF needs to serve as the platform."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import mujoco

from testbed.errors import InputError
from testbed.plant.geometry import unit_names


def require_parts(spec: mujoco.MjSpec, path: Path, units: int) -> None:
    """Refuse a model that lacks parts, before one of them is looked for.

    Args:
        spec: the model as read.
        path: its file, for the message.
        units: how many control moment gyros it should have.

    Raises:
        InputError: with all parts that are missing, or of another kind.
    """
    missing = list(_missing(_names_in(spec), units))
    if missing:
        raise InputError(
            f"{path}: needs {'; '.join(missing)}; name the parts as models/platform.xml does, "
            f"which attaches cmg.xml with the prefixes cmg1_ to cmg{units}_"
        )


def _names_in(spec: mujoco.MjSpec) -> Mapping[str, set[str]]:
    return {
        "body": {body.name for body in spec.bodies},
        "free or ball joint": _joints(spec, mujoco.mjtJoint.mjJNT_FREE) | _joints(spec, mujoco.mjtJoint.mjJNT_BALL),
        "hinge": _joints(spec, mujoco.mjtJoint.mjJNT_HINGE),
        "frame": {frame.name for frame in spec.frames},
        "actuator": {actuator.name for actuator in spec.actuators},
        "geom": {geom.name for geom in spec.geoms},
    }


def _joints(spec: mujoco.MjSpec, kind: mujoco.mjtJoint) -> set[str]:
    return {joint.name for joint in spec.joints if joint.type == kind}


def _needed(units: int) -> Mapping[str, tuple[str, ...]]:
    """Return names by kind of part, as an MJCF spells the kinds."""
    gimbals, rotors = unit_names("gimbal", units), unit_names("rotor", units)
    return {
        "body": ("bus", *gimbals, *rotors),
        "free or ball joint": ("bus",),
        "hinge": (*gimbals, *rotors),
        "frame": unit_names("mount", units),
        "actuator": (*unit_names("gimbal_motor", units), *unit_names("rotor_motor", units)),
        "geom": ("hull",),
    }


def _missing(present: Mapping[str, set[str]], units: int) -> Iterator[str]:
    for kind, names in _needed(units).items():
        absent = [name for name in names if name not in present[kind]]
        if absent:
            yield f"the {kind} {', '.join(absent)}"
