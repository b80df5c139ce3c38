"""Effects in one CMG unit, or in all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from concealing.craft import Array, Craft
from concealing.effect import CLUSTER, CMGS, EffectKind, Parameters, sign, unit_index

_TILTS = ("about_spin_axis", "about_transverse_axis")


def rotor_speed(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """h → (1 + e) h: the speed servo trusts a tachometer that shows the nominal speed at 1 + e times it."""
    factor = _changed(np.ones(len(CMGS)), component, parameters["relative_error"])
    return replace(
        craft,
        units=replace(craft.units, rotor_speed=craft.units.rotor_speed * factor),
        tachometer_scale=craft.tachometer_scale * factor,
    )


def rotor_spin_down(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """h decays as exp(-k t) from release on: the speed servo trusts a tachometer that drifts, and shows no decay."""
    return _with_units(craft, component, spin_down=parameters["decay"])


def gimbal_zero(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """The encoder shows the angle plus an offset."""
    zero = _changed(craft.encoders.zero, component, parameters["zero"])
    return replace(craft, encoders=replace(craft.encoders, zero=zero))


def gimbal_misalignment(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """The unit is turned by a about its spin axis at zero, then by b about the transverse axis that this has made."""
    index, units = unit_index(component), craft.units
    spin, gimbal = units.spin_axis.copy(), units.gimbal_axis.copy()
    first = Rotation.from_rotvec(parameters["about_spin_axis"] * spin[index])
    transverse = first.apply(np.cross(gimbal[index], spin[index]))
    turn = Rotation.from_rotvec(parameters["about_transverse_axis"] * transverse) * first
    spin[index], gimbal[index] = turn.apply(spin[index]), turn.apply(gimbal[index])
    return replace(craft, units=replace(units, spin_axis=spin, gimbal_axis=gimbal))


def gimbal_lag(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """The motor follows its torque demand as a first-order lag; the tachometer loop inside it does not."""
    return _with_units(craft, component, lag=parameters["time_constant"])


def gimbal_viscous_friction(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """-c ḋ at the joint."""
    return _with_units(craft, component, viscous=parameters["coefficient"])


def gimbal_coulomb_friction(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """-(τ_c + τ_s exp(-(ḋ / v_s)²)) sign(ḋ), the sign rounded over 0.01 rad/s."""
    return _with_units(
        craft,
        component,
        coulomb=parameters["torque"],
        stribeck=parameters["stribeck_torque"],
        stribeck_rate=parameters["stribeck_rate"] - craft.units.stribeck_rate[0],
    )


def gimbal_backlash(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """A dead zone between encoder and axis; the encoder leads by half of it in the direction of motion."""
    backlash = _changed(craft.encoders.backlash, component, parameters["dead_zone"])
    return replace(craft, encoders=replace(craft.encoders, backlash=backlash))


def rotor_imbalance(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """A centre of mass off the spin axis (force), and a principal axis not along it (torque)."""
    return _with_units(
        craft,
        component,
        static_imbalance=parameters["static"],
        dynamic_imbalance=parameters["dynamic"],
        imbalance_phase=parameters["phase"],
    )


def _changed(values: Array, component: str, by: float) -> Array:
    changed = values.copy()
    changed[unit_index(component)] += by
    return changed


def _with_units(craft: Craft, component: str, **added: float) -> Craft:
    units = craft.units
    return replace(
        craft,
        units=replace(units, **{name: _changed(getattr(units, name), component, by) for name, by in added.items()}),
    )


KINDS = {
    "rotor_speed": EffectKind(
        components=CMGS,
        units={"relative_error": "1"},
        apply=rotor_speed,
        draw=lambda rng: {"relative_error": 0.02 * sign(rng)},
        growing=("relative_error",),
    ),
    "rotor_spin_down": EffectKind(
        components=CMGS,
        units={"decay": "1/s"},
        apply=rotor_spin_down,
        draw=lambda _: {"decay": 0.02},
        growing=("decay",),
    ),
    "gimbal_zero": EffectKind(
        components=CMGS,
        units={"zero": "rad"},
        apply=gimbal_zero,
        draw=lambda rng: {"zero": 0.02 * sign(rng)},
        growing=("zero",),
    ),
    "gimbal_misalignment": EffectKind(
        components=CMGS,
        units=dict.fromkeys(_TILTS, "rad"),
        apply=gimbal_misalignment,
        draw=lambda rng: dict(zip(_TILTS, map(float, 0.02 * _on_circle(rng)), strict=True)),
        growing=_TILTS,
    ),
    "gimbal_lag": EffectKind(
        components=(CLUSTER, *CMGS),
        units={"time_constant": "s"},
        apply=gimbal_lag,
        draw=lambda _: {"time_constant": 0.01},
        growing=("time_constant",),
    ),
    "gimbal_viscous_friction": EffectKind(
        components=CMGS,
        units={"coefficient": "N m s/rad"},
        apply=gimbal_viscous_friction,
        draw=lambda _: {"coefficient": 3e-5},
        growing=("coefficient",),
    ),
    "gimbal_coulomb_friction": EffectKind(
        components=CMGS,
        units={"torque": "N m", "stribeck_torque": "N m", "stribeck_rate": "rad/s"},
        apply=gimbal_coulomb_friction,
        draw=lambda rng: {
            "torque": 5e-5,
            "stribeck_torque": 5e-5 * float(rng.uniform(0.0, 0.5)),
            "stribeck_rate": 0.05,
        },
        growing=("torque", "stribeck_torque"),
    ),
    "gimbal_backlash": EffectKind(
        components=CMGS,
        units={"dead_zone": "rad"},
        apply=gimbal_backlash,
        draw=lambda _: {"dead_zone": 0.01},
        growing=("dead_zone",),
    ),
    "rotor_imbalance": EffectKind(
        components=CMGS,
        units={"static": "kg m", "dynamic": "kg m2", "phase": "rad"},
        apply=rotor_imbalance,
        draw=lambda rng: {"static": 2e-6, "dynamic": 5e-9, "phase": float(rng.uniform(0.0, 2.0 * np.pi))},
        growing=("static", "dynamic"),
    ),
}
"""By id."""


def _on_circle(rng: np.random.Generator) -> Array:
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return np.array([np.cos(angle), np.sin(angle)])
