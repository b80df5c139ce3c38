"""The 3-D platform: a tree of entities with the poses of its bodies, the shapes on them, and arrows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from string import ascii_lowercase, digits

import numpy as np
import rerun as rr

from testbed.arrays import Array, Quaternions, Series, Vector3, Vectors3
from testbed.palette import SHADES, Color
from testbed.recording.palette import BODY_RATE_COLOR, CLUSTER_MOMENTUM_COLOR, TOTAL_MOMENTUM_COLOR
from testbed.recording.shapes import log_shapes, xyzw
from testbed.recording.stream import send
from testbed.rotation.quaternion import exponential, quaternion_product, turned
from testbed.scene import SceneBody, Shape, shade_of
from testbed.signals import KINDS

ROOT = "platform"
"""Entity of the bus; gimbals and rotors hang below it as they do in the MJCF."""

ARROW_LENGTH = 0.16
"""m. The longest arrow reaches well out of the cube."""
_BEYOND = 1.08
"""Of the distance of what is named: how far out its name stands."""


def entity_paths(scene: Sequence[SceneBody]) -> dict[str, str]:
    """Return the entity of each body: `cmg3_rotor` on `cmg3_gimbal` on the bus is platform/cmg3/gimbal/rotor.

    What is fixed in N and is not the bus, such as a cabin, is logged outside the platform under its own name.
    """
    paths: dict[str, str] = {}
    for body in scene:
        words, above = body.name.split("_"), body.parent.split("_")
        own = words[1:] if words[0] == above[0] else words
        paths[body.name] = "/".join((paths[body.parent], *own)) if body.parent else _root(body)
    return paths


def _root(body: SceneBody) -> str:
    return ROOT if body.name == "bus" else body.name


def log_platform(
    stream: rr.RecordingStream, scene: Sequence[SceneBody], time: Series, channels: Mapping[str, Array], under: str = ""
) -> None:
    """Write shapes, poses and arrows.

    Args:
        stream: the recording.
        scene: bodies, parents before children.
        time: shape (N,), s.
        channels: of the flight; a joint whose angle it lacks stays at zero, a platform without attitude at rest.
        under: what all paths begin with; of several platforms each has its own.
    """
    paths = {name: f"{under}{path}" for name, path in entity_paths(scene).items()}
    for body in scene:
        log_shapes(stream, paths[body.name], _painted(body))
        _log_names(stream, paths[body.name], body)
        log_pose(stream, paths[body.name], body, time, channels)
    _log_arrows(stream, time, channels)


def _painted(body: SceneBody) -> tuple[Shape, ...]:
    """Give each gimbal's ring and each axis the colour that its lines have in the plots."""
    return tuple(map(_in_its_color, body.shapes))


def _log_names(stream: rr.RecordingStream, path: str, body: SceneBody) -> None:
    """Write the number of a unit on the rim of its ring, where the gimbal's axis leaves it, and the names of axes."""
    named = {shade: shape for shape in reversed(body.shapes) if (shade := shade_of(shape)) is not None}
    if not named:
        return
    drawn = rr.Points3D(
        [_far_end(body, shape) for shape in named.values()],
        radii=0.0,
        colors=[SHADES[shade].dark_rgb for shade in named],
        labels=[shade.partition("-")[2] for shade in named],
        show_labels=True,
    )
    stream.log(f"{path}/names", drawn, static=True)


def _far_end(body: SceneBody, shape: Shape) -> Vector3:
    """Return a point outside of a ring on its hinge's axis, or beyond the tip of a capsule, in the body's frame."""
    if shape.kind == "mesh" and body.hinge_axis is not None:
        vertices = shape.position + turned(shape.quaternion, shape.vertices)
        return np.asarray(_BEYOND * float((vertices @ body.hinge_axis).max()) * body.hinge_axis)
    tip = shape.position + turned(shape.quaternion, np.array([0.0, 0.0, float(shape.size[-1])]))
    return np.asarray(_BEYOND * tip)


