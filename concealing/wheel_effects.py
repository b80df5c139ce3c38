"""Effects in reaction wheels and on an air bearing, and which effects a craft with wheels can have hidden in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from concealing.craft import Array
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
from concealing.library import FURTHER, LISTED
from concealing.platform_effects import with_torque
from concealing.wheels import WheelCraft, Wheels, horizontal_axis

WHEELS = tuple(f"wheel{number}" for number in range(1, 5))
_BESIDE_UNITS = (
    *("viscous_drag", "quadratic_drag", "body_torque", "inertial_torque", "tether", "contact"),
    *("gyro_bias", "gyro_drift", "gyro_scale", "gyro_misalignment", "gyro_latency", "gyro_bandwidth"),
    *("gyro_noise", "gyro_quantization", "gyro_saturation"),
)
"""Effects of the published table that sit in no gimbal, and in no actuator without momentum.

What moves inside is left out: slow turns excite it so little that at four detectable sizes a third of the CubeSat's
inertia would have to swing on a hinge, or a quarter of its mass be loose."""


def wheel_inertia(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """Js → (1 + e) Js of one wheel, of which nobody on board knows; the craft's whole inertia stays as it is."""
    scale = np.ones(len(craft.wheels.spin_inertia))
    scale[_index(component)] += parameters["relative_error"]
    return _with_wheels(craft, spin_inertia=scale * craft.wheels.spin_inertia)


