"""The figures of one flight: tracking, use of the limits, conservation of momentum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Vector3


@dataclass(frozen=True, kw_only=True)
class FlightLimits:
    """What the largest fractions of a flight refer to.

    Attributes:
        gimbal_rate: rad/s.
        gimbal_torque: N·m.
        cluster_momentum: per body axis, shape (3,), N·m·s.
        cluster_torque: per body axis, shape (3,), N·m.
    """

    gimbal_rate: float
    gimbal_torque: float
    cluster_momentum: Vector3
    cluster_torque: Vector3


@dataclass(frozen=True, kw_only=True)
class FlightSummary:
    """Figures of one flight.

    Attributes:
        tracking_rms: of true rate minus reference, shape (3,), rad/s.
        tracking_max: largest magnitude of it, shape (3,), rad/s.
        limit_use: largest fraction of each limit, by the limit's name.
        saturated: time in which any gimbal was at a limit, s.
        rotor_clamped: time in which any rotor was beyond its momentum limit, s.
        min_singularity_measure: smallest on the way; 1 at the best, 0 where a torque direction is lost.
        momentum_drift: max |H_N(t) - H_N(0)| over the sum of the rotors' momenta; MuJoCo's own momentum.
    """

    tracking_rms: Vector3
    tracking_max: Vector3
    limit_use: Mapping[str, float]
    saturated: float
    rotor_clamped: float
    min_singularity_measure: float
    momentum_drift: float


def summarize(
    channels: Mapping[str, Array], period: float, limits: FlightLimits, total_rotor_momentum: float
) -> FlightSummary:
    """Condense the channels of a flown record.

    Args:
        channels: from `channels_of`.
        period: between rows, s.
        limits: to express use in.
        total_rotor_momentum: Σ |Js Ω|, N·m·s.
    """
    error = channels["true_body_rate"] - channels["reference_body_rate"]
    return FlightSummary(
        tracking_rms=np.sqrt((error**2).mean(axis=0)),
        tracking_max=np.abs(error).max(axis=0),
        limit_use=_limit_use(channels, limits),
        saturated=_flagged_time(channels, ("gimbal_rate_saturated", "gimbal_torque_saturated"), period),
        rotor_clamped=_flagged_time(channels, ("rotor_momentum_clamped",), period),
        min_singularity_measure=float(channels["singularity_measure"].min()),
        momentum_drift=_momentum_drift(channels["true_total_momentum"], total_rotor_momentum),
    )


def _limit_use(channels: Mapping[str, Array], limits: FlightLimits) -> dict[str, float]:
    used = {
        "gimbal_rate": np.abs(channels["true_gimbal_rate"]) / limits.gimbal_rate,
        "gimbal_torque": np.abs(channels["true_gimbal_torque"]) / limits.gimbal_torque,
        "cluster_momentum": np.abs(channels["true_cluster_momentum"]) / limits.cluster_momentum,
        "cluster_torque": np.abs(channels["true_cluster_torque"]) / limits.cluster_torque,
    }
    return {name: float(fraction.max()) for name, fraction in used.items()}


def _flagged_time(channels: Mapping[str, Array], names: tuple[str, ...], period: float) -> float:
    flags = np.concatenate([channels[name] for name in names], axis=1)
    return float(flags.any(axis=1).sum() * period)


def _momentum_drift(momentum_N: Array, scale: float) -> float:
    return float(np.linalg.norm(momentum_N - momentum_N[0], axis=1).max() / scale)
