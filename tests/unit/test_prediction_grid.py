"""The integration's grid: fine enough for the torque that is applied, with what was applied before the first sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from testbed.effects.actuator_delay import ActuatorDelay
from testbed.effects.actuator_lag import ActuatorLag
from testbed.effects.contact import Contact
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import LONGEST_STEP, Grid, grid_of
from testbed.prediction.integration import Values, node_rates
from testbed.prediction.prediction import predicted

BEFORE = 0.5
INERTIA = np.array([20.0, 25.0, 30.0])  # kg·m²


def driven(rate: float, before: float = 0.0) -> Telemetry:
    """One second of samples under a torque that telemetry knows from some time before the gyro's first."""
    actuators = np.arange(-before, 1.0 + 0.5 / rate, 1.0 / rate)
    gyro = actuators[actuators >= -1e-9]
    return Telemetry(
        gyro_time=gyro,
        body_rate=np.zeros((len(gyro), 3)),
        gyro_noise=1e-3,
        actuator_time=actuators,
        gimbals=None,
        applied_torque=torque(actuators),
    )


def torque(time: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(9.0 * time), np.cos(7.0 * time), 0.1 * time], axis=-1)


def times(grid: Grid) -> np.ndarray:
    """When the torque of the first run is applied."""
    first = grid.time.shape[1] - grid.applied_torque_B.shape[2]
    return grid.time[0, 0] + grid.step[0] / 2 * np.arange(first, grid.time.shape[1])


def test_a_fast_torque_is_integrated_sample_by_sample():
    assert grid_of([driven(1000.0)]).step[0] == pytest.approx(2e-3)
    assert grid_of([driven(50.0)]).step[0] == pytest.approx(LONGEST_STEP)


def test_steps_are_longer_where_samples_come_slowly():
    steps = [grid_of([driven(rate)]).step[0] for rate in (16.0, 8.0, 6.0, 4.0)]
    assert steps == pytest.approx([1 / 64, 1 / 64, 1 / 48, 1 / 32], rel=0.1)


@pytest.mark.parametrize("instant", [0.4, 0.413, 0.42])
def test_the_longest_steps_still_show_all_of_a_touch(instant):
    grid, impulse = grid_of([driven(4.0)], 1.0 / 32.0), np.array([2e-4, -1e-4, 3e-4])
    grid = replace(grid, applied_torque_B=0.0 * grid.applied_torque_B)
    touch = np.concatenate([[instant], impulse])[None]
    values = Values(
        theta=np.array([[0.2, 0.3, 0.4, 0.0, 0.0, 0.0]]), initial_rate=np.zeros((1, 1, 3)), effects=(touch,)
    )
    (last,) = node_rates(grid, [Contact().hooks("platform")], values)[0, :, -1]
    np.testing.assert_allclose(last * [0.2, 0.3, 0.4], impulse, rtol=2e-3)


def test_runs_begin_with_what_all_of_them_know_of_the_torque():
    grid = grid_of([driven(200.0, BEFORE), driven(200.0, 2 * BEFORE)])
    assert times(grid)[0] == pytest.approx(-BEFORE, abs=grid.step[0])
    np.testing.assert_allclose(grid.applied_torque_B[0, 0], torque(times(grid)), atol=1e-5)
    assert grid_of([driven(200.0), driven(200.0, BEFORE)]).applied_torque_B.shape[2] == grid.time.shape[1]


@pytest.mark.parametrize("delay", [0.0, 0.013, 0.1])
def test_late_actuators_respond_to_what_was_asked_before_the_first_sample(delay):
    lag, frequency = 0.03, 9.0
    grid = grid_of([driven(200.0, BEFORE)])
    lagging = ActuatorLag().hooks("actuators").actuator_response(grid.applied_torque_B, np.array([[lag]]), grid)
    late = ActuatorDelay().hooks("actuators").actuator_response(lagging, np.array([[delay]]), grid)
    seen = slice(-grid.time.shape[1], None)
    phase = frequency * (times(grid)[seen] - delay) - np.arctan(frequency * lag)
    expected = np.sin(phase) / np.hypot(1.0, frequency * lag)
    np.testing.assert_allclose(late[0, 0, seen, 0], expected, atol=1e-5)


def held(offset: float, seed: int) -> tuple[Telemetry, np.ndarray]:
    """Ten seconds under torques that are held for 0.1 s, and the exact rates at the gyro's samples, rad/s."""
    every, torques = 0.1, np.random.default_rng(seed).choice([-0.5, 0.0, 0.5], (100, 3))
    times, rates, rate = [], [], np.array([0.02, -0.03, 0.01])
    for number, each in enumerate(torques):
        inside = number * every + np.sort(np.append(np.arange(0.0, every - 1e-6, 0.05) + offset, every))
        turned = solve_ivp(
            lambda _, now, each=each: (each - np.cross(now, INERTIA * now)) / INERTIA,
            (number * every, inside[-1]),
            rate,
            t_eval=inside,
            rtol=1e-11,
            atol=1e-13,
        )
        rate = turned.y[:, -1]
        times.append(inside[:-1])
        rates.append(turned.y[:, :-1].T)
    run = Telemetry(
        gyro_time=np.concatenate(times),
        body_rate=np.concatenate(rates),
        gyro_noise=1e-4,
        actuator_time=every * (np.arange(100) + 0.5),
        gimbals=None,
        applied_torque=torques,
        torque_held=True,
    )
    return run, run.body_rate


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("offset", "within"), [(0.0, 1e-7), (0.013, 3e-5)])
def test_torques_that_are_held_turn_the_body_as_they_do(offset, within, seed):
    """Jumps of up to 0.05 rad/s²: exact where the gyro samples with them; otherwise it sees rounded corners."""
    run, _ = held(offset, seed)
    grid = grid_of([run])
    (shown,) = grid.runs
    theta = np.array([[*INERTIA, 0.0, 0.0, 0.0]])
    values = Values(theta=theta, initial_rate=shown.body_rate[None, :1], effects=())
    (found,) = predicted(grid, [], values)
    assert np.abs(found[0] - shown.body_rate).max() < within
