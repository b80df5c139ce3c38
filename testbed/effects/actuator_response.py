"""A torque that actuators apply behind a lag and a delay, run by run.

Behind a lag it builds up from nothing where the telemetry begins with the run, as at a release. Behind a delay nobody
knows what was asked before: it is taken to be what was asked first.
"""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.prediction.grid import Grid
from testbed.prediction.smooth import Smooth, decay


def late_torque(asked_B: Array, grid: Grid, time_constant: Array, delay: Array) -> Array:
    """Return the torque that acts, shape (R, P, T, 3), N·m.

    Args:
        asked_B: what is asked for, at every half step, shape (R, P, T, 3), N·m.
        grid: the runs.
        time_constant: of a first-order lag, shape (P,), s.
        delay: shape (P,), s.
    """
    sets = max(asked_B.shape[1], len(time_constant), len(delay))
    runs, _, times, _ = asked_B.shape
    asked = np.broadcast_to(asked_B, (runs, sets, times, 3)).reshape(-1, times, 3)
    half_steps = (grid.step / 2.0)[:, None]
    behind = [np.ravel(np.broadcast_to(each, sets) / half_steps) for each in (time_constant, delay)]
    at = np.arange(float(times))
    late = Smooth(at, asked).at(at, *behind)
    if times == grid.time.shape[1]:
        lag = behind[0][:, None]
        late = late - asked[:, :1] * np.where(lag.real > 0.0, decay(at[None], lag), 0.0)[..., None]
    return np.asarray(late.reshape(runs, sets, times, 3))