def _in_its_color(shape: Shape) -> Shape:
    shade = shade_of(shape)
    if shade is None:
        return shape
    red, green, blue = (channel / 255 for channel in SHADES[shade].dark_rgb)
    return replace(shape, color=(red, green, blue, 1.0))


def _unit_index(body: SceneBody) -> int:
    return int(body.name.partition("_")[0].lstrip(ascii_lowercase)) - 1


def log_pose(
    stream: rr.RecordingStream, path: str, body: SceneBody, time: Series, channels: Mapping[str, Array]
) -> None:
    """Write the pose of a body in its parent."""
    translation, quaternion = body_pose(body, channels)
    if len(quaternion) == 1:
        stream.log(path, rr.Transform3D(translation=translation[0], quaternion=xyzw(quaternion)[0]), static=True)
        return
    send(
        stream,
        path,
        time,
        lambda rows: rr.Transform3D.columns(translation=translation[rows], quaternion=xyzw(quaternion[rows])),
    )


def body_pose(body: SceneBody, channels: Mapping[str, Array]) -> tuple[Vectors3, Quaternions]:
    """Return the pose of a body in its parent, or of the bus in N, one row per sample; one row if it does not move.

    Args:
        body: of the scene.
        channels: by signal name.

    Returns:
        Position, shape (N, 3), m, and quaternion from the body to its parent, shape (N, 4), scalar first.
    """
    if body.name == "bus" and "true_attitude" in channels:
        attitude = channels["true_attitude"]
        return channels.get("true_position", np.zeros((len(attitude), 3))), attitude
    angle = _hinge_angle(body, channels)
    if body.hinge_axis is None or angle is None:
        return body.position[None], body.quaternion[None]
    turn = exponential(angle[:, None] * body.hinge_axis)
    return np.tile(body.position, (len(angle), 1)), quaternion_product(
        np.broadcast_to(body.quaternion, turn.shape), turn
    )


def _hinge_angle(body: SceneBody, channels: Mapping[str, Array]) -> Series | None:
    """Return the angle of `cmg3_gimbal` from the third column of `true_gimbal_angle`; None where it is not known."""
    owner, _, part = body.name.partition("_")
    moving = part if owner.startswith(KINDS["unit"].prefix) else owner.rstrip(digits)
    angle = channels.get(f"true_{moving}_angle")
    return None if angle is None else angle[:, _unit_index(body)]


def _log_arrows(stream: rr.RecordingStream, time: Series, channels: Mapping[str, Array]) -> None:
    """Draw body rate and momenta, the momenta to one scale; what stays below a thousandth of it has no arrow."""
    momentum = max(_longest(channels, "true_cluster_momentum"), _longest(channels, "true_total_momentum"))
    for path, name, label, color, full in (
        (f"{ROOT}/body_rate", "true_body_rate", "ω", BODY_RATE_COLOR, _longest(channels, "true_body_rate")),
        (f"{ROOT}/cluster_momentum", "true_cluster_momentum", "h", CLUSTER_MOMENTUM_COLOR, momentum),
        ("total_momentum", "true_total_momentum", "H", TOTAL_MOMENTUM_COLOR, momentum),
    ):
        if _longest(channels, name) > 1e-3 * full:
            _log_arrow(stream, path, time, channels[name] * (ARROW_LENGTH / full), label, color)


def _longest(channels: Mapping[str, Array], name: str) -> float:
    """Return the largest norm of a vector signal; 0 where the flight lacks it."""
    return float(np.linalg.norm(channels[name], axis=1).max()) if name in channels else 0.0


def _log_arrow(
    stream: rr.RecordingStream, path: str, time: Series, vectors: Vectors3, label: str, color: Color
) -> None:
    stream.log(path, rr.Arrows3D.from_fields(colors=color, radii=0.0018, labels=label, show_labels=True), static=True)
    send(stream, path, time, lambda rows: rr.Arrows3D.columns(vectors=vectors[rows]))
