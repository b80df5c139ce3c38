"""Platforms drawn with little: rings as a few straight pieces, a body as a box."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np

from testbed.arrays import Array, Matrix3, Quaternion, Vector3
from testbed.palette import Color
from testbed.rotation.quaternion import quaternion_product, turned
from testbed.scene import SceneBody, Shape, shade_of

_PIECES = 24
"""Of a ring. A mesh takes 110 kB, in every run again; these take 3 kB."""
_LONGEST = 0.09
"""m; half edge of the box of a body, as of the shipped platform's cube."""
_THINNEST = 0.1
"""Of the longest edge."""
_AXIS_RADIUS = 0.0018
_ROTOR = "_rotor"
_BY_ITS_EDGES = 0.4
"""Opacity of a box below `testbed.recording.shapes.SEE_THROUGH`."""
_STILL = np.array([1.0, 0.0, 0.0, 0.0])


def lean_scene(scene: Sequence[SceneBody]) -> tuple[SceneBody, ...]:
    """Return a scene with rings of straight pieces, its rotors at rest in their gimbals and a part of them.

    Args:
        scene: bodies of a platform with control moment gyros, parents before children.
    """
    rotors = {body.parent: body for body in scene if body.name.endswith(_ROTOR)}
    bodies = (body for body in scene if not body.name.endswith(_ROTOR))
    return tuple(replace(body, shapes=(*_in_pieces(body.shapes), *_in_parent(rotors, body.name))) for body in bodies)


def frame_of(body: SceneBody, color: Color) -> SceneBody:
    """Return a body as its frame in one colour: bars, the edges of boxes, and its axes in their own."""
    red, green, blue = (channel / 255 for channel in color)
    shapes = (
        shape if shade_of(shape) is not None else replace(shape, color=(red, green, blue, _BY_ITS_EDGES))
        for shape in body.shapes
        if shape.kind in {"box", "capsule"}
    )
    return replace(body, shapes=tuple(shapes))


def box_scene(inertia: Matrix3) -> tuple[SceneBody, ...]:
    """Return the box that has the moments of inertia of a body, in proportion, with its axes.

    Args:
        inertia: kg·m²; of a box of half edges a, b, c, J11 is proportional to b² + c².
    """
    moments = np.diag(inertia)
    squares = np.maximum(0.5 * moments.sum() - moments, 0.0)
    edges = np.sqrt(squares / squares.max())
    half = _LONGEST * np.maximum(edges, _THINNEST)
    box = _shape("body", "box", half, np.zeros(3), _STILL, (0.42, 0.45, 0.50, 1.0))
    axes = tuple(_axis(name, unit, float(half @ unit)) for name, unit in zip("xyz", np.eye(3), strict=True))
    return (
        SceneBody(name="bus", parent="", position=np.zeros(3), quaternion=_STILL, hinge_axis=None, shapes=(box, *axes)),
    )


def _axis(name: str, unit: Vector3, start: float) -> Shape:
    half_length = 0.25 * _LONGEST
    size = np.array([_AXIS_RADIUS, half_length])
    place = (start + half_length) * unit
    return _shape(f"axis_{name}", "capsule", size, place, _from_z(unit), (1.0, 1.0, 1.0, 1.0))


def _in_pieces(shapes: Sequence[Shape]) -> Iterator[Shape]:
    for shape in shapes:
        yield from _pieces(shape) if shape.kind == "mesh" else (shape,)


def _in_parent(rotors: Mapping[str, SceneBody], gimbal: str) -> Iterator[Shape]:
    """Yield the shapes of the rotor in a gimbal, at joint angle zero, in the gimbal's frame; of another body none."""
    if gimbal not in rotors:
        return
    rotor = rotors[gimbal]
    for shape in rotor.shapes:
        yield replace(
            shape,
            position=rotor.position + turned(rotor.quaternion, shape.position),
            quaternion=quaternion_product(rotor.quaternion, shape.quaternion),
        )


def _pieces(ring: Shape) -> tuple[Shape, ...]:
    """Return capsules along the middle of a ring, as thick as its vertices say; all have the ring's name."""
    center = ring.vertices.mean(axis=0)
    normal = np.linalg.eigh(np.cov((ring.vertices - center).T))[1]  # the smallest extent first
    across = (ring.vertices - center) @ normal[:, 1:]
    reach = np.hypot(*across.T)
    radius, thickness = 0.5 * (reach.max() + reach.min()), 0.5 * (reach.max() - reach.min())
    angle = 2.0 * np.pi * np.arange(_PIECES + 1) / _PIECES
    corners = center + radius * np.column_stack([np.cos(angle), np.sin(angle)]) @ normal[:, 1:].T
    corners = ring.position + turned(ring.quaternion, corners)
    return tuple(_piece(ring, *ends, thickness) for ends in pairwise(corners))


def _piece(ring: Shape, start: Vector3, end: Vector3, thickness: float) -> Shape:
    length = float(np.linalg.norm(end - start))
    size = np.array([thickness, 0.5 * length])
    return _shape(ring.name, "capsule", size, 0.5 * (start + end), _from_z((end - start) / length), ring.color)


def _from_z(direction: Vector3) -> Quaternion:
    """Return the quaternion that turns z into a direction or, which is the same for a capsule, into its opposite."""
    upward = direction if direction[2] >= 0.0 else -direction
    half_way = np.array([1.0 + upward[2], -upward[1], upward[0], 0.0])
    return np.asarray(half_way / np.linalg.norm(half_way))


def _shape(
    name: str,
    kind: Literal["box", "capsule"],
    size: Array,
    position: Vector3,
    quaternion: Quaternion,
    color: tuple[float, float, float, float],
) -> Shape:
    nothing = np.empty((0, 3))
    return Shape(
        name=name,
        kind=kind,
        size=size,
        position=position,
        quaternion=quaternion,
        color=color,
        vertices=nothing,
        faces=nothing,
    )
