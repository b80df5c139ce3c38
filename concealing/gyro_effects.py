"""Effects in the gyro."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from concealing.craft import Array, Craft
from concealing.effect import (
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

_PAIRS = {"yz": (1, 2), "xz": (0, 2), "xy": (0, 1)}
_CROSS_AXIS = "gyro_cross_axis"
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
    scale[axis, axis] += parameters["scale_factor_error"]
    return _with_gyro(craft, response=scale @ craft.gyro.response)


def gyro_misalignment(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """The gyro is turned by the vector (yz, xz, xy), or its axes are oblique by a symmetric matrix of these."""
    response = Rotation.from_rotvec([parameters[name] for name in _PAIRS]).as_matrix().T
    if component == _CROSS_AXIS:
        response = np.eye(3)
        for name, (row, column) in _PAIRS.items():
            response[row, column] = response[column, row] = parameters[name]
    return _with_gyro(craft, response=response @ craft.gyro.response)


def gyro_latency(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """ω(t - τ)."""
    return _with_gyro(craft, latency=parameters["delay"])


def gyro_bandwidth(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A first-order low-pass, -3 dB at the bandwidth."""
    return _with_gyro(craft, bandwidth=parameters["bandwidth"])


def gyro_noise(craft: Craft, component: str, parameters: Parameters) -> Craft:
    """White noise beside what is stated: on one axis, or on all."""
    extra = craft.gyro.extra_noise.copy()
    extra[slice(None) if component == GYRO else AXES.index(component)] += parameters["extra_noise"]
    return _with_gyro(craft, extra_noise=extra)


def gyro_quantization(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """Readings in steps."""
    return _with_gyro(craft, quantization=parameters["step"])


def gyro_saturation(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """Readings are clipped."""
    return _with_gyro(craft, saturation=parameters["limit"])


def gyro_noise_color(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """Neighbouring samples of the nominal noise are correlated, a first-order autoregression of the same variance."""
    return _with_gyro(craft, noise_correlation=parameters["correlation"])


def gyro_rate_random_walk(craft: Craft, _: str, parameters: Parameters) -> Craft:
    """A bias that walks, from nothing at release."""
    return _with_gyro(craft, random_walk=parameters["rate_random_walk"])


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
        {"scale_factor_error": "1"},
        gyro_scale,
        lambda rng: {"scale_factor_error": 0.03 * sign(rng)},
        growing=("scale_factor_error",),
        components=AXES,
    ),
    "gyro_misalignment": _gyro(
        dict.fromkeys(_PAIRS, "rad"),
        gyro_misalignment,
        lambda rng: dict(zip(_PAIRS, map(float, 0.02 * direction(rng)), strict=True)),
        growing=tuple(_PAIRS),
        components=(_CROSS_AXIS, GYRO),
    ),
    "gyro_latency": _gyro({"delay": "s"}, gyro_latency, lambda _: {"delay": 0.01}, growing=("delay",)),
    "gyro_bandwidth": _gyro(
        {"bandwidth": "Hz"}, gyro_bandwidth, lambda _: {"bandwidth": 15.0}, shrinking=("bandwidth",)
    ),
    "gyro_noise": _gyro(
        {"extra_noise": "rad/s"},
        gyro_noise,
        lambda _: {"extra_noise": 1e-3},
        growing=("extra_noise",),
        components=(GYRO, *AXES),
    ),
    "gyro_quantization": _gyro({"step": "rad/s"}, gyro_quantization, lambda _: {"step": 4e-3}, growing=("step",)),
    "gyro_saturation": _gyro({"limit": "rad/s"}, gyro_saturation, lambda _: {"limit": 0.6}, shrinking=("limit",)),
}
"""By id."""
FURTHER = {
    "gyro_noise_color": _gyro(
        {"correlation": "1"}, gyro_noise_color, lambda rng: {"correlation": 0.3 * sign(rng)}, growing=("correlation",)
    ),
    "gyro_rate_random_walk": _gyro(
        {"rate_random_walk": "rad/s/√s"},
        gyro_rate_random_walk,
        lambda _: {"rate_random_walk": 5e-4},
        growing=("rate_random_walk",),
    ),
}
"""Effects that random sets do not draw, so that a seed makes the set that it always made; they are asked for."""
