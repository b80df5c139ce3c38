"""Effects of something that moves inside the platform: they exchange momentum with it and keep the sum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from concealing.craft import Array, Craft, cross
from concealing.effect import (
    PLATFORM,
    EffectKind,
    Parameters,
    direction,
    named_vector,
    vector,
    vector_units,
)


@dataclass(frozen=True, kw_only=True)
class HingedMode:
    """A panel on a hinge: T = ½ Ia (q̇ + a·ω)² - ½ k q², with π = Ia (q̇ + a·ω) and q as states.

    Attributes:
        axis: a, (3,), unit vector, body axes.
        inertia: Ia about it, kg·m²; part of the platform's inertia.
        stiffness: N·m/rad.
        damping: N·m·s/rad.
    """

    axis: Array
    inertia: float
    stiffness: float
    damping: float
    width: int = 2

    @property
    def fastest(self) -> float:
        return float(np.sqrt(self.stiffness / self.inertia) + self.damping / self.inertia)

    def start(self, body_rate: Array) -> Array:
        return np.stack([self.inertia * (body_rate @ self.axis), np.zeros(len(body_rate))], axis=1)

    def released_inertia(self, time: float, epoch: Array) -> Array:  # noqa: ARG002 - the role's signature
        return self.inertia * np.outer(self.axis, self.axis)

    def momentum(self, time: float, epoch: Array, state: Array) -> Array:  # noqa: ARG002 - the role's signature
        return state[:, :1] * self.axis

    def derivative(self, time: float, state: Array, body_rate: Array) -> Array:  # noqa: ARG002 - the role's signature
        momentum, angle = state.T
        rate = momentum / self.inertia - body_rate @ self.axis
        return np.stack([-self.stiffness * angle - self.damping * rate, rate], axis=1)


@dataclass(frozen=True, kw_only=True)
class LooseMass:
    """A mass on a spring and a damper: T = ½ μ |ẋ + ω × (r + x)|², with P = μ (ẋ + ω × (r + x)) and x as states.

    Attributes:
        place: r, (3,), m, from the centre of mass of the rest.
        mass: reduced mass μ of it and the rest, kg.
        stiffness: N/m.
        damping: N·s/m.
    """

    place: Array
    mass: float
    stiffness: float
    damping: float
    width: int = 6

    @property
    def fastest(self) -> float:
        return float(np.sqrt(self.stiffness / self.mass) + self.damping / self.mass)

    def start(self, body_rate: Array) -> Array:
        momentum = self.mass * cross(body_rate, self.place)
        return np.concatenate([momentum, np.zeros_like(momentum)], axis=1)

    def released_inertia(self, time: float, epoch: Array) -> Array:  # noqa: ARG002 - the role's signature
        return point_inertia(self.mass, self.place)

    def momentum(self, time: float, epoch: Array, state: Array) -> Array:  # noqa: ARG002 - the role's signature
        return cross(self.place + state[:, 3:], state[:, :3])

    def derivative(self, time: float, state: Array, body_rate: Array) -> Array:  # noqa: ARG002 - the role's signature
        momentum, shift = state[:, :3], state[:, 3:]
        rate = momentum / self.mass - cross(body_rate, self.place + shift)
        force = -self.stiffness * shift - self.damping * rate
        return np.concatenate([force - cross(body_rate, momentum), rate], axis=1)


@dataclass(frozen=True, kw_only=True)
class DrivenMass:
    """A mass on a prescribed path r(t), which starts where it counts in the platform's inertia.

    Attributes:
        mass: reduced mass of it and the rest, kg.
        path: place at a time since release, (3,), m.
        velocity: its derivative, m/s.
        fastest: rate of the path, 1/s.
    """

    mass: float
    path: Callable[[float], Array]
    velocity: Callable[[float], Array]
    fastest: float
    width: int = 0

    def start(self, body_rate: Array) -> Array:
        return np.zeros((len(body_rate), 0))

    def released_inertia(self, time: float, epoch: Array) -> Array:  # noqa: ARG002 - the role's signature
        return point_inertia(self.mass, self.path(0.0)) - point_inertia(self.mass, self.path(time))

    def momentum(self, time: float, epoch: Array, state: Array) -> Array:  # noqa: ARG002 - the role's signature
        return np.broadcast_to(self.mass * cross(self.path(time), self.velocity(time)), (len(state), 3))

    def derivative(self, time: float, state: Array, body_rate: Array) -> Array:  # noqa: ARG002 - the role's signature
        return np.zeros_like(state)


def point_inertia(mass: float, place: Array) -> Array:
    """Return m (r² 1 - r rᵀ), kg·m²."""
    return mass * (place @ place * np.eye(3) - np.outer(place, place))


def flexible_appendage(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A hinged mode; its frequency is that with the platform held."""
    axis, moment = vector(parameters, "axis"), parameters["inertia"]
    rate = 2.0 * np.pi * parameters["frequency"]
    if moment == 0.0:
        return craft
    mode = HingedMode(
        axis=axis / np.linalg.norm(axis),
        inertia=moment,
        stiffness=moment * rate**2,
        damping=2.0 * parameters["damping_ratio"] * rate * moment,
    )
    return with_attachment(craft, mode)


def slosh(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A loose mass; its frequency is that with the platform held."""
    if parameters["mass"] == 0.0:
        return craft
    mass = parameters["mass"] * (1.0 - parameters["mass"] / craft.mass)
    rate = 2.0 * np.pi * parameters["frequency"]
    loose = LooseMass(
        place=vector(parameters, "place"),
        mass=mass,
        stiffness=mass * rate**2,
        damping=2.0 * parameters["damping_ratio"] * rate * mass,
    )
    return with_attachment(craft, loose)


def with_attachment(craft: Craft, attachment: HingedMode | LooseMass | DrivenMass) -> Craft:
    """Return the craft with one more thing that moves inside it."""
    return replace(craft, attachments=(*craft.attachments, attachment))


KINDS = {
    "flexible_appendage": EffectKind(
        components=(PLATFORM,),
        units={"frequency": "Hz", "damping_ratio": "1", "inertia": "kg m2", **vector_units("axis", "1")},
        apply=flexible_appendage,
        draw=lambda rng: {
            "frequency": float(rng.uniform(0.8, 4.0)),
            "damping_ratio": float(rng.uniform(0.005, 0.05)),
            "inertia": 5e-4,
            **named_vector("axis", direction(rng)),
        },
        growing=("inertia",),
        actuation=("cmg", "applied_torque"),
    ),
    "slosh": EffectKind(
        components=(PLATFORM,),
        units={"mass": "kg", "frequency": "Hz", "damping_ratio": "1", **vector_units("place", "m")},
        apply=slosh,
        draw=lambda rng: {
            "mass": 0.1,
            "frequency": float(rng.uniform(0.3, 1.5)),
            "damping_ratio": float(rng.uniform(0.05, 0.3)),
            **named_vector("place", 0.06 * direction(rng)),
        },
        growing=("mass",),
        actuation=("cmg", "applied_torque"),
    ),
}
"""By id."""
