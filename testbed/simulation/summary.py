"""The figures of one flight: tracking, use of the limits, conservation of momentum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from testbed.arrays import Array, Vector3, Vectors3
from testbed.rotation.quaternion import tilts
from testbed.signals import FLAGS, LIMITS

FlightLimits: TypeAlias = Mapping[str, float | Array]
"""What the largest fractions of a flight refer to, by the names of `signals.LIMITS`, in the signals' units.
A number for all of a kind, one for each, or one per body axis."""


@dataclass(frozen=True, kw_only=True)
class FlightSummary:
    """Figures of one flight.

    Attributes:
        tracking_rms: of true rate minus reference, shape (3,), rad/s.
        tracking_max: largest magnitude of it, shape (3,), rad/s.
        limit_use: largest fraction of each limit, by the limit's name.
        saturated: time in which any actuator was at a limit of its rate or torque, s.
        rotor_clamped: time in which any was at its momentum limit, s.
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
        saturated=_flagged_time(channels, period, of_momentum=False),
        rotor_clamped=_flagged_time(channels, period, of_momentum=True),
        min_singularity_measure=_least_measure(channels),
        momentum_drift=_momentum_drift(momentum_N, total_rotor_momentum),
        largest_tilt=float(tilts(channels["true_attitude"]).max()),
    )


def _least_measure(channels: Mapping[str, Array]) -> float | None:
    measure = channels.get("singularity_measure")
    return None if measure is None else float(measure.min())


def _limit_use(channels: Mapping[str, Array], limits: FlightLimits) -> dict[str, float]:
    used = {name: np.abs(channels[f"true_{name}"]) / limits[name] for name in LIMITS if f"true_{name}" in channels}
    return {name: float(fraction.max()) for name, fraction in used.items()}


def _flagged_time(channels: Mapping[str, Array], period: float, *, of_momentum: bool) -> float:
    names = [flag.name for flag in FLAGS if flag.of_momentum == of_momentum and flag.name in channels]
    flags = np.concatenate([channels[name] for name in names], axis=1)
    return float(flags.any(axis=1).sum() * period)


def _momentum_drift(momentum_N: Array, scale: float) -> float:
    return float(np.linalg.norm(momentum_N - momentum_N[0], axis=1).max() / scale)
