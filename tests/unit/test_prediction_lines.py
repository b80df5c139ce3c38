"""What bends where a held torque jumps is read between nodes as it is, also behind a low-pass."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typing_extensions import override

from testbed.prediction.grid import grid_of
from testbed.prediction.gyro import readings
from testbed.prediction.hooks import Hooks
from testbed.prediction.lines import lines_of
from tests.unit import test_diagnosis_torque_driven as torque_driven

_COUNTS = (40, 60)
"""Periods of the runs; the second one's gyro comes between the jumps."""


class _Late(Hooks):
    @override
    def gyro_delay(self, value):
        return value[:, 0]


@pytest.fixture(scope="module")
def grid():
    flown = torque_driven.TestHeldTorque()
    records = [flown.held(seed, count=count) for seed, count in enumerate(_COUNTS)]
    three = [*records, flown.held(9)]
    runs = torque_driven.data_set_of(three, flown.STATED, torque_driven.NOMINAL).runs.grid.runs
    return grid_of(runs)


def in_steps(grid, time):
    """Times of every run in its steps, for two parameter sets each."""
    return np.repeat((time - grid.node_time[:, :1]) / grid.step[:, None], 2, axis=0)


def test_lines_are_those_of_a_body_at_rest_under_the_held_torque(grid):
    time = np.stack([np.linspace(run.gyro_time[0] - 0.02, run.gyro_time[-1] + 0.02, 301) for run in grid.runs])
    lines = lines_of(grid, 2).between(in_steps(grid, time))
    for number, (run, at) in enumerate(zip(grid.runs, time, strict=True)):
        for row in (2 * number, 2 * number + 1):
            np.testing.assert_allclose(lines[row], run.corners(at), atol=1e-14)


def test_behind_a_low_pass_they_follow_its_differential_equation(grid):
    lags = np.array([0.03, 0.2])
    time = np.stack([np.linspace(run.gyro_time[0], run.gyro_time[-1], 97) for run in grid.runs])
    lag = (lags / grid.step[:, None]).ravel()
    shown = lines_of(grid, 2).settled(lag).between(in_steps(grid, time)).reshape(len(grid.runs), 2, -1, 3)
    for number, (run, at) in enumerate(zip(grid.runs, time, strict=True)):
        slope = (run.corners(at[0] + 1e-6) - run.corners(at[0])) / 1e-6
        for index, constant in enumerate(lags):
            solved = solve_ivp(
                lambda now, state, constant=constant, run=run: (run.corners(now) - state) / constant,
                (at[0], at[-1]),
                run.corners(at[0]) - constant * slope,
                t_eval=at,
                rtol=1e-9,
                atol=1e-12,
                max_step=0.004,
            )
            np.testing.assert_allclose(shown[number, index], solved.y.T, atol=2e-7 * np.ptp(run.corners(at)))


def test_a_delay_reads_a_body_under_a_held_torque_exactly(grid):
    """A body with the believed inertia that hardly turns: ω is its lines, wherever between nodes it is read."""

    rates = np.stack([run.corners(time) for run, time in zip(grid.runs, grid.node_time, strict=True)])[:, None]
    for delay in (-0.018, 0.0, 0.007):
        read = readings(grid, [_Late()], [np.array([[delay]])], rates)
        for run, samples in zip(grid.runs, read, strict=True):
            inside = run.gyro_time - delay >= run.gyro_time[0]
            expected = run.corners(run.gyro_time - delay)[inside]
            np.testing.assert_allclose(samples[0][inside], expected, atol=1e-12)
