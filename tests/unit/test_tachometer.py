"""Wheels' momenta behind the noise of their tachometers: noise is taken away, what wheels really do stays."""

from __future__ import annotations

import numpy as np
import pytest

from support.maneuvers import CLUSTER
from testbed.arrays import Array
from testbed.cmg.wheels import Wheels
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry, WheelMotors, WheelTelemetry
from testbed.estimation.telemetry_noise import momentum_covariance
from testbed.prediction.grid import grid_of
from testbed.prediction.tachometer import smoothed_rotors, without_tachometer_noise

PERIOD, NOISE, SPIN = 0.1, 7.5e-7, 1.5e-5  # s, N·m·s, kg·m²: those of the shipped CubeSat
TIME = PERIOD * np.arange(600)
WHEELS = Wheels(
    axis_B=np.eye(3), spin_inertia=np.full(3, SPIN), momentum_limit=np.full(3, 0.1), torque_limit=np.full(3, 0.1)
)
MOTORS = WheelMotors(
    viscous_friction=np.zeros(3), coulomb_friction=np.zeros(3), loop_bandwidth=np.zeros(3), period=PERIOD
)


def torques(seed: int, jitter: float = 0.0) -> Array:
    """What motors hold through every period, shape (600, 3), N·m: a slow turn, and white torques beside it."""
    slow = 4e-3 * np.cos(0.6 * TIME[:, None] + np.arange(3))
    return slow + jitter * np.random.default_rng(seed).standard_normal((600, 3))


def held(torque: Array) -> Array:
    """The momentum that they make of it, shape (600, 3), N·m·s."""
    return 0.02 + np.concatenate([np.zeros((1, 3)), np.cumsum(torque[:-1], axis=0) * PERIOD])


def corners(seed: int) -> Array:
    """Body rates along straight lines from corner to corner, shape (600, 3), rad/s: a slew's."""
    at = np.arange(0.0, TIME[-1] + 6.0, 6.0)
    rates = np.random.default_rng(seed).uniform(-0.16, 0.16, (3, len(at)))
    return np.stack([np.interp(TIME, at, each) for each in rates], axis=1)


def run(
    momentum: Array, seed: int, command: Array | None = None, noise: float = NOISE, body_rate: Array | None = None
) -> Telemetry:
    shown = momentum + noise * np.random.default_rng(1000 + seed).standard_normal(momentum.shape)
    wheels = WheelTelemetry(wheels=WHEELS, momentum=shown, torque_command=command, motors=MOTORS)
    return Telemetry(
        gyro_time=TIME,
        body_rate=np.zeros((600, 3)) if body_rate is None else body_rate,
        gyro_noise=4e-4,
        actuator_time=TIME,
        gimbals=None,
        applied_torque=None,
        wheels=wheels,
    )


def errors(runs: list[Telemetry], true: list[Array]) -> tuple[float, float]:
    """Root mean square of the momenta's errors, and as it is stated."""
    cleaned = without_tachometer_noise(runs)
    each = [one.wheels for one in cleaned if one.wheels is not None]
    found = [wheels.best_momentum - momentum for wheels, momentum in zip(each, true, strict=True)]
    smoothed = each[0].smoothed
    assert smoothed is not None
    return float(np.sqrt(np.mean(np.square(found)))), float(np.sqrt(smoothed.variance.mean()))


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_noise_is_separated_by_the_impulses_that_were_commanded(seed):
    command = torques(seed, jitter=1e-4)
    error, stated = errors([run(held(command), seed, command)], [held(command)])
    assert error < 0.2 * NOISE
    assert stated < 0.25 * NOISE


@pytest.mark.parametrize("seed", [71, 72, 73])
def test_what_the_body_turns_with_the_wheels_is_not_smoothed_away(seed):
    command, carried = torques(seed, jitter=1e-4), SPIN * corners(seed)
    true = held(command) + carried[0] - carried  # relative to the body, as a tachometer counts
    (cleaned,) = without_tachometer_noise([run(true, seed, command, body_rate=corners(seed))])
    assert cleaned.wheels is not None
    missed, turned = cleaned.wheels.best_momentum - true, carried - carried.mean(axis=0)
    assert abs(np.sum(missed * turned) / np.sum(turned**2)) < 0.01
    assert np.std(missed) < 0.2 * NOISE


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_motors_that_give_less_than_they_are_asked_for_do_not_mislead(seed):
    command = torques(seed, jitter=1e-4)
    momentum = held(0.95 * command)
    error, stated = errors([run(momentum, seed, command)], [momentum])
    assert error < 1.05 * NOISE
    assert error < 1.3 * stated


