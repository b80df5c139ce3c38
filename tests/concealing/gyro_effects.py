"""Effects in the gyro."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.concealing.craft import Array, Craft
from tests.concealing.effect import (
    AXES,
    GYRO,
    EffectKind,
    Parameters,
    direction,
    named_vector,
    names,
    sign,
    vector,
    vector_units,
)

_SHEARS = {"shear_yz": (1, 2), "shear_xz": (0, 2), "shear_xy": (0, 1)}
_BOTH = ("cmg", "applied_torque")


def gyro_bias(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """+ b."""
    return _with_gyro(craft, bias=craft.gyro.bias + vector(parameters, "bias"))


def gyro_drift(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A ramp from release on, or a random walk."""
    drift = craft.gyro.drift + vector(parameters, "drift")
    return _with_gyro(craft, drift=drift, random_walk=parameters["random_walk"])


def gyro_scale(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """(1 + s) ω of one axis."""
    scale = np.eye(3)
    axis = AXES.index(component)
    scale[axis, axis] += parameters["relative_error"]
    return _with_gyro(craft, response=scale @ craft.gyro.response)


def gyro_misalignment(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """The gyro is turned by a rotation vector, and its axes are oblique by a symmetric matrix of shears."""
    shear = np.eye(3)
    for name, (row, column) in _SHEARS.items():
        shear[row, column] = shear[column, row] = parameters[name]
    turn = Rotation.from_rotvec(vector(parameters, "rotation")).as_matrix()
    return _with_gyro(craft, response=shear @ turn.T @ craft.gyro.response)


def gyro_latency(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """ω(t - τ)."""
    return _with_gyro(craft, latency=parameters["delay"])


def gyro_bandwidth(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A first-order low-pass, -3 dB at the bandwidth."""
    return _with_gyro(craft, bandwidth=parameters["bandwidth"])


def gyro_noise(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """More noise than stated: of one axis, or of all."""
    factor = craft.gyro.noise_factor.copy()
    factor[slice(None) if component == GYRO else AXES.index(component)] *= np.sqrt(1.0 + parameters["excess"])
    return _with_gyro(craft, noise_factor=factor)


def gyro_quantization(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """Readings in steps."""
    return _with_gyro(craft, quantization=parameters["step"])


def gyro_saturation(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """Readings are clipped."""
    return _with_gyro(craft, saturation=parameters["level"])


def _with_gyro(craft: Craft, **changes: Array | float) -> Craft:
    return replace(craft, gyro=replace(craft.gyro, **changes))


def _gyro(units: dict[str, str], apply, draw, growing=(), shrinking=(), components=(GYRO,)) -> EffectKind:
    return EffectKind(
        components=components,
        units=units,
        apply=apply,
        draw=draw,
        growing=growing,
        shrinking=shrinking,
        actuation=_BOTH,
    )


KINDS = {
    "gyro_bias": _gyro(
        vector_units("bias", "rad/s"),
        gyro_bias,
        lambda rng: named_vector("bias", 2e-3 * direction(rng)),
        growing=names("bias"),
    ),
    "gyro_drift": _gyro(
        {**vector_units("drift", "rad/s2"), "random_walk": "rad/s1.5"},
        gyro_drift,
        lambda rng: {**named_vector("drift", 1e-3 * direction(rng)), "random_walk": 0.0},
        growing=(*names("drift"), "random_walk"),
    ),
    "gyro_scale": _gyro(
        {"relative_error": "1"},
        gyro_scale,
        lambda rng: {"relative_error": 0.03 * sign(rng)},
        growing=("relative_error",),
        components=AXES,
    ),
    "gyro_misalignment": _gyro(
        {**vector_units("rotation", "rad"), **dict.fromkeys(_SHEARS, "1")},
        gyro_misalignment,
        lambda rng: {**named_vector("rotation", 0.02 * direction(rng)), **dict.fromkeys(_SHEARS, 0.0)},
        growing=(*names("rotation"), *_SHEARS),
    ),
    "gyro_latency": _gyro({"delay": "s"}, gyro_latency, lambda _: {"delay": 0.01}, growing=("delay",)),
    "gyro_bandwidth": _gyro(
        {"bandwidth": "Hz"}, gyro_bandwidth, lambda _: {"bandwidth": 15.0}, shrinking=("bandwidth",)
    ),
    "gyro_noise": _gyro({"excess": "1"}, gyro_noise, lambda _: {"excess": 0.6}, growing=("excess",), components=AXES),
    "gyro_quantization": _gyro({"step": "rad/s"}, gyro_quantization, lambda _: {"step": 4e-3}, growing=("step",)),
    "gyro_saturation": _gyro({"level": "rad/s"}, gyro_saturation, lambda _: {"level": 0.6}, shrinking=("level",)),
}
"""By id."""
