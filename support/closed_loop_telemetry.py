"""Telemetry of a platform whose controller feeds the gyro's noise back into the gimbals, many flights at once.

Total momentum is zero, so that ω = -J(d)⁻¹ h holds exactly at every instant, however coarsely the gimbals are stepped:
only the gimbal motion is integrated, and the telemetry stays consistent with the physics to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from support.synthetic_telemetry import Flight, sample_times, with_gimbals
from testbed.arrays import Array, Series
from testbed.cmg.cluster import cluster_momentum, inertia_change, momentum_jacobian
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.telemetry import GimbalRun, GimbalTelemetry, Telemetry

SAMPLE_RATE = 16.0
STEPS_PER_SAMPLE = 20
SERVO_BANDWIDTH = 50.0
FEEDBACK = 1.5
"""1/s; the gain from rate error to body acceleration."""


@dataclass(frozen=True, kw_only=True)
class ClosedLoopFlights:
    """S flights of one maneuver, each with its own noise, sampled at the gyro's times.

    Attributes:
        time: shape (N,), s.
        true_rate: shape (N, S, 3), rad/s, body axes.
        measured_rate: shape (N, S, 3), rad/s.
        true_angle: gimbals, shape (N, S, 6), rad.
        measured_angle: shape (N, S, 6), rad.
    """

    time: Series
    true_rate: Array
    measured_rate: Array
    true_angle: Array
    measured_angle: Array


def closed_loop_flights(
    flight: Flight, rng: np.random.Generator, flights: int, gyro_noise: float, encoder_noise: float
) -> ClosedLoopFlights:
    """Fly a gimbal motion many times, its body rate tracked with feedback from the noisy gyro at 16 Hz."""
    time = sample_times(SAMPLE_RATE)
    reference_rate = flight.body_rate(time)
    angle = np.tile(flight.gimbals.angle(time[:1]), (flights, 1))
    rate = np.tile(flight.gimbals.rate(time[:1]), (flights, 1))
    rates, measured, angles = [], [], []
    for at, wanted in zip(time, reference_rate, strict=True):
        rates.append(_body_rate(flight, angle, rate))
        measured.append(rates[-1] + gyro_noise * rng.standard_normal((flights, 3)))
        angles.append(angle)
        correction = _gimbal_correction(flight, at, wanted - measured[-1])
        angle, rate = _next_sample(flight, at, angle, rate, correction)
    true_angle = np.array(angles)
    return ClosedLoopFlights(
        time=time,
        true_rate=np.array(rates),
        measured_rate=np.array(measured),
        true_angle=true_angle,
        measured_angle=true_angle + encoder_noise * rng.standard_normal(true_angle.shape),
    )


def measured_telemetry(flights: ClosedLoopFlights, flight: Flight, index: int, gyro_noise: float) -> GimbalRun:
    """Return what one of the flights sent down."""
    return Telemetry(
        gyro_time=flights.time,
        body_rate=flights.measured_rate[:, index],
        gyro_noise=gyro_noise,
        actuator_time=flights.time,
        gimbals=GimbalTelemetry(cluster=flight.cluster, angle=flights.measured_angle[:, index]),
    )


def true_telemetry(flights: ClosedLoopFlights, flight: Flight, index: int, gyro_noise: float) -> GimbalRun:
    """Return what it would have sent without noise, for the bound of the motion as flown."""
    measured = measured_telemetry(flights, flight, index, gyro_noise)
    actual = with_gimbals(measured, angle=flights.true_angle[:, index])
    return replace(actual, body_rate=flights.true_rate[:, index])


def _body_rate(flight: Flight, angle: Array, rate: Array) -> Array:
    inertia = inertia_of(flight.theta) + inertia_change(flight.cluster, angle)
    return -np.linalg.solve(inertia, cluster_momentum(flight.cluster, angle, rate)[..., None])[..., 0]


def _gimbal_correction(flight: Flight, at: float, rate_error: Array) -> Array:
    """Return the gimbal rates that turn the rate error into a torque, shape (S, 6), rad/s."""
    jacobian = momentum_jacobian(flight.cluster, flight.gimbals.angle(np.array([at]))[0])
    torque = FEEDBACK * rate_error @ inertia_of(flight.theta)
    return -torque @ np.linalg.pinv(jacobian).T


def _next_sample(flight: Flight, at: float, angle: Array, rate: Array, correction: Array) -> tuple[Array, Array]:
    """Step the gimbals to the next sample behind a first-order rate servo."""
    step = 1.0 / SAMPLE_RATE / STEPS_PER_SAMPLE
    share = 1.0 - np.exp(-SERVO_BANDWIDTH * step)
    times = np.minimum(at + step * np.arange(STEPS_PER_SAMPLE), sample_times(SAMPLE_RATE)[-1])
    for command in flight.gimbals.rate(times):
        angle, rate = angle + step * rate, rate + share * (command + correction - rate)
    return angle, rate
