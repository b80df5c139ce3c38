"""A torque that actuators apply behind a lag and a delay, run by run."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.prediction.grid import Grid
from testbed.prediction.smooth import Smooth


def late_torque(torque_B: Array, grid: Grid, time_constant: Array, delay: Array) -> Array:
    """Return the torque that acts, shape (R, P, T, 3), N·m.

    Args:
        torque_B: what is asked for, shape (R, P, T, 3), N·m.
        grid: the runs.
        time_constant: of a first-order lag, shape (P,), s.
        delay: shape (P,), s.
    """
    sets = max(torque_B.shape[1], len(time_constant), len(delay))
    asked = np.broadcast_to(torque_B, (len(torque_B), sets, *torque_B.shape[2:]))
    behind = [np.broadcast_to(each, sets) for each in (time_constant, delay)]
    return np.stack([Smooth(at, run).at(at, *behind) for at, run in zip(grid.time, asked, strict=True)])
