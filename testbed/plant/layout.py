"""Where the platform's quantities stand in MuJoCo's state vectors, and a state in words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np

from testbed.arrays import Array
from testbed.plant.geometry import unit_count, unit_names, wheel_count, wheel_names


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Where the platform's quantities stand in MuJoCo's state vectors.

    Attributes:
        gimbal_angle: indices into qpos, shape (M,).
        rotor_angle: indices into qpos, shape (M,).
        gimbal_rate: indices into qvel, shape (M,).
        rotor_speed: indices into qvel, shape (M,).
        gimbal_motor: indices into ctrl, shape (M,).
        rotor_motor: indices into ctrl, shape (M,).
        wheel_angle: indices into qpos, shape (W,), of reaction wheels.
        wheel_speed: indices into qvel, shape (W,).
        wheel_motor: indices into ctrl, shape (W,).
        position: slice of qpos with the bus position in N; empty on an air bearing.
        attitude: slice of qpos with quat_NB.
        velocity: slice of qvel with the bus velocity in N; empty on an air bearing.
        body_rate: slice of qvel with the body rate, body axes.
    """

    gimbal_angle: Array
    rotor_angle: Array
    gimbal_rate: Array
    rotor_speed: Array
    gimbal_motor: Array
    rotor_motor: Array
    wheel_angle: Array
    wheel_speed: Array
    wheel_motor: Array
    position: slice
    attitude: slice
    velocity: slice
    body_rate: slice


@lru_cache(maxsize=4)  # each record of a campaign asks for that of the same model
def layout_of(model: mujoco.MjModel) -> Layout:
    """Look up by name where each quantity stands, so that further joints in an extended model do no harm."""
    units = unit_count(model)
    gimbals = [model.joint(name) for name in unit_names("gimbal", units)]
    rotors = [model.joint(name) for name in unit_names("rotor", units)]
    wheels = [model.joint(name) for name in wheel_names("rotor", wheel_count(model))]
    bus = model.joint("bus")
    qpos, qvel = int(bus.qposadr[0]), int(bus.dofadr[0])
    places = 3 if model.jnt_type[bus.id] == mujoco.mjtJoint.mjJNT_FREE else 0  # a ball joint has none
    return Layout(
        gimbal_angle=_indices(joint.qposadr[0] for joint in gimbals),
        rotor_angle=_indices(joint.qposadr[0] for joint in rotors),
        gimbal_rate=_indices(joint.dofadr[0] for joint in gimbals),
        rotor_speed=_indices(joint.dofadr[0] for joint in rotors),
        gimbal_motor=_indices(model.actuator(name).id for name in unit_names("gimbal_motor", units)),
        rotor_motor=_indices(model.actuator(name).id for name in unit_names("rotor_motor", units)),
        wheel_angle=_indices(joint.qposadr[0] for joint in wheels),
        wheel_speed=_indices(joint.dofadr[0] for joint in wheels),
        wheel_motor=_indices(model.actuator(name).id for name in wheel_names("motor", len(wheels))),
        position=slice(qpos, qpos + places),
        attitude=slice(qpos + places, qpos + places + 4),
        velocity=slice(qvel, qvel + places),
        body_rate=slice(qvel + places, qvel + places + 3),
    )


def _indices(found: Iterable[int]) -> Array:
    return np.array(list(found), dtype=np.intp)


def described_state(layout: Layout, qpos: Array, qvel: Array) -> str:
    """Return a state in one line for a person: the platform's quantities by name, with their units.

    Args:
        layout: of the model.
        qpos: shape (nq,).
        qvel: shape (nv,).
    """
    quantities = {
        "position": (qpos[layout.position], "m"),
        "attitude quat_NB": (qpos[layout.attitude], ""),
        "gimbal angles": (qpos[layout.gimbal_angle], "rad"),
        "body rate": (qvel[layout.body_rate], "rad/s"),
        "gimbal rates": (qvel[layout.gimbal_rate], "rad/s"),
        "rotor speeds": (qvel[layout.rotor_speed], "rad/s"),
        "wheel speeds": (qvel[layout.wheel_speed], "rad/s"),
    }
    return ", ".join(
        f"{name} [{', '.join(f'{value:.4g}' for value in values)}] {unit}".rstrip()
        for name, (values, unit) in quantities.items()
        if len(values)
    )
