"""A torque that actuators apply behind a lag or a delay, run by run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from testbed.arrays import Array
from testbed.prediction.grid import Grid
from testbed.prediction.smooth import Smooth


def behind(torque_B: Array, value: Array, grid: Grid, response: Callable[[Smooth, Array, Array], Array]) -> Array:
    """Return the torque of every run as a response lets it through, shape (R, P, T, 3), N·m.

    Args:
        torque_B: what is asked for, shape (R, P, T, 3), N·m.
        value: the response's parameter, shape (P,).
        grid: the runs.
        response: from the smooth torque of a run, its times and the parameter to the torque that acts, shape (P, T, 3).
    """
    sets = max(torque_B.shape[1], len(value))
    asked = np.broadcast_to(torque_B, (len(torque_B), sets, *torque_B.shape[2:]))
    parameter = np.broadcast_to(value, sets)
    return np.stack([response(Smooth(at, run), at, parameter) for at, run in zip(grid.time, asked, strict=True)])
