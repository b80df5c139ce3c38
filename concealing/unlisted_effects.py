"""Effects that no library lists: the right answer to them is "unknown"."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from concealing.craft import Array, Craft, Impulse, Motion
from concealing.effect import (
    PLATFORM,
    EffectKind,
    Parameters,
    direction,
    named_vector,
    names,
    sign,
    vector,
    vector_units,
)
from concealing.inner_effects import DrivenMass, with_attachment
from concealing.platform_effects import with_torque

_BOTH = ("cmg", "applied_torque")
_LONGEST_RUN = 20.0


def sine_torque(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T sin(2π f t + φ) in body axes, on a clock that runs on between runs."""
    torque, rate = vector(parameters, "torque"), 2.0 * np.pi * parameters["frequency"]

    def shaken(motion: Motion) -> Array:
        return np.sin(rate * (motion.epoch + motion.time) + parameters["phase"])[:, None] * torque

    return with_torque(craft, shaken)


def impact_train(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """Equal blows at equal intervals."""
    times = np.arange(parameters["first"], _LONGEST_RUN, parameters["interval"])
    impulse = vector(parameters, "impulse")
    blows = tuple(Impulse(time=float(time), momentum=impulse) for time in times)
    return replace(craft, impulses=(*craft.impulses, *blows))


def rate_product_torque(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T_x = a ω_y ω_z and cyclically: three coefficients that are no inertia (their sum does not vanish)."""
    coefficient = vector(parameters, "coefficient")

    def product(motion: Motion) -> Array:
        rate = motion.body_rate
        return coefficient * np.roll(rate, -1, axis=1) * np.roll(rate, -2, axis=1)

    return with_torque(craft, product)


def ramp_torque(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T grows in proportion to the time since release, in body axes."""
    slope = vector(parameters, "slope")
    return with_torque(craft, lambda motion: np.broadcast_to(slope * motion.time, motion.body_rate.shape))


def moving_mass(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A mass that swings to and fro along a line through a place in the body."""
    place, line = vector(parameters, "place"), vector(parameters, "stroke")
    rate, phase = 2.0 * np.pi * parameters["frequency"], parameters["phase"]
    mass = DrivenMass(
        mass=parameters["mass"] * (1.0 - parameters["mass"] / craft.mass),
        path=lambda time: place + line * np.sin(rate * time + phase),
        velocity=lambda time: line * rate * np.cos(rate * time + phase),
        fastest=rate,
    )
    return with_attachment(craft, mass)


def _phase(rng: np.random.Generator) -> float:
    return float(rng.uniform(0.0, 2.0 * np.pi))


def _across(rng: np.random.Generator, line: Array, length: float) -> Array:
    """Return a vector normal to a line, so that a motion along it has momentum."""
    drawn = np.cross(line, direction(rng))
    return length * drawn / np.linalg.norm(drawn)


def _moving_mass(rng: np.random.Generator) -> Parameters:
    line = direction(rng)
    return {
        "mass": 0.05,
        "frequency": float(rng.uniform(0.2, 0.8)),
        "phase": _phase(rng),
        **named_vector("place", _across(rng, line, 0.06)),
        **named_vector("stroke", 0.03 * line),
    }


KINDS = {
    "sine_torque": EffectKind(
        components=(PLATFORM,),
        units={**vector_units("torque", "N m"), "frequency": "Hz", "phase": "rad"},
        apply=sine_torque,
        draw=lambda rng: {
            **named_vector("torque", 3e-4 * direction(rng)),
            "frequency": float(rng.uniform(0.8, 4.0)),
            "phase": _phase(rng),
        },
        growing=names("torque"),
        actuation=_BOTH,
    ),
    "impact_train": EffectKind(
        components=(PLATFORM,),
        units={**vector_units("impulse", "N m s"), "first": "s", "interval": "s"},
        apply=impact_train,
        draw=lambda rng: {
            **named_vector("impulse", 1e-4 * direction(rng)),
            "first": float(rng.uniform(0.1, 0.6)),
            "interval": float(rng.uniform(0.4, 1.2)),
        },
        growing=names("impulse"),
        actuation=_BOTH,
    ),
    "rate_product_torque": EffectKind(
        components=(PLATFORM,),
        units=vector_units("coefficient", "N m s2/rad2"),
        apply=rate_product_torque,
        draw=lambda rng: named_vector("coefficient", 2e-3 * sign(rng) * rng.uniform(0.5, 1.5, 3)),
        growing=names("coefficient"),
        actuation=_BOTH,
    ),
    "ramp_torque": EffectKind(
        components=(PLATFORM,),
        units=vector_units("slope", "N m/s"),
        apply=ramp_torque,
        draw=lambda rng: named_vector("slope", 2e-5 * direction(rng)),
        growing=names("slope"),
        actuation=_BOTH,
    ),
    "moving_mass": EffectKind(
        components=(PLATFORM,),
        units={
            "mass": "kg",
            "frequency": "Hz",
            "phase": "rad",
            **vector_units("place", "m"),
            **vector_units("stroke", "m"),
        },
        apply=moving_mass,
        draw=_moving_mass,
        growing=("mass",),
        actuation=_BOTH,
    ),
}
"""By id."""
