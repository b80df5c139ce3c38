"""What an estimator is given: gyro samples, the telemetry of the actuators, and what is known of the momentum."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array, Flags, Series, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster
from testbed.errors import InputError

BRIDGED_PERIODS = 2.5
"""A gap of one lost sample is interpolated over; a longer one is not (0.25 s at 16 Hz already costs 2e-5 N·m·s)."""
ConstantTorque: TypeAlias = Literal["none", "body", "inertial", "both"]
FEWEST_SAMPLES = 4
"""A cubic spline needs four samples, and so does every estimator."""


@dataclass(frozen=True, kw_only=True)
class Servo:
    """What is known of the servo that every gimbal has, ë + ω_b ė + ω_n² e = 0 of the angle's error e.

    Attributes:
        bandwidth: ω_b of the tachometer loop inside the motor, 1/s.
        stiffness: ω_n² of the loop on the encoder, 1/s².
        rate_limit: largest set point of the tachometer loop, rad/s.
        period: of the control loop, s; telemetry is sampled on its clock.
    """

    bandwidth: float
    stiffness: float
    rate_limit: float
    period: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Telemetry:
    """The measurements of one run. Channels that were not sent are None; there are no NaN inside.

    Two are the same only if they are one object, by which what follows from them is remembered.

    Attributes:
        gyro_time: shape (N,), s, strictly increasing; gaps and jitter are allowed.
        body_rate: measured ω, shape (N, 3), rad/s, body axes.
        gyro_noise: standard deviation of its white noise per sample, rad/s.
        actuator_time: shape (K,), s, strictly increasing; may differ from the gyro's in rate, start and end.
        cluster: the CMG units; needed with `gimbal_angle`.
        gimbal_angle: encoders, shape (K, 6), rad.
        rotor_momentum: tachometers times Js, shape (K, 6), N·m·s; the nominal one where None.
        cluster_momentum: h as the platform itself reports it, shape (K, 3), N·m·s, body axes; used where
            `gimbal_angle` is None, and then the inertia's change with the gimbal angles is left out.
        applied_torque: torque of actuators that store no momentum, shape (K, 3), N·m, body axes.
        gimbal_torque: of the gimbal motors, shape (K, 6), N·m.
        gimbal_rate_command: as commanded by the steering law, shape (K, 6), rad/s.
        servo: of the gimbals; None where it is not known.
        initial_momentum: whether the whole platform's momentum at the first sample is known to be zero.
        constant_torque: which constant torques on the platform are estimated jointly: fixed in the body, fixed in
            inertial axes, or both.
        noise_freedom: degrees of freedom with which `gyro_noise` is known; infinite where it is stated.
        gyro_error: what of `body_rate` is known to be the gyro's own, shape (N, 3), rad/s; nothing where None.
    """

    gyro_time: Series
    body_rate: Vectors3
    gyro_noise: float
    actuator_time: Series
    cluster: Cluster | None = None
    gimbal_angle: UnitSeries | None = None
    rotor_momentum: UnitSeries | None = None
    cluster_momentum: Vectors3 | None = None
    applied_torque: Vectors3 | None = None
    gimbal_torque: UnitSeries | None = None
    gimbal_rate_command: UnitSeries | None = None
    servo: Servo | None = None
    initial_momentum: Literal["estimated", "zero"] = "estimated"
    constant_torque: ConstantTorque = "none"
    noise_freedom: float = np.inf
    gyro_error: Vectors3 | None = None

    @property
    def momentum_unknowns(self) -> int:
        """Number of unknowns that the initial momentum makes."""
        return 0 if self.initial_momentum == "zero" else 3

    @property
    def torque_names(self) -> tuple[str, ...]:
        """Names of the constant torques' components; their unknowns stand behind inertia and momentum."""
        frames = {"none": (), "body": ("body",), "inertial": ("inertial",), "both": ("body", "inertial")}
        return tuple(f"{frame}_{axis}" for frame in frames[self.constant_torque] for axis in "xyz")

    @property
    def torque_unknowns(self) -> int:
        """Number of unknowns that constant torques make."""
        return len(self.torque_names)

    def torque_of(self, unknowns: Array) -> Array:
        """Return the constant torques among an estimator's unknowns, shape (K,), N·m."""
        return unknowns[len(unknowns) - self.torque_unknowns :]


def covered_part(telemetry: Telemetry) -> Telemetry:
    """Return the telemetry without the gyro samples that no actuator telemetry covers, or that stand alone.

    Raises:
        InputError: too few samples are left.
    """
    if len(telemetry.actuator_time) < FEWEST_SAMPLES:
        raise InputError(
            f"the actuator telemetry has {len(telemetry.actuator_time)} samples; an estimate needs {FEWEST_SAMPLES}"
        )
    covered = np.flatnonzero(covered_by(telemetry.gyro_time, telemetry.actuator_time))
    keep = np.concatenate([covered[run] for run in stretches(telemetry.gyro_time[covered])] or [covered[:0]])
    if len(keep) == 0:
        raise InputError(
            f"{len(covered)} of {len(telemetry.gyro_time)} gyro samples lie within the actuator telemetry, and no "
            f"{FEWEST_SAMPLES} of them follow one another without a gap: give a longer record"
        )
    return replace(telemetry, gyro_time=telemetry.gyro_time[keep], body_rate=telemetry.body_rate[keep])


def stretches(time: Series) -> list[slice]:
    """Return the runs of samples without a gap between them that are long enough for a spline."""
    edges = [0, *(np.flatnonzero(_gaps(time)) + 1).tolist(), len(time)]
    return [slice(first, last) for first, last in pairwise(edges) if last - first >= FEWEST_SAMPLES]


def _gaps(time: Series) -> Flags:
    """Return which intervals between samples are too long to interpolate over, shape (N-1,)."""
    interval = np.diff(time)
    return np.asarray(interval > BRIDGED_PERIODS * np.median(interval)) if len(interval) else np.zeros(0, dtype=bool)


def covered_by(time: Series, samples: Series) -> Flags:
    """Return which instants lie between two samples without a gap, or on one, shape (N,).

    Args:
        time: of the instants, shape (N,), s.
        samples: times of another channel, s.
    """
    following = np.clip(np.searchsorted(samples, time), 1, len(samples) - 1)
    inside = (time >= samples[0]) & (time <= samples[-1])
    return np.asarray(inside & (np.isin(time, samples) | ~_gaps(samples)[following - 1]))