@pytest.mark.parametrize("seed", [31, 32, 33])
def test_motors_that_jitter_beside_their_commands_are_not_smoothed(seed):
    momentum = held(torques(seed, jitter=1e-3))
    exact, _ = errors([run(momentum, seed, torques(seed), noise=0.0)], [momentum])
    noisy, _ = errors([run(momentum, seed, torques(seed))], [momentum])
    assert exact < 0.2 * NOISE  # of jitter of 130 times the noise
    assert noisy < 1.05 * NOISE


def test_wheels_whose_torques_are_not_known_are_taken_as_they_are():
    (left,) = without_tachometer_noise([run(held(torques(41)), 41)])
    assert left.wheels is not None
    assert left.wheels.smoothed is None


def test_a_wheel_that_stands_still_is_left_as_it_is():
    error, stated = errors([run(np.zeros((600, 3)), 51, np.zeros((600, 3)), noise=0.0)], [np.zeros((600, 3))])
    assert (error, stated) == (0.0, 0.0)


def test_the_prediction_follows_what_is_left():
    command = torques(61, jitter=1e-4)
    noisy = run(held(command), 61, command)
    grid = grid_of([noisy])
    at_samples = [np.interp(TIME, grid.time[0], grid.wheel_momentum[0, 0, :, wheel]) for wheel in range(3)]
    assert noisy.wheels is not None
    cleaned = np.std(np.transpose(at_samples) - held(command))
    assert cleaned < 0.3 * np.std(noisy.wheels.momentum - held(command))
    (again,) = without_tachometer_noise(grid.runs)
    assert again is grid.runs[0]  # what was smoothed before stays


def spinning(momentum: Array, seed: int, noise: float) -> Telemetry:
    """A flight of six gyros at rest in their gimbals, momenta of shape (600, 6), N·m·s, behind noise, rad/s."""
    error = noise * np.random.default_rng(1000 + seed).standard_normal(momentum.shape)
    shown = momentum + CLUSTER.rotor_spin_inertia * error
    gimbals = GimbalTelemetry(cluster=CLUSTER, angle=np.zeros(momentum.shape), rotor_momentum=shown)
    return Telemetry(
        gyro_time=TIME,
        body_rate=np.zeros((600, 3)),
        gyro_noise=4e-4,
        actuator_time=TIME,
        gimbals=gimbals,
        applied_torque=None,
    )


@pytest.mark.parametrize("seed", [71, 72, 73])
def test_rotors_that_hold_or_lose_their_speed_are_freed_of_their_tachometers_noise(seed):
    noise, lost = 0.05, 1.0 - 1e-3 * np.exp(-TIME / 20.0)  # rad/s; a thousandth of the speed, while a servo takes it up
    true = CLUSTER.rotor_momentum * np.column_stack([np.ones((600, 3)), np.tile(lost[:, None], 3)])
    run = spinning(true, seed, noise)
    first = next(smoothed_rotors([run]))[0]
    assert first.gimbals is not None
    assert first.gimbals.rotor_momentum is not None
    assert first.gimbals.rotor_speed_noise == pytest.approx(noise, rel=0.1)
    missed = (first.gimbals.rotor_momentum - true) / CLUSTER.rotor_spin_inertia
    assert np.all(np.std(missed, axis=0) < 0.25 * noise)
    left, sent = np.trace(momentum_covariance(first)), np.trace(momentum_covariance(run))
    assert sent == pytest.approx(np.sum((CLUSTER.rotor_spin_inertia * noise) ** 2), rel=0.1)
    assert left < 0.01 * sent


def test_rotors_without_noise_are_not_smoothed():
    swinging = CLUSTER.rotor_momentum * (1.0 + 0.1 * np.sin(0.6 * TIME[:, None]))
    assert not list(smoothed_rotors([spinning(swinging, 81, 0.0)]))
