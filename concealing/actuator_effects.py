"""Effects in actuators that store no momentum."""

from __future__ import annotations

from dataclasses import replace

from concealing.craft import Craft
from concealing.effect import ACTUATORS, EffectKind, Parameters

_APPLIED = ("applied_torque",)


def actuator_lag(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A first-order lag of the applied torque."""
    return replace(craft, applied=replace(craft.applied, lag=parameters["time_constant"]))


def actuator_delay(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A delay of the applied torque."""
    return replace(craft, applied=replace(craft.applied, delay=parameters["delay"]))


KINDS = {
    "actuator_lag": EffectKind(
        components=(ACTUATORS,),
        units={"time_constant": "s"},
        apply=actuator_lag,
        draw=lambda _: {"time_constant": 0.05},
        growing=("time_constant",),
        actuation=_APPLIED,
    ),
    "actuator_delay": EffectKind(
        components=(ACTUATORS,),
        units={"delay": "s"},
        apply=actuator_delay,
        draw=lambda _: {"delay": 0.03},
        growing=("delay",),
        actuation=_APPLIED,
    ),
}
"""By id."""
