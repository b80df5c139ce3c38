"""The compiled platform as a picture: its bodies, how they are hinged, and the shapes to draw on them."""

from __future__ import annotations

from typing import Literal

import mujoco
import numpy as np

from testbed.arrays import Array, Vector3
from testbed.scene import SceneBody, Shape

HIDDEN_GROUP = 3
"""Geoms of this group only collide; MuJoCo's own viewer hides them too."""

_KINDS: dict[int, Literal["box", "cylinder", "capsule", "mesh"]] = {
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}
_SIZES = {"box": slice(0, 3), "cylinder": slice(0, 2), "capsule": slice(0, 2), "mesh": slice(0, 0)}
_DEFAULT_COLOR = np.array([0.5, 0.5, 0.5, 1.0], dtype=np.float32)


def scene_of(model: mujoco.MjModel) -> tuple[SceneBody, ...]:
    """Return the bodies of a compiled model, parents before children.

    The world comes first if anything is fixed to it, such as the walls of a cabin. Planes, ellipsoids and other kinds
    of geom than `testbed.scene.Shape` knows are not drawn.
    """
    bodies = tuple(_body(model, body) for body in range(model.nbody))
    return bodies if bodies[0].shapes else bodies[1:]


def _body(model: mujoco.MjModel, body: int) -> SceneBody:
    first, count = model.body_geomadr[body], model.body_geomnum[body]
    return SceneBody(
        name=model.body(body).name,
        parent=_parent(model, body),
        position=model.body_pos[body].copy(),
        quaternion=model.body_quat[body].copy(),
        hinge_axis=_hinge_axis(model, body),
        shapes=tuple(_shape(model, geom) for geom in range(first, first + count) if _drawn(model, geom)),
    )


def _parent(model: mujoco.MjModel, body: int) -> str:
    """Return the parent's name; empty for what stands or floats in N."""
    parent = int(model.body_parentid[body])
    return str(model.body(parent).name) if parent else ""


def _hinge_axis(model: mujoco.MjModel, body: int) -> Vector3 | None:
    if model.body_jntnum[body] == 0:
        return None
    joint = model.body_jntadr[body]
    hinged = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
    return np.array(model.jnt_axis[joint]) if hinged else None


def _drawn(model: mujoco.MjModel, geom: int) -> bool:
    return int(model.geom_type[geom]) in _KINDS and model.geom_group[geom] != HIDDEN_GROUP


def _shape(model: mujoco.MjModel, geom: int) -> Shape:
    kind = _KINDS[int(model.geom_type[geom])]
    vertices, faces = _mesh(model, int(model.geom_dataid[geom])) if kind == "mesh" else (np.empty((0, 3)),) * 2
    return Shape(
        name=model.geom(geom).name,
        kind=kind,
        size=model.geom_size[geom, _SIZES[kind]].copy(),
        position=model.geom_pos[geom].copy(),
        quaternion=model.geom_quat[geom].copy(),
        color=_color(model, geom),
        vertices=vertices,
        faces=faces,
    )


def _mesh(model: mujoco.MjModel, mesh: int) -> tuple[Array, Array]:
    vertex, face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
    vertices = model.mesh_vert[vertex : vertex + model.mesh_vertnum[mesh]]
    faces = model.mesh_face[face : face + model.mesh_facenum[mesh]]
    return vertices.astype(np.float64), faces.astype(np.float64)


def _color(model: mujoco.MjModel, geom: int) -> tuple[float, float, float, float]:
    """Return what MuJoCo draws: a geom's own colour where it has one, its material's otherwise."""
    own, material = model.geom_rgba[geom], model.geom_matid[geom]
    rgba = model.mat_rgba[material] if material >= 0 and np.array_equal(own, _DEFAULT_COLOR) else own
    red, green, blue, alpha = (float(value) for value in rgba)
    return red, green, blue, alpha
