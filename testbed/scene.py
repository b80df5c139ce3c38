"""The platform as a picture: shapes on bodies, as plain data between the simulator and the viewer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from testbed.arrays import Array, Quaternion, Vector3
from testbed.palette import AXIS_SHADES, UNIT_SHADES


@dataclass(frozen=True, kw_only=True)
class Shape:
    """One visible shape, fixed to a body.

    Attributes:
        name: unique in the scene.
        kind: what `size` means: box half sizes (3,); cylinder and capsule (radius, half length) along local z;
            mesh: unused.
        size: metres.
        position: of the shape's frame in its body's frame, m.
        quaternion: from the shape's frame to its body's frame, scalar first.
        color: RGBA, 0 to 1.
        vertices: mesh vertices, shape (V, 3), m; empty for the other kinds.
        faces: mesh triangles, shape (F, 3), vertex indices; empty likewise.
    """

    name: str
    kind: Literal["box", "cylinder", "capsule", "mesh"]
    size: Array
    position: Vector3
    quaternion: Quaternion
    color: tuple[float, float, float, float]
    vertices: Array
    faces: Array


@dataclass(frozen=True, kw_only=True)
class SceneBody:
    """One moving body of the scene.

    Attributes:
        name: MJCF name, such as `cmg3_gimbal`.
        parent: name of the body it is mounted on; empty for the bus, whose pose is given in N.
        position: of the body frame in its parent at joint angle zero, m.
        quaternion: from the body frame to its parent at joint angle zero, scalar first.
        hinge_axis: axis of its hinge in its own frame; None for the free-floating bus.
        shapes: what is drawn on it.
    """

    name: str
    parent: str
    position: Vector3
    quaternion: Quaternion
    hinge_axis: Vector3 | None
    shapes: tuple[Shape, ...]


def shade_of(shape: Shape) -> str | None:
    """Return the name in the palette of a shape that has a colour in the charts too: a unit's ring, a body axis."""
    shade = shape.name.removesuffix("_ring").replace("cmg", "unit-").replace("_", "-")
    return shade if shade in (*AXIS_SHADES, *UNIT_SHADES) else None
