"""The figures of one flight: tracking, use of the limits, conservation of momentum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Units, Vector3, Vectors3
from testbed.rotation.quaternion import tilts


@dataclass(frozen=True, kw_only=True)
class FlightLimits:
    """What the largest fractions of a flight refer to.

    Attributes:
        gimbal_rate: rad/s.
        gimbal_torque: N·m.
        cluster_momentum: per body axis, shape (3,), N·m·s.
        cluster_torque: per body axis, shape (3,), N·m.
        wheel_torque: of each reaction wheel, shape (W,), N·m.
        wheel_speed: at which each wheel is at its momentum limit, shape (W,), rad/s.
    """

    gimbal_rate: float
    gimbal_torque: float
    cluster_momentum: Vector3
    cluster_torque: Vector3
    wheel_torque: Units
    wheel_speed: Units


@dataclass(frozen=True, kw_only=True)
class FlightSummary:
    """Figures of one flight.

    Attributes:
        tracking_rms: of true rate minus reference, shape (3,), rad/s.
        tracking_max: largest magnitude of it, shape (3,), rad/s.
        limit_use: largest fraction of each limit, by the limit's name.
        saturated: time in which any gimbal, or the torque of any wheel, was at a limit, s.
        rotor_clamped: time in which any rotor or wheel was at its momentum limit, s.
        min_singularity_measure: smallest on the way; 1 at the best, 0 where a torque direction is lost; None without
            control moment gyros.
        momentum_drift: max |H_N(t) - H_N(0)|, without what the environment's torque changed, over the sum of the
            rotors' momenta; MuJoCo's own momentum.
        largest_tilt: of the body's z axis from the vertical, rad.
    """

    tracking_rms: Vector3
    tracking_max: Vector3
    limit_use: Mapping[str, float]
    saturated: float
    rotor_clamped: float
    min_singularity_measure: float | None
    momentum_drift: float
    largest_tilt: float


def summarize(
    channels: Mapping[str, Array],
    period: float,
    limits: FlightLimits,
    total_rotor_momentum: float,
    outside_impulse_N: Vectors3 | None = None,
) -> FlightSummary:
    """Condense the channels of a flown record.

    Args:
        channels: from `channels_of`.
        period: between rows, s.
        limits: to express use in.
        total_rotor_momentum: Σ |Js Ω|, N·m·s.
        outside_impulse_N: what the environment has changed of the total momentum, shape (N, 3), N·m·s; nothing where
            None.
    """
    momentum_N = channels["true_total_momentum"]
    if outside_impulse_N is not None:
        momentum_N = momentum_N - outside_impulse_N
    error = channels["true_body_rate"] - channels["reference_body_rate"]
    return FlightSummary(
        tracking_rms=np.sqrt((error**2).mean(axis=0)),
        tracking_max=np.abs(error).max(axis=0),
        limit_use=_limit_use(channels, limits),
        saturated=_flagged_time(channels, _AT_LIMIT, period),
        rotor_clamped=_flagged_time(channels, ("rotor_momentum_clamped", "wheel_momentum_clamped"), period),
        min_singularity_measure=_least_measure(channels),
        momentum_drift=_momentum_drift(momentum_N, total_rotor_momentum),
        largest_tilt=float(tilts(channels["true_attitude"]).max()),
    )


_LIMITED = ("gimbal_rate", "gimbal_torque", "cluster_momentum", "cluster_torque", "wheel_torque", "wheel_speed")
"""Quantities that have a limit, of those that a platform has."""


_AT_LIMIT = ("gimbal_rate_saturated", "gimbal_torque_saturated", "wheel_torque_saturated")


def _least_measure(channels: Mapping[str, Array]) -> float | None:
    measure = channels.get("singularity_measure")
    return None if measure is None else float(measure.min())


def _limit_use(channels: Mapping[str, Array], limits: FlightLimits) -> dict[str, float]:
    used = {
        name: np.abs(channels[f"true_{name}"]) / getattr(limits, name)
        for name in _LIMITED
        if f"true_{name}" in channels
    }
    return {name: float(fraction.max()) for name, fraction in used.items()}


def _flagged_time(channels: Mapping[str, Array], names: tuple[str, ...], period: float) -> float:
    flags = np.concatenate([channels[name] for name in names if name in channels], axis=1)
    return float(flags.any(axis=1).sum() * period)


def _momentum_drift(momentum_N: Array, scale: float) -> float:
    return float(np.linalg.norm(momentum_N - momentum_N[0], axis=1).max() / scale)
