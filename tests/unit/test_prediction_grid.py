"""The integration's grid: fine enough for the torque that is applied, with what was applied before the first sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from testbed.effects.actuator_delay import ActuatorDelay
from testbed.effects.actuator_lag import ActuatorLag
from testbed.effects.contact import Contact
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import LONGEST_STEP, Grid, grid_of
from testbed.prediction.integration import Values, node_rates

BEFORE = 0.5


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
