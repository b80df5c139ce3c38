"""The shapes on a body, written once: one entity for all of a kind, one for each mesh."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from testbed.arrays import Array, Quaternions, Vectors3
from testbed.rotation.quaternion import turned
from testbed.scene import Shape

SEE_THROUGH = 0.5
"""A box of less opacity is drawn by its edges, so that one sees what is inside."""

_OUTLINE_DIMMING = 0.45


def log_shapes(stream: rr.RecordingStream, path: str, shapes: Sequence[Shape]) -> None:
    """Write the shapes of the body at `path`, for all times."""
    for shape in shapes:
        if shape.kind == "mesh":
            stream.log(f"{path}/{shape.name}", _mesh(shape), static=True)
    for name, drawing in _DRAWINGS.items():
        batch = [shape for shape in shapes if _drawing_of(shape) == name]
        if batch:
            stream.log(f"{path}/{name}", drawing(batch), static=True)


def _drawing_of(shape: Shape) -> str:
    if shape.kind == "box":
        return "outlines" if shape.color[3] < SEE_THROUGH else "boxes"
    return f"{shape.kind}s"


def _boxes(shapes: Sequence[Shape]) -> rr.Boxes3D:
    return rr.Boxes3D(
        half_sizes=_sizes(shapes),
        centers=_positions(shapes),
        quaternions=xyzw(_quaternions(shapes)),
        colors=_colors(shapes),
        fill_mode=rr.components.FillMode.Solid,
    )


def _outlines(shapes: Sequence[Shape]) -> rr.Boxes3D:
    return rr.Boxes3D(
        half_sizes=_sizes(shapes),
        centers=_positions(shapes),
        quaternions=xyzw(_quaternions(shapes)),
        colors=_OUTLINE_DIMMING * _colors(shapes)[:, :3],
        fill_mode=rr.components.FillMode.MajorWireframe,
    )


def _cylinders(shapes: Sequence[Shape]) -> rr.Cylinders3D:
    radius, half_length = _sizes(shapes).T
    return rr.Cylinders3D(
        radii=radius,
        lengths=2.0 * half_length,
        centers=_positions(shapes),
        quaternions=xyzw(_quaternions(shapes)),
        colors=_colors(shapes),
        fill_mode=rr.components.FillMode.Solid,
    )


def _capsules(shapes: Sequence[Shape]) -> rr.Capsules3D:
    """A capsule of the scene is centred on its origin, one of rerun begins there."""
    radius, half_length = _sizes(shapes).T
    quaternion = _quaternions(shapes)
    return rr.Capsules3D(
        radii=radius,
        lengths=2.0 * half_length,
        translations=_positions(shapes) - turned(quaternion, half_length[:, None] * np.array([0.0, 0.0, 1.0])),
        quaternions=xyzw(quaternion),
        colors=_colors(shapes),
        fill_mode=rr.components.FillMode.Solid,
    )


_DRAWINGS: dict[str, Callable[[Sequence[Shape]], rr.AsComponents]] = {
    "boxes": _boxes,
    "outlines": _outlines,
    "cylinders": _cylinders,
    "capsules": _capsules,
}


def _mesh(shape: Shape) -> rr.Mesh3D:
    vertices = shape.position + turned(shape.quaternion, shape.vertices)
    faces = shape.faces.astype(np.intp)
    return rr.Mesh3D(
        vertex_positions=vertices,
        triangle_indices=faces,
        vertex_normals=_vertex_normals(vertices, faces),
        albedo_factor=shape.color,
    )


def _vertex_normals(vertices: Vectors3, faces: NDArray[np.intp]) -> Vectors3:
    """Return the area-weighted mean of the normals of the faces around each vertex, shape (V, 3), unit."""
    first, second, third = (vertices[faces[:, corner]] for corner in range(3))
    normals = np.zeros_like(vertices)
    np.add.at(normals, faces, np.cross(second - first, third - first)[:, None])
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def xyzw(quaternion: Quaternions) -> Quaternions:
    """Return scalar-first quaternions in rerun's order, scalar last; shape (..., 4)."""
    return np.roll(quaternion, -1, axis=-1)


def _sizes(shapes: Sequence[Shape]) -> Array:
    return np.array([shape.size for shape in shapes])


def _positions(shapes: Sequence[Shape]) -> Vectors3:
    return np.array([shape.position for shape in shapes])


def _quaternions(shapes: Sequence[Shape]) -> Quaternions:
    return np.array([shape.quaternion for shape in shapes])


def _colors(shapes: Sequence[Shape]) -> Array:
    return np.array([shape.color for shape in shapes])
