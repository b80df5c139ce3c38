"""Effects on the platform as a whole: its inertia, external torques, a blow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from concealing.craft import Array, Craft, Impulse, Motion, Torque
from concealing.effect import (
    PLATFORM,
    EffectKind,
    Parameters,
    direction,
    named_vector,
    names,
    vector,
    vector_units,
)

_ENTRIES = {"dJ11": (0, 0), "dJ22": (1, 1), "dJ33": (2, 2), "dJ23": (1, 2), "dJ13": (0, 2), "dJ12": (0, 1)}
_BOTH = ("cmg", "applied_torque")


def inertia(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """J → J + dJ."""
    change = np.zeros((3, 3))
    for name, (row, column) in _ENTRIES.items():
        change[row, column] = change[column, row] = parameters[name]
    return replace(craft, inertia=craft.inertia + change)


def viscous_drag(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T = -c ω, each axis its own."""
    drag = vector(parameters, "coefficient")
    return with_torque(craft, lambda motion: -drag * motion.body_rate)


def quadratic_drag(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T = -k ω |ω|, each axis its own."""
    drag = vector(parameters, "coefficient")
    return with_torque(craft, lambda motion: -drag * motion.body_rate * np.abs(motion.body_rate))


def body_torque(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T constant in body axes."""
    torque = vector(parameters, "torque")
    return with_torque(craft, lambda motion: np.broadcast_to(torque, motion.body_rate.shape))


def inertial_torque(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T = Rᵀ T_N, constant in inertial axes."""
    torque_N = vector(parameters, "torque")
    return with_torque(craft, lambda motion: torque_N @ motion.attitude)


def tether(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T = -K θ - C ω, θ the rotation vector since release."""

    def torque(motion: Motion) -> Array:
        turned = np.swapaxes(motion.release_attitude, -1, -2) @ motion.attitude
        angle = Rotation.from_matrix(turned).as_rotvec()
        return -parameters["stiffness"] * angle - parameters["damping"] * motion.body_rate

    return with_torque(craft, torque)


def contact(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A blow at one time, in one run (the last where the data set has fewer)."""
    impulse = Impulse(time=parameters["time"], momentum=vector(parameters, "impulse"), run=int(parameters["run"]))
    return replace(craft, impulses=(*craft.impulses, impulse))


def with_torque(craft: Craft, torque: Torque) -> Craft:
    """Return the craft with one more external torque on it."""
    return replace(craft, torques=(*craft.torques, torque))


def _positive(rng: np.random.Generator, stem: str, size: float) -> Parameters:
    return named_vector(stem, size * rng.uniform(0.5, 1.5, 3))


def _entries(rng: np.random.Generator) -> Parameters:
    diagonal, off_diagonal = 1e-3 * rng.uniform(-1.0, 1.0, 3), 5e-4 * rng.uniform(-1.0, 1.0, 3)
    return dict(zip(_ENTRIES, map(float, (*diagonal, *off_diagonal)), strict=True))


def _directed(rng: np.random.Generator, stem: str, size: float) -> Parameters:
    return named_vector(stem, size * direction(rng))


KINDS = {
    "inertia": EffectKind(
        components=(PLATFORM,),
        units=dict.fromkeys(_ENTRIES, "kg m2"),
        apply=inertia,
        draw=_entries,
        growing=tuple(_ENTRIES),
        actuation=_BOTH,
    ),
    "viscous_drag": EffectKind(
        components=(PLATFORM,),
        units=vector_units("coefficient", "N m s/rad"),
        apply=viscous_drag,
        draw=lambda rng: _positive(rng, "coefficient", 2e-4),
        growing=names("coefficient"),
        actuation=_BOTH,
    ),
    "quadratic_drag": EffectKind(
        components=(PLATFORM,),
        units=vector_units("coefficient", "N m s2/rad2"),
        apply=quadratic_drag,
        draw=lambda rng: _positive(rng, "coefficient", 8e-4),
        growing=names("coefficient"),
        actuation=_BOTH,
    ),
    "body_torque": EffectKind(
        components=(PLATFORM,),
        units=vector_units("torque", "N m"),
        apply=body_torque,
        draw=lambda rng: _directed(rng, "torque", 3e-5),
        growing=names("torque"),
        actuation=_BOTH,
    ),
    "inertial_torque": EffectKind(
        components=(PLATFORM,),
        units=vector_units("torque", "N m"),
        apply=inertial_torque,
        draw=lambda rng: _directed(rng, "torque", 3e-5),
        growing=names("torque"),
        actuation=_BOTH,
    ),
    "tether": EffectKind(
        components=(PLATFORM,),
        units={"stiffness": "N m/rad", "damping": "N m s/rad"},
        apply=tether,
        draw=lambda rng: {"stiffness": 3e-4 * rng.uniform(0.5, 1.5), "damping": 5e-5 * rng.uniform(0.5, 1.5)},
        growing=("stiffness", "damping"),
        actuation=_BOTH,
    ),
    "contact": EffectKind(
        components=(PLATFORM,),
        units={"time": "s", **vector_units("impulse", "N m s"), "run": "1"},
        apply=contact,
        draw=lambda rng: {
            "time": float(rng.uniform(0.5, 1.5)),
            **_directed(rng, "impulse", 2e-4),
            "run": float(rng.integers(0, 6)),
        },
        growing=names("impulse"),
        actuation=_BOTH,
    ),
}
"""By id."""
