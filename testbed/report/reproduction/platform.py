"""Figure 4: a photograph in the paper, here the platform as it is simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Quaternion, Vector3
from testbed.plant.plant import Model
from testbed.plant.scene import scene_of
from testbed.report.frame.blocks import Figure, Section
from testbed.report.frame.style import color
from testbed.report.reproduction.solids import triangles_of
from testbed.rotation.quaternion import quaternion_product, turned
from testbed.scene import SceneBody, Shape, shade_of

_SEE_THROUGH = 0.5
"""Opacity below which a shape is drawn so that one sees what is inside."""
_HIDDEN = {"visible": False}

Pose = tuple[Vector3, Quaternion]


def platform_section(model: Model) -> Section:
    """Return the picture of the platform, gimbals at zero."""
    chart = go.Figure(layout=_layout())
    bodies = [body for body in scene_of(model) if body.name == "bus" or body.parent]
    for body, pose in zip(bodies, _poses(bodies), strict=True):
        for shape in body.shapes:
            chart.add_trace(_mesh(shape, pose))
    note = (
        "The paper's figure 4 is a photograph of SCRAT-0g. This is the MuJoCo model that flies here: a bus and six "
        "control moment gyros, gimbal rings in the units' colours. It can be turned."
    )
    figure = Figure(title="Figure 4: the platform", chart=chart, note=note, wide=True)
    return Section(title="Figure 4", blocks=(figure,))


def _poses(bodies: Sequence[SceneBody]) -> list[Pose]:
    """Return position and quaternion of every body in the bus, all joints at zero."""
    poses: dict[str, Pose] = {"bus": (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))}
    for body in bodies:
        if body.name != "bus":
            position, quaternion = poses[body.parent]
            poses[body.name] = (
                position + turned(quaternion, body.position),
                quaternion_product(quaternion, body.quaternion),
            )
    return [poses[body.name] for body in bodies]


def _mesh(shape: Shape, pose: Pose) -> go.Mesh3d:
    corners, faces = triangles_of(shape)
    x, y, z = np.round(pose[0] + turned(pose[1], corners), 5).T
    i, j, k = faces.astype(np.int32).T
    red, green, blue, alpha = shape.color
    shade = shade_of(shape)
    return go.Mesh3d(
        x=x,
        y=y,
        z=z,
        i=i,
        j=j,
        k=k,
        color=f"rgb({255 * red:.0f},{255 * green:.0f},{255 * blue:.0f})" if shade is None else color(shade),
        opacity=0.12 if alpha < _SEE_THROUGH else 1.0,
        flatshading=True,
        hoverinfo="skip",
    )


def _layout() -> go.Layout:
    axes: Mapping[str, object] = dict.fromkeys(("xaxis", "yaxis", "zaxis"), _HIDDEN)
    eye = {"x": 1.7, "y": -1.0, "z": 0.9}
    return go.Layout(
        template=None,
        paper_bgcolor="rgba(0,0,0,0)",
        margin={"l": 0, "r": 0, "t": 0, "b": 0},
        scene={**axes, "aspectmode": "data", "camera": {"eye": eye}},
        showlegend=False,
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": color("faint"), "activecolor": color("ink")},
        uirevision="kept",
    )
