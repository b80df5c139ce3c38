"""Torques by a law of the motion, drawn at random: products of rates, drag, attitude, clock and waves, along any axis.

The laws are written down here once more, as exponents and indices; nothing of the testbed's grammar is used.
"""

from __future__ import annotations

import numpy as np

from concealing.craft import Array, Craft, Motion
from concealing.effect import (
    AXES,
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
from concealing.platform_effects import with_torque

LAWS = ("clock", "wave", "rate", "drag", "two_rates", "three_rates", "attitude")
"""Of which one is drawn, each as often as the others."""
PLACES = (*AXES, "B", "N")
"""Where a torque points: a body axis, or any direction fixed in the body or in space; likewise."""
_TYPICAL = 2e-4
"""N m, before the size is searched."""


def formula_torque(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T = k |ω|^n ω_x^a ω_y^b ω_z^c t^m A_ij sin(2π f t + φ), what is not drawn left out; k fixed in B or in N."""
    size, powers = vector(parameters, "coefficient"), vector(parameters, "power")
    entry, rate = int(parameters["entry"]), 2.0 * np.pi * parameters["frequency"]

    def torque(motion: Motion) -> Array:
        turned = np.swapaxes(motion.release_attitude, -1, -2) @ motion.attitude
        value = np.prod(motion.body_rate**powers, axis=1) * motion.time ** parameters["clock"]
        value = value * np.linalg.norm(motion.body_rate, axis=1) ** parameters["length"]
        if entry:
            value = value * turned[:, (entry - 1) // 3, (entry - 1) % 3]
        if rate:
            value = value * np.sin(rate * motion.time + parameters["phase"])
        along = np.einsum("i,bij->bj", size, turned) if parameters["in_space"] else size
        return value[:, None] * along

    return with_torque(craft, torque)


def drawn_law(rng: np.random.Generator, law: str | None = None, place: str | None = None) -> Parameters:
    """Draw a law that no effect of a library has: of drag by one rate, not about the axis of that rate."""
    law = str(rng.choice(LAWS)) if law is None else law
    place = str(rng.choice(PLACES)) if place is None else place
    powers, entry, clock, length, frequency = np.zeros(3), 0, 0, 0, 0.0
    if law in ("rate", "drag"):
        powers[int(rng.choice([axis for axis in range(3) if AXES[axis] != place or law == "drag"]))] = 1
        length = int(law == "drag")
    elif law in ("two_rates", "three_rates"):
        for axis in rng.integers(3, size=2 if law == "two_rates" else 3):
            powers[axis] += 1
    elif law == "attitude":
        entry = int(rng.integers(1, 10))
    elif law == "clock":
        clock = 1
    else:
        frequency = float(rng.uniform(0.6, 3.5))
    along = np.eye(3)[AXES.index(place)] * sign(rng) if place in AXES else direction(rng)
    return {
        **named_vector("coefficient", _TYPICAL * along),
        **named_vector("power", powers),
        "in_space": float(place == "N"),
        "entry": float(entry),
        "clock": float(clock),
        "length": float(length),
        "frequency": frequency,
        "phase": float(rng.uniform(0.0, 2.0 * np.pi)),
    }


KINDS = {
    "formula_torque": EffectKind(
        components=(PLATFORM,),
        units={
            **vector_units("coefficient", "SI"),
            **vector_units("power", "1"),
            **dict.fromkeys(("in_space", "entry", "clock", "length"), "1"),
            "frequency": "Hz",
            "phase": "rad",
        },
        apply=formula_torque,
        draw=drawn_law,
        growing=names("coefficient"),
        actuation=("cmg", "applied_torque"),
    )
}
"""By id."""
