"""The named parts that any MJCF needs to serve as the platform."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import mujoco

from testbed.errors import InputError
from testbed.plant.geometry import unit_names

_NEEDED = {
    "body": ("bus", *unit_names("gimbal"), *unit_names("rotor")),
    "freejoint": ("bus",),
    "hinge": (*unit_names("gimbal"), *unit_names("rotor")),
    "frame": unit_names("mount"),
    "actuator": (*unit_names("gimbal_motor"), *unit_names("rotor_motor")),
    "geom": ("hull",),
}
"""Names by kind of part, as an MJCF spells the kinds."""


def require_parts(spec: mujoco.MjSpec, path: Path) -> None:
    """Refuse a model that lacks parts, before one of them is looked for.

    Args:
        spec: the model as read.
        path: its file, for the message.

    Raises:
        InputError: with all parts that are missing, or of another kind.
    """
    missing = list(_missing(_names_in(spec)))
    if missing:
        raise InputError(
            f"{path}: needs {'; '.join(missing)}; name the parts as models/platform.xml does, "
            "which attaches cmg.xml with the prefixes cmg1_ to cmg6_"
        )


def _names_in(spec: mujoco.MjSpec) -> Mapping[str, set[str]]:
    return {
        "body": {body.name for body in spec.bodies},
        "freejoint": _joints(spec, mujoco.mjtJoint.mjJNT_FREE),
        "hinge": _joints(spec, mujoco.mjtJoint.mjJNT_HINGE),
        "frame": {frame.name for frame in spec.frames},
        "actuator": {actuator.name for actuator in spec.actuators},
        "geom": {geom.name for geom in spec.geoms},
    }


def _joints(spec: mujoco.MjSpec, kind: mujoco.mjtJoint) -> set[str]:
    return {joint.name for joint in spec.joints if joint.type == kind}


def _missing(present: Mapping[str, set[str]]) -> Iterator[str]:
    for kind, names in _NEEDED.items():
        absent = [name for name in names if name not in present[kind]]
        if absent:
            yield f"the {kind} {', '.join(absent)}"
