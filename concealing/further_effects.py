"""Effects that random sets do not draw, so that a seed makes the set that it always made; they are asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from concealing.craft import SIGN_WIDTH, Craft
from concealing.effect import (
    ACTUATORS,
    GYRO,
    PLATFORM,
    EffectKind,
    Parameters,
    named_vector,
    names,
    sign,
    vector,
    vector_units,
)
from concealing.platform_effects import with_torque

_BOTH = ("cmg", "applied_torque")


def dry_friction(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """T = -τ sign(ω), each axis its own; the sign is rounded over 0.01 rad/s."""
    torque = vector(parameters, "torque")
    return with_torque(craft, lambda motion: -torque * np.tanh(motion.body_rate / SIGN_WIDTH))


def telemetry_skew(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """Every actuator channel shows at t what was so at t - s; on board nothing is late."""
    return replace(craft, telemetry_late=parameters["late"])


def gyro_averaging(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """The mean over a share of the gyro's sample period, at most all of it."""
    return replace(craft, gyro=replace(craft.gyro, averaging=min(parameters["share_of_period"], 1.0)))


def gyro_clock_drift(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """What is stamped t was read at t - d t; on board every reading is used when it is taken."""
    return replace(craft, gyro=replace(craft.gyro, clock_drift=parameters["drift"]))


KINDS = {
    "dry_friction": EffectKind(
        components=(PLATFORM,),
        units=vector_units("torque", "N m"),
        apply=dry_friction,
        draw=lambda rng: named_vector("torque", 5e-5 * rng.uniform(0.5, 1.5, 3)),
        growing=names("torque"),
        actuation=_BOTH,
    ),
    "telemetry_skew": EffectKind(
        components=(ACTUATORS,),
        units={"late": "s"},
        apply=telemetry_skew,
        draw=lambda rng: {"late": 0.01 * sign(rng)},
        growing=("late",),
        actuation=_BOTH,
    ),
    "gyro_clock_drift": EffectKind(
        components=(GYRO,),
        units={"drift": "1"},
        apply=gyro_clock_drift,
        draw=lambda rng: {"drift": 2e-4 * sign(rng)},
        growing=("drift",),
        actuation=_BOTH,
    ),
    "gyro_averaging": EffectKind(
        components=(GYRO,),
        units={"share_of_period": "1"},
        apply=gyro_averaging,
        draw=lambda _: {"share_of_period": 1.0},
        growing=("share_of_period",),
        actuation=_BOTH,
    ),
}
"""By id."""
