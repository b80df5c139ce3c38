"""Telemetry of a platform that turns by exact conservation of momentum, without a simulator.

The gimbals follow smooth windowed sines, so that every quantity has a closed form, or an integral with a tight
tolerance: an authority for the estimators that shares no code with them but the cluster's own geometry.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from testbed.arrays import Series, Theta, UnitSeries, Vector3, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.telemetry import GimbalRun, GimbalTelemetry, Telemetry

DURATION = 5.0
TRUE_THETA = np.array([0.022, 0.022, 0.027, 0.0, 0.0, 0.0])
NOMINAL_THETA = TRUE_THETA * np.array([1.03, 0.98, 1.02, 1.0, 1.0, 1.0]) + np.array([0, 0, 0, 3e-4, -3e-4, 2e-4])
_AZIMUTH = np.deg2rad(60.0 * np.arange(6))


def pyramid_cluster() -> Cluster:
    """Return the nominal hexagonal pyramid: skew 63.9 deg, h = 0.004714 N·m·s."""
    cos, sin, skew = np.cos(_AZIMUTH), np.sin(_AZIMUTH), np.deg2rad(63.9)
    return Cluster(
        gimbal_axis_B=np.stack([np.sin(skew) * cos, np.sin(skew) * sin, np.full(6, np.cos(skew))], axis=1),
        spin_axis_B=np.stack([-sin, cos, np.zeros(6)], axis=1),
        rotor_momentum=np.full(6, 0.004714),
        rotor_spin_inertia=np.full(6, 1.0e-5),
        rotor_transverse_inertia=np.full(6, 5.3e-6),
        gimbal_inertia=np.full(6, 3.0e-6),
    )


@dataclass(frozen=True, kw_only=True)
class GimbalMotion:
    """Six sums of sines under the window (1 - (2t/T - 1)⁶)², at rest at both ends.

    Attributes:
        amplitude: shape (6, F), rad.
        frequency: shape (F,), rad/s.
        phase: shape (F,), rad.
    """

    amplitude: np.ndarray
    frequency: np.ndarray
    phase: np.ndarray

    def angle(self, time: Series) -> UnitSeries:
        """Return the gimbal angles, shape (N, 6), rad."""
        return self._window(time) * (np.sin(self._argument(time)) @ self.amplitude.T)

    def rate(self, time: Series) -> UnitSeries:
        """Return their derivatives, shape (N, 6), rad/s."""
        sines = np.sin(self._argument(time)) @ self.amplitude.T
        slopes = (self.frequency * np.cos(self._argument(time))) @ self.amplitude.T
        return self._window(time) * slopes + self._window_slope(time) * sines

    def _argument(self, time: Series) -> np.ndarray:
        return time[:, None] * self.frequency + self.phase

    def _window(self, time: Series) -> np.ndarray:
        return (1.0 - (2.0 * time[:, None] / DURATION - 1.0) ** 6) ** 2

    def _window_slope(self, time: Series) -> np.ndarray:
        place = 2.0 * time[:, None] / DURATION - 1.0
        return -24.0 / DURATION * place**5 * (1.0 - place**6)


def nominal_gimbal_motion() -> GimbalMotion:
    """Return a motion of up to 1.05 rad and 1.9 rad/s whose body rate reaches 0.3, 0.3 and 0.7 rad/s."""
    modes = np.stack([0.735 * np.cos(_AZIMUTH), 0.84 * np.sin(_AZIMUTH), np.full(6, 0.84)], axis=1)
    return GimbalMotion(amplitude=modes, frequency=np.array([1.1, 1.5, 1.3]), phase=np.array([0.1, 5.2, 1.0]))


@dataclass(frozen=True, kw_only=True)
class Flight:
    """A free flight of the platform.

    Attributes:
        theta: its inertia, kg·m².
        cluster: its CMGs.
        gimbals: what they do.
        initial_momentum_B: of the whole platform at time zero, N·m·s.
    """

    theta: Theta
    cluster: Cluster
    gimbals: GimbalMotion
    initial_momentum_B: Vector3

    def momentum(self, time: Series) -> Vectors3:
        """Return the whole platform's momentum, shape (N, 3), N·m·s, body axes, from L̇ = -ω × L; times from 0 on."""
        if not self.initial_momentum_B.any():
            return np.zeros((len(time), 3))
        solution = solve_ivp(
            lambda at, momentum: -np.cross(self._rate(np.array([at]), momentum[None])[0], momentum),
            (0.0, time[-1]), self.initial_momentum_B, method="DOP853", t_eval=time, rtol=1e-12, atol=1e-15,
        )  # fmt: skip
        return solution.y.T

    def body_rate(self, time: Series) -> Vectors3:
        """Return ω = J(d)⁻¹ (L - h), shape (N, 3), rad/s, body axes."""
        return self._rate(time, self.momentum(time))

    def _rate(self, time: Series, momentum: Vectors3) -> Vectors3:
        angle, rate = self.gimbals.angle(time), self.gimbals.rate(time)
        inertia = inertia_of(self.theta) + inertia_change(self.cluster, angle)
        spin = momentum - cluster_momentum(self.cluster, angle, rate)
        return np.linalg.solve(inertia, spin[..., None])[..., 0]


def nominal_flight(initial_momentum_B: Vector3 | None = None) -> Flight:
    """Return the nominal platform on the nominal gimbal motion; at rest with the world where no momentum is given."""
    momentum_B = np.zeros(3) if initial_momentum_B is None else initial_momentum_B
    return Flight(
        theta=TRUE_THETA, cluster=pyramid_cluster(), gimbals=nominal_gimbal_motion(), initial_momentum_B=momentum_B
    )


def sample_times(rate_hz: float, start: float = 0.0, stop: float = DURATION) -> Series:
    """Return k / rate for every k with start ≤ k / rate ≤ stop, s."""
    return np.arange(np.ceil(start * rate_hz), np.floor(stop * rate_hz) + 1) / rate_hz


def exact_telemetry(flight: Flight, gyro_time: Series, actuator_time: Series, gyro_noise: float = 0.0) -> GimbalRun:
    """Return telemetry without noise; `gyro_noise` is only what it says of itself."""
    return Telemetry(
        gyro_time=gyro_time,
        body_rate=flight.body_rate(gyro_time),
        gyro_noise=gyro_noise,
        actuator_time=actuator_time,
        gimbals=GimbalTelemetry(cluster=flight.cluster, angle=flight.gimbals.angle(actuator_time)),
    )


def with_gimbals(run: GimbalRun, **changes: Any) -> GimbalRun:
    """Return a run with other channels of its gimbals, or another cluster."""
    return replace(run, gimbals=replace(run.gimbals, **changes))


def noisy(telemetry: GimbalRun, seed: int, encoder_noise: float) -> GimbalRun:
    """Return exact telemetry with the gyro's and the encoders' white noise on it."""
    gyro, encoders = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(2))
    angle = telemetry.gimbals.angle
    return replace(
        with_gimbals(telemetry, angle=angle + encoder_noise * encoders.standard_normal(angle.shape)),
        body_rate=telemetry.body_rate + telemetry.gyro_noise * gyro.standard_normal(telemetry.body_rate.shape),
    )
