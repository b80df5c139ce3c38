"""Triangles of the shapes of a scene, in the frame of their body."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Vectors3
from testbed.rotation.quaternion import turned
from testbed.scene import Shape

_SIDES = 32
"""Of a cylinder."""


def triangles_of(shape: Shape) -> tuple[Vectors3, Array]:
    """Return corners, shape (V, 3), m, and triangles, shape (F, 3); a capsule is drawn as a cylinder."""
    match shape.kind:
        case "box":
            corners, faces = _box(shape.size)
        case "cylinder" | "capsule":
            corners, faces = _cylinder(*shape.size)
        case "mesh":
            corners, faces = shape.vertices, shape.faces
    return shape.position + turned(shape.quaternion, corners), faces


def _box(half_size: Array) -> tuple[Vectors3, Array]:
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]) * half_size
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return corners, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _cylinder(radius: float, half_length: float) -> tuple[Vectors3, Array]:
    """Return two rings and the two centres of a cylinder along z."""
    angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(_SIDES, half_length)])
    corners = np.vstack([ring, ring * [1.0, 1.0, -1.0], [[0.0, 0.0, half_length], [0.0, 0.0, -half_length]]])
    here, after = np.arange(_SIDES), (np.arange(_SIDES) + 1) % _SIDES
    top, bottom = np.full(_SIDES, 2 * _SIDES), np.full(_SIDES, 2 * _SIDES + 1)
    faces = [
        [here, after, here + _SIDES],
        [after, after + _SIDES, here + _SIDES],
        [top, here, after],
        [bottom, after + _SIDES, here + _SIDES],
    ]
    return corners, np.vstack([np.column_stack(face) for face in faces])
