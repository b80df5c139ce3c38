"""What a model predicts that flights would show: all channels that the present records have, many flights at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbed.arrays import Array, Series, Vectors3
from testbed.assembly.platform import Body
from testbed.cmg.cluster import cluster_momentum
from testbed.cmg.wheels import wheel_momentum
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.estimation.surroundings import integrated
from testbed.estimation.telemetry import CommandedGimbals, GimbalTelemetry, Telemetry, WheelTelemetry
from testbed.next_experiment.flight import NextFlight
from testbed.prediction.grid import grid_of
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values
from testbed.prediction.motor_torques import has_torques
from testbed.prediction.prediction import predicted_channels, predicted_with_derivatives
from testbed.prediction.wheel_response import compared_wheels

_STEP = 1.0 / 32.0
"""s; half as fine as a diagnosis integrates: distances move by less than 1 %, and by less than 1e-4 σ for case 11 of 14
of seed 90817."""
_ROUNDING = 1e-9
"""Share of a period by which a duration may miss a whole number of them: rounding of the clock that telemetry shows."""


def forecast(model: Fit, flights: Sequence[NextFlight], runs: Runs) -> Array:
    """Return what a model predicts of flights, whitened, shape (F, S).

    Args:
        model: fitted to the present runs; effects that happened once do not come again.
        flights: of one duration.
        runs: from `blank_runs`, one for each flight.
    """
    blocks = predicted_channels(runs.grid, _hooks(model), _values(model, flights))
    return _by_flight([block[0][..., None] for block in blocks], runs)[..., 0]


def forecast_columns(model: Fit, flights: Sequence[NextFlight], runs: Runs) -> Array:
    """Return the derivatives of a forecast by θ, effects and initial rate, shape (F, S, C + 3); arguments likewise."""
    values = _values(model, flights)
    _, blocks = predicted_with_derivatives(runs.grid, _hooks(model), values, predict=predicted_channels)
    return _by_flight(blocks, runs)


def _hooks(model: Fit) -> list[Hooks]:
    return [each.hooks if each.effect.recurs else Hooks() for each in model.placed]


def _values(model: Fit, flights: Sequence[NextFlight]) -> Values:
    released = np.stack([flight.body_rate for flight in flights])[:, None]
    return Values(theta=model.values.theta, initial_rate=released, effects=model.values.effects)


def _by_flight(blocks: Sequence[Array], runs: Runs) -> Array:
    """Return whitened blocks, channel after channel, flight by flight, shape (F, S, C); the shorter end in zeros."""
    whitened, flights = runs.whitened_columns(blocks), len(runs.names)
    whole = [np.concatenate(whitened[index::flights]) for index in range(flights)]
    longest = max(len(each) for each in whole)
    return np.stack([np.pad(each, ((0, longest - len(each)), (0, 0))) for each in whole])


def blank_runs(flights: Sequence[NextFlight], like: Runs, platform: Body) -> Runs:
    """Return runs with the telemetry that flights would send: the channels, rates and noise of the present ones.

    Args:
        flights: of one duration.
        like: the present runs.
        platform: the nominal one.
    """
    known = like.grid.runs[0]
    gyro_time, actuator_time = (_clock(time, flights[0].duration) for time in (known.gyro_time, known.actuator_time))
    telemetry = [_telemetry(flight, known, gyro_time, actuator_time, platform) for flight in flights]
    grid = replace(
        grid_of(telemetry, _STEP), follows_commands=like.grid.follows_commands, wheel_noise=like.grid.wheel_noise
    )
    kinds = int(has_torques(grid)) + int(grid.follows_commands) + len(compared_wheels(grid))
    return Runs(
        names=tuple(f"flight {number}" for number in range(len(flights))),
        grid=grid,
        sigma=np.tile(np.sqrt(np.mean(like.sigma**2, axis=0)), (len(flights), 1)),
        inner_noise=tuple(
            replace(like.inner_noise[kind * len(like.names)], time=None) for kind in range(kinds) for _ in flights
        ),
    )


def _clock(time: Series, duration: float) -> Series:
    period = float(np.median(np.diff(time)))
    return np.asarray(np.arange(int(duration / period + _ROUNDING) + 1) * period)


def _telemetry(
    flight: NextFlight, known: Telemetry, gyro_time: Series, actuator_time: Series, platform: Body
) -> Telemetry:
    body_rate = np.tile(flight.body_rate, (len(gyro_time), 1))
    gimbals, wheels, around = known.gimbals, known.wheels, known.surroundings
    start = None if around is None else integrated(gyro_time, body_rate, flight.attitude)
    return replace(
        known,
        gyro_time=gyro_time,
        body_rate=body_rate,
        gyro_error=None,
        reading_error=None,
        actuator_time=actuator_time,
        gimbals=None if gimbals is None else _gimbals(gimbals, flight, actuator_time),
        wheels=None if wheels is None else _wheels(wheels, flight, actuator_time),
        cluster_momentum=None if known.cluster_momentum is None else _reported(flight, actuator_time, platform),
        applied_torque=None if known.applied_torque is None else np.zeros((len(actuator_time), 3)),
        surroundings=None if around is None or start is None else replace(around, attitude=start),
    )


def _reported(flight: NextFlight, time: Series, platform: Body) -> Vectors3:
    """Return what all actuators hold, shape (K, 3), N·m·s, body axes."""
    of_wheels_B = wheel_momentum(platform.wheels, flight.wheel_momentum(time))
    if platform.cluster is None:
        return of_wheels_B
    return cluster_momentum(platform.cluster, flight.gimbal_angle(time), flight.gimbal_angle(time, 1)) + of_wheels_B


def _gimbals(known: GimbalTelemetry, flight: NextFlight, time: Series) -> GimbalTelemetry:
    angle, rate = flight.gimbal_angle(time), flight.gimbal_angle(time, 1)
    likewise = replace(
        known,
        angle=angle,
        rotor_momentum=None if known.rotor_momentum is None else np.tile(known.cluster.rotor_momentum, (len(angle), 1)),
        torque=None if known.torque is None else np.zeros_like(angle),
    )
    return replace(likewise, rate_command=rate) if isinstance(likewise, CommandedGimbals) else likewise


def _wheels(known: WheelTelemetry, flight: NextFlight, time: Series) -> WheelTelemetry:
    """Return what the wheels send on their path; their motors make up for the friction that is known.

    What turning along with the body takes is left out, the share of a wheel's inertia in that of the body, 1e-3.
    """
    momentum, torque = flight.wheel_momentum(time), flight.wheel_momentum(time, 1)
    if known.motors is not None:
        speed = momentum / known.wheels.spin_inertia
        torque = torque + known.motors.viscous_friction * speed + known.motors.coulomb_friction * np.sign(speed)
    return replace(
        known,
        momentum=momentum,
        torque=None if known.torque is None else torque,
        torque_command=None if known.torque_command is None else torque,
        smoothed=known.smoothed and replace(known.smoothed, samples=momentum),
        scatter=known.scatter and replace(known.scatter, samples=np.zeros_like(momentum)),
    )
