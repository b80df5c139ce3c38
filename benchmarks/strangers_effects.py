"""What can be hidden in what Basilisk flies: each effect is a number of the engine's modules, or a module more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.strangers_craft import Craft, Panel, Tank, flyable_delay, panel_mode
from concealing.effect import AXES, PLATFORM, EffectKind, HiddenEffect, Parameters, named_vector, vector
from concealing.wheel_effects import FLYING, OF_WHEELS

_TANK = 0.25
"""m, from the centre of the satellite to the resting place of the liquid."""


def _body_torque(craft: Craft, _: str, parameters: Parameters) -> Craft:
    return replace(craft, torque=craft.torque + vector(parameters, "torque"))


def _gyro_bias(craft: Craft, _: str, parameters: Parameters) -> Craft:
    return replace(craft, gyro=replace(craft.gyro, bias=craft.gyro.bias + vector(parameters, "bias")))


def _gyro_scale(craft: Craft, component: str, parameters: Parameters) -> Craft:
    scale = craft.gyro.scale + parameters["scale_factor_error"] * (np.array(AXES) == component)
    return replace(craft, gyro=replace(craft.gyro, scale=scale))


def _gyro_misalignment(craft: Craft, _: str, parameters: Parameters) -> Craft:
    turn = np.array([parameters[name] for name in ("yz", "xz", "xy")])
    return replace(craft, gyro=replace(craft.gyro, turn=turn))


def _gyro_latency(craft: Craft, _: str, parameters: Parameters) -> Craft:
    return replace(craft, gyro=replace(craft.gyro, late=flyable_delay(parameters["delay"])))


def _gravity_gradient(craft: Craft, _: str, parameters: Parameters) -> Craft:
    return replace(craft, gradient_error=parameters["relative_error"])


def _hinged_panel(craft: Craft, _: str, parameters: Parameters) -> Craft:
    along, tilt = parameters["azimuth"], parameters["hinge_tilt"]
    outward = np.array([np.cos(along), np.sin(along), 0.0])
    level = np.array([-np.sin(along), np.cos(along), 0.0])
    panel = Panel(
        mass=parameters["mass"],
        outward=outward,
        hinge_axis=np.cos(tilt) * level + np.sin(tilt) * np.array([0.0, 0.0, 1.0]),
        frequency=parameters["frequency"],
        damping_ratio=parameters["damping_ratio"],
    )
    return replace(craft, panel=panel)


def _slosh(craft: Craft, _: str, parameters: Parameters) -> Craft:
    tank = Tank(
        mass=parameters["mass"],
        place=vector(parameters, "place"),
        frequency=parameters["frequency"],
        damping_ratio=parameters["damping_ratio"],
    )
    return replace(craft, tank=tank)


def _drawn_panel(rng: np.random.Generator) -> Parameters:
    return {
        "mass": 1.0,
        "azimuth": 0.5 * np.pi * float(rng.integers(4)),
        "hinge_tilt": float(rng.uniform(-0.5, 0.5) * np.pi),
        "frequency": float(rng.uniform(0.4, 2.0)),
        "damping_ratio": float(rng.uniform(0.005, 0.05)),
    }


def _drawn_tank(rng: np.random.Generator) -> Parameters:
    drawn = rng.standard_normal(3)
    moves = {"frequency": float(rng.uniform(0.4, 1.2)), "damping_ratio": float(rng.uniform(0.05, 0.2))}
    return {"mass": 1.0, **moves, **named_vector("place", _TANK * drawn / np.linalg.norm(drawn))}


_ALONE = (
    *("wheel_inertia", "wheel_misalignment", "wheel_viscous_friction", "wheel_coulomb_friction"),
    *("wheel_torque_scale", "wheel_imbalance"),
)
BESIDE_PARTS: dict[str, EffectKind] = {
    **{name: OF_WHEELS[name] for name in _ALONE},
    "body_torque": replace(FLYING["body_torque"], apply=_body_torque),
    "gyro_bias": replace(FLYING["gyro_bias"], apply=_gyro_bias),
    "gyro_scale": replace(FLYING["gyro_scale"], apply=_gyro_scale),
    "gyro_misalignment": replace(FLYING["gyro_misalignment"], apply=_gyro_misalignment, components=("gyro",)),
    "gyro_latency": replace(FLYING["gyro_latency"], apply=_gyro_latency),
}
"""What can be hidden in any satellite, by id."""
WITH_PARTS: dict[str, EffectKind] = BESIDE_PARTS | {
    "flexible_appendage": EffectKind(
        components=(PLATFORM,),
        units={"frequency": "Hz", "damping_ratio": "1", "inertia": "kg m2", **{f"axis_{axis}": "1" for axis in AXES}},
        apply=_hinged_panel,
        draw=_drawn_panel,
        growing=("mass",),
    ),
    "slosh": EffectKind(
        components=(PLATFORM,),
        units={"frequency": "Hz", "damping_ratio": "1", "mass": "kg"},
        apply=_slosh,
        draw=_drawn_tank,
        growing=("mass",),
    ),
    "gravity_gradient": EffectKind(
        components=(PLATFORM,),
        units={"relative_error": "1"},
        apply=_gravity_gradient,
        draw=lambda _: {"relative_error": -0.3},  # orbits below the one believed end at the ground
        growing=("relative_error",),
    ),
}
"""What can be hidden in one on orbit that is large enough for parts and for the gravity gradient, by id."""


def answered(craft: Craft, hidden: HiddenEffect) -> HiddenEffect:
    """Return a hidden effect in the parameters that effects of its id have (docs/effects.md).

    Args:
        craft: with it.
        hidden: in the parameters of the module.
    """
    if hidden.effect == "flexible_appendage":
        assert craft.panel is not None
        inertia, axis = panel_mode(craft.panel, craft.mass)[1:]
        shown = {"frequency": craft.panel.frequency, "damping_ratio": craft.panel.damping_ratio, "inertia": inertia}
        return replace(hidden, parameters=shown | named_vector("axis", axis))
    if hidden.effect == "gyro_latency":
        return replace(hidden, parameters={"delay": craft.gyro.late})
    if hidden.effect == "slosh":
        kept = ("frequency", "damping_ratio", "mass")
        return replace(hidden, parameters={name: hidden.parameters[name] for name in kept})
    return hidden