def wheel_misalignment(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """a → (a + v × a) / |a + v × a|, v in the plane normal to a.

    Its first direction is horizontal, z × a, or x where a stands along z; its second a quarter turn about a from there.
    """
    axis = craft.wheels.axis.copy()
    drawn, first = axis[_index(component)], horizontal_axis(axis)[_index(component)]
    turn = parameters["about_first"] * first + parameters["about_second"] * np.cross(drawn, first)
    moved = drawn + np.cross(turn, drawn)
    axis[_index(component)] = moved / np.linalg.norm(moved)
    return _with_wheels(craft, axis=axis)


def wheel_speed_bias(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """The tachometer shows Ω + b; the drive trusts it."""
    return _with_added(craft, component, speed_bias=parameters["bias"])


def wheel_viscous_friction(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """The bearing brakes by c Ω more than is believed."""
    return _with_added(craft, component, viscous=parameters["coefficient"])


def wheel_coulomb_friction(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """The bearing brakes by so much more than is believed, whatever its speed."""
    return _with_added(craft, component, coulomb=parameters["torque"])


def wheel_torque_scale(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """The motor gives 1 + e of what it is commanded, and of what its current shows."""
    return _with_added(craft, component, torque_factor=parameters["relative_error"])


def wheel_lag(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """The motor's current follows its command as T i̇ = u - i."""
    return _with_added(craft, component, lag=parameters["time_constant"])


def wheel_delay(craft: WheelCraft, _: str, parameters: Parameters) -> WheelCraft:
    """All motors answer so much later; before the release they were asked for what the first command asks for."""
    return replace(craft, wheels=replace(craft.wheels, late=craft.wheels.late + parameters["delay"]))


def wheel_imbalance(craft: WheelCraft, component: str, parameters: Parameters) -> WheelCraft:
    """The rotor's mass times the distance of its centre from its axis; where it points at release is drawn by run."""
    return _with_added(craft, component, imbalance=parameters["static"])


def center_of_mass_offset(craft: WheelCraft, _: str, parameters: Parameters) -> WheelCraft:
    """The centre of mass is so far from where it is believed to be."""
    return replace(craft, pivot=replace(craft.pivot, offset=craft.pivot.offset + vector(parameters, "offset")))


def air_drag(craft: WheelCraft, _: str, parameters: Parameters) -> WheelCraft:
    """T = -c ω, the same about every axis."""
    return with_torque(craft, lambda motion: -parameters["coefficient"] * motion.body_rate)


def _with_added(craft: WheelCraft, component: str, **added: float) -> WheelCraft:
    chosen = np.arange(len(craft.wheels.axis)) == _index(component)
    return _with_wheels(craft, **{name: getattr(craft.wheels, name) + by * chosen for name, by in added.items()})


def _with_wheels(craft: WheelCraft, **changes: Array) -> WheelCraft:
    wheels: Wheels = replace(craft.wheels, **changes)
    return replace(craft, wheels=wheels)


def _index(component: str) -> int:
    return WHEELS.index(component)


def _of_wheel(units: Mapping[str, str], apply: Callable, draw: Callable, by_run: int = 0) -> EffectKind:
    return EffectKind(
        components=WHEELS, units=units, apply=apply, draw=draw, growing=tuple(units), actuation=(), by_run=by_run
    )


def _turned(rng: np.random.Generator) -> Parameters:
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return {"about_first": 0.01 * float(np.cos(angle)), "about_second": 0.01 * float(np.sin(angle))}


def _blow(rng: np.random.Generator) -> Parameters:
    """Return a blow somewhere in the long runs of craft with wheels, the shortest of which take 20 s."""
    struck = {"time": float(rng.uniform(3.0, 17.0)), "run": float(rng.integers(0, 4))}
    return named_vector("impulse", 2e-4 * direction(rng)) | struck


IN_DRIVES = {
    "wheel_viscous_friction": _of_wheel(
        {"coefficient": "N m s/rad"}, wheel_viscous_friction, lambda _: {"coefficient": 1e-8}
    ),
    "wheel_coulomb_friction": _of_wheel({"torque": "N m"}, wheel_coulomb_friction, lambda _: {"torque": 1e-5}),
    "wheel_torque_scale": _of_wheel(
        {"relative_error": "1"}, wheel_torque_scale, lambda rng: {"relative_error": 0.01 * sign(rng)}
    ),
    "wheel_lag": _of_wheel({"time_constant": "s"}, wheel_lag, lambda _: {"time_constant": 0.01}),
}
"""Effects between what one wheel's motor is commanded and how its speed changes, by id."""
OF_WHEELS = {
    "wheel_inertia": _of_wheel(
        {"relative_error": "1"}, wheel_inertia, lambda rng: {"relative_error": 0.01 * sign(rng)}
    ),
    "wheel_misalignment": _of_wheel({"about_first": "rad", "about_second": "rad"}, wheel_misalignment, _turned),
    "wheel_speed_bias": _of_wheel({"bias": "rad/s"}, wheel_speed_bias, lambda rng: {"bias": 5.0 * sign(rng)}),
    **IN_DRIVES,
    # Its line has two amplitudes in every run, as no run knows where the rotor points at release.
    "wheel_imbalance": _of_wheel({"static": "kg m"}, wheel_imbalance, lambda _: {"static": 5e-7}, by_run=2),
}
"""Effects in one wheel, by id."""
OF_BEARINGS = {
    "center_of_mass_offset": EffectKind(
        components=(PLATFORM,),
        units=vector_units("offset", "m"),
        apply=center_of_mass_offset,
        draw=lambda rng: named_vector("offset", 2e-5 * direction(rng)),
        growing=names("offset"),
        actuation=(),
    ),
    "air_drag": EffectKind(
        components=(PLATFORM,),
        units={"coefficient": "N m s/rad"},
        apply=air_drag,
        draw=lambda _: {"coefficient": 1e-3},
        growing=("coefficient",),
        actuation=(),
    ),
}
"""Effects on a ball joint, by id."""
FLYING: dict[str, EffectKind] = {
    **{name: LISTED[name] for name in _BESIDE_UNITS},
    "contact": replace(LISTED["contact"], draw=_blow),
    **{name: FURTHER[name] for name in ("dry_friction", "telemetry_skew", "gyro_noise_color")},
    **OF_WHEELS,
}
"""What can be hidden in a craft with wheels that flies freely, by id."""
STANDING = FLYING | OF_BEARINGS
"""What can be hidden in one on a bearing."""
BY_NAME = {
    "wheel_delay": EffectKind(
        components=("wheels",),
        units={"delay": "s"},
        apply=wheel_delay,
        draw=lambda _: {"delay": 0.02},
        growing=("delay",),
        actuation=(),
    )
}
"""What is hidden where it is asked for by name; random sets do not draw it: a seed makes what it always made."""
