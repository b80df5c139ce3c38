"""What actuators do behind a lag and a delay, run by run: a torque that they apply, or a momentum that they hold.

Behind a lag a torque builds up from nothing where the telemetry begins with the run, as at a release, and a momentum
has settled on what was asked first. Behind a delay nobody knows what was asked before: it is taken to be what was
asked first.
"""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Indices
from testbed.estimation.recursions import accumulated
from testbed.prediction.grid import Grid
from testbed.prediction.smooth import Smooth, decay


def late_torque(asked_B: Array, grid: Grid, time_constant: Array, delay: Array) -> Array:
    """Return the torque that acts, shape (R, P, T, 3), N·m.

    Args:
        asked_B: what is asked for, at every half step, shape (R, P, T, 3), N·m.
        grid: the runs.
        time_constant: of a first-order lag, shape (P,), s.
        delay: shape (P,), s; none of torques that are held, which shift the whole motion (`held_torque_delay`).
    """
    sets = max(asked_B.shape[1], len(time_constant), len(delay))
    which, place = _distinct(asked_B, [np.broadcast_to(each, sets) for each in (time_constant, delay)])
    asked_B = asked_B if asked_B.shape[1] == 1 else asked_B[:, which]
    behind = [np.broadcast_to(each, sets)[which] for each in (time_constant, delay)]
    asked, (lag, late_by) = _side_by_side(asked_B, grid, *behind)
    released = asked_B.shape[2] == grid.time.shape[1]
    if grid.torque_held:
        late = _held_behind_lag(asked, lag, released=released)
    else:
        at = np.arange(float(asked_B.shape[2]))
        late = Smooth(at, asked).at(at, lag, late_by)
        if released:
            begun = np.where(lag.real[:, None] > 0.0, decay(at[None], lag[:, None]), 0.0)
            late = late - asked[:, :1] * begun[..., None]
    return np.asarray(late.reshape(len(asked_B), -1, *asked_B.shape[2:])[:, place])


def _held_behind_lag(asked: Array, lag: Array, *, released: bool) -> Array:
    """Return what a lag makes of a torque that is held over each step, shape (B, T, W), exactly.

    A spline through its jumps had a low-pass of the gyro, which is the same, explain χ² 47 more. At nodes torques stand
    for their sides' mean; what stands between two gives the step its impulse, as in `held.along_steps`.

    Args:
        asked: at every half step, the last a node, shape (B, T, W).
        lag: shape (B,), half steps.
        released: whether it builds up from nothing; otherwise it has settled on what is asked first.
    """
    begin = (asked.shape[1] - 1) % 2
    nodes = asked[:, begin::2]
    held = (nodes[:, :-1] + 4.0 * asked[:, begin + 1 :: 2] + nodes[:, 1:]) / 6.0
    first, lag = held[:, :1] * (0.0 if released else 1.0), lag[:, None, None]
    left = decay(np.full(lag.shape, 2.0), lag)
    given = accumulated(left, np.concatenate([first, (1.0 - left) * held], axis=1))
    mean = held - 0.5 * lag * np.diff(given, axis=1)
    late = np.empty(asked.shape, dtype=given.dtype)
    late[:, begin::2] = nodes + given - np.concatenate([first, held], axis=1)
    late[:, begin + 1 :: 2] = (6.0 * mean - late[:, begin:-1:2] - late[:, begin + 2 :: 2]) / 4.0
    late[:, :begin] = asked[:, :begin]
    return late


def _distinct(asked_B: Array, times: list[Array]) -> tuple[Indices, Indices]:
    """Return which parameter sets differ in what is late or by how much, and which of these each set is.

    Most sets are a step in a parameter that changes neither, and splines cost more than all else.

    Args:
        asked_B: shape (R, P or 1, T, 3).
        times: each of shape (P,), s.
    """
    by_set = np.moveaxis(asked_B, 1, 0)
    same = np.array([np.array_equal(each, by_set[0]) for each in by_set])
    kind = np.where(same, -1, np.arange(len(same)))
    rows = np.stack([np.broadcast_to(kind, len(times[0])).astype(complex), *times], axis=1)
    _, which, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return which, place.ravel()


def late_momentum(asked_B: Array, grid: Grid, time_constant: Array, delay: Array) -> Array:
    """Return the momentum that actuators hold which is recorded as asked for, shape (R, P, T, 3), N·m·s.

    As it is where the gimbal angles are known: encoders show what the actuators did.

    Args:
        asked_B: what is recorded, at every half step, shape (R, P, T, 3), N·m·s.
        grid: the runs.
        time_constant: of a first-order lag, shape (P,), s.
        delay: shape (P,), s.
    """
    if grid.gimbals is not None or not asked_B.any():  # what holds no momentum has none later
        return asked_B
    every, (lag, late_by) = _side_by_side(asked_B, grid, time_constant, delay)
    at = np.arange(float(asked_B.shape[2]))
    late = Smooth(at, every).at(at, lag, late_by)
    return np.asarray(late.reshape(len(asked_B), -1, *asked_B.shape[2:]))


def skewed(values: Array, grid: Grid, late: Array) -> Array:
    """Return what was so along the grid of what is recorded late, shape (R, P, T, W).

    What lies beyond the record goes on as its first and last pieces do, for as long as between two samples, and then in
    a straight line. A line from the first sample on missed 7 sigma of early telemetry, which a late gyro explained.

    Args:
        values: as recorded, at every half step, shape (R, P, T, W).
        grid: the runs.
        late: by which they are recorded late, shape (P,), s; negative where early.
    """
    sets = max(values.shape[1], len(late))
    which, place_of = _distinct(values, [np.broadcast_to(late, sets)])
    values = values if values.shape[1] == 1 else values[:, which]
    every, (ahead,) = _side_by_side(values, grid, np.broadcast_to(late, sets)[which])
    last = float(values.shape[2] - 1)
    at = np.arange(last + 1.0)
    place = at + ahead[:, None]
    reach = np.repeat(grid.actuator_interval / (grid.step / 2.0), len(every) // len(grid.runs))[:, None]
    before = np.where(place.real < -reach, place + reach, 0.0)
    behind = np.where(place.real > last + reach, place - last - reach, 0.0)
    inside = Smooth(at, every).between(place - before - behind)
    begin, end = every[:, 1:2] - every[:, :1], every[:, -1:] - every[:, -2:-1]
    whole = inside + before[..., None] * begin + behind[..., None] * end
    return np.asarray(whole.reshape(len(values), -1, *values.shape[2:])[:, place_of])


def _side_by_side(values: Array, grid: Grid, *times: Array) -> tuple[Array, list[Array]]:
    """Return values of all runs and parameter sets, shape (R P, T, W), and times in half steps, shape (R P,)."""
    runs, present, length, width = values.shape
    sets = max(present, *map(len, times))
    half_steps = (grid.step / 2.0)[:, None]
    every = np.broadcast_to(values, (runs, sets, length, width)).reshape(-1, length, width)
    return every, [np.ravel(np.broadcast_to(each, sets) / half_steps) for each in times]
