"""What the gyro should have read: the motion low-passed, delayed, and sampled at the gyro's own times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Array
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.smooth import Smooth


def readings(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array], rates: Array) -> list[Array]:
    """Return the predicted gyro samples of every run, each of shape (P, N, 3), rad/s.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, K).
        rates: ω at the grid's nodes, shape (R, P, M + 1, 3).
    """
    pairs = list(zip(hooks, effects, strict=True))
    lag = sum((hook.gyro_time_constant(value) for hook, value in pairs), np.zeros(1))
    delay = sum((hook.gyro_delay(value) for hook, value in pairs), np.zeros(1))
    behind = [np.broadcast_to(each, rates.shape[1]) for each in (lag, delay)]
    predicted = []
    for run, telemetry in enumerate(grid.runs):
        reading = Smooth(grid.node_time[run], rates[run]).at(telemetry.gyro_time, *behind)
        for hook, value in pairs:
            reading = hook.gyro_reading(reading, value, telemetry.gyro_time, run)
        predicted.append(reading)
    return predicted
