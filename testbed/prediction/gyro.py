"""What the gyro should have read: the motion low-passed, delayed, and sampled at the gyro's own times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Vectors3
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, overrides
from testbed.prediction.lines import lines_of
from testbed.prediction.smooth import Motion, Smooth, Sum, node_slopes

_PLACES, _WEIGHTS = 0.5 + 0.5 * np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0]), np.array([5.0, 8.0, 5.0]) / 18.0
"""Of Gauss's rule on the unit interval."""


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
    if grid.torque_held:
        delay = delay + sum((hook.held_torque_delay(value) for hook, value in pairs), np.zeros(1))
    if grid.momentum_held:
        delay = delay - sum((hook.telemetry_lateness(value) for hook, value in pairs), np.zeros(1))
    drift = sum((hook.gyro_clock_drift(value) for hook, value in pairs), np.zeros(1))
    averaging = [hook.gyro_averaging(value) for hook, value in pairs if overrides(hook, "gyro_averaging")]
    either_way = _read(grid, rates, lag, delay, drift, averaging)
    known = np.array([run.gyro_time[0] - run.actuator_time[0] for run in grid.runs]) > _LOST * grid.gyro_interval
    read = either_way[0]
    if known.any():
        read = np.where(known[:, None, None, None], either_way[-1], read)
    held = _behind_effects(grid, pairs, read)
    if len(either_way) == 1 or known.all() or not any(np.any(each) for each in (lag, delay, *averaging)):
        return held
    moving = _behind_effects(grid, pairs, either_way[-1])
    return [_nearer(*each) for each in zip(held, moving, grid.runs, strict=True)]


def _behind_effects(grid: Grid, pairs: Sequence[tuple[Hooks, Array]], read: Array) -> list[Array]:
    """Return what effects on readings make of them, of each run, shape (P, N, 3)."""
    predicted = []
    for run, telemetry in enumerate(grid.runs):
        reading = read[run, :, : len(telemetry.gyro_time)]
        for hook, value in pairs:
            reading = hook.gyro_reading(reading, value, telemetry.gyro_time, int(grid.number[run]))
        predicted.append(reading)
    return predicted


_LOST = 3
"""Samples that a record may have lost at its start: if the actuators' telemetry begins earlier than by these, the run
begins in the middle of a motion, as a window does, and what its actuators did before is known.

Source: chosen: spikes at a start take one or two; a window has its whole length before it."""


def _nearer(held: Array, moving: Array, run: Telemetry) -> Array:
    """Return what is nearer to a run's samples, of what they are after a release and in the middle of a motion.

    No channel says which it was before its first sample, and a slow gyro shows it: a satellite whose log begins at any
    instant has been turning as it goes on, one that is released had turned at one rate until then.

    Args:
        held: what the gyro reads of a run that was released, shape (P, N, 3).
        moving: of one that was turning, alike.
        run: its samples.
    """
    apart = held.real != moving.real
    if not apart.any():
        return held
    left = [np.where(apart, each.real - run.body_rate, 0.0) for each in (held, moving)]
    squares = [np.einsum("pni,pni->p", each, each) for each in left]
    return np.where((squares[1] < squares[0])[:, None, None], moving, held)


def _read(grid: Grid, rates: Array, lag: Array, delay: Array, drift: Array, averaging: Sequence[Array]) -> Array:
    """Return what a gyro reads behind a lag and a delay, shape (2, R, P, N, 3), rad/s, N of the run with most samples.

    Of runs that were released at their first node, and of runs that had been turning as they go on; once where nothing
    of that shows. All runs side by side, in units of their steps; those with fewer samples have their last one again.

    Args:
        grid: the runs.
        rates: ω at the grid's nodes, shape (R, P, M + 1, 3).
        lag: shape (P,) or (1,), s.
        delay: alike.
        drift: share of the time by which samples are later still, shape (P,) or (1,).
        averaging: shares of the sampling interval over which is averaged, shapes (P,) or (1,); their sum counts.
    """
    runs, sets, nodes, _ = rates.shape
    times = grid.sample_time
    at = np.repeat((times - grid.node_time[:, :1]) / grid.step[:, None], sets, axis=0)
    if np.any(drift):
        at = at - (times[:, None] * np.broadcast_to(drift, sets)[:, None] / grid.step[:, None, None]).reshape(at.shape)
    late, behind = ((np.broadcast_to(each, sets) / grid.step[:, None]).ravel() for each in (lag, delay))
    motion = _motion(grid, rates.reshape(-1, nodes, 3), sets)
    shown = partial(motion.either_way, at, late)
    if averaging:
        interval = grid.gyro_interval / grid.step
        window = (sum(averaging, np.zeros(sets)) * interval[:, None]).ravel()
        read = _averaged(lambda earlier: shown(behind + earlier), window)
    else:
        read = shown(behind)
    return np.asarray(read.reshape(-1, runs, sets, times.shape[1], 3))


def _motion(grid: Grid, rates: Array, sets: int) -> Motion:
    """Return the motions of all runs through rates at the nodes, shape (R P, M + 1, 3), times in steps of each run.

    Where a torque is held, their difference from the lines of a body under it is smooth.
    """
    nodes = np.arange(float(rates.shape[1]))
    lines = lines_of(grid, sets)
    if lines is None:
        return Smooth(nodes, rates, node_slopes(rates, 1.0))
    rest = rates - lines.between(np.broadcast_to(nodes, rates.shape[:2]))
    return Sum(Smooth(nodes, rest, node_slopes(rest, 1.0)), lines)


def _averaged(shown: Callable[[Array], Array], window: Array) -> Array:
    """Return the means of what is shown over windows that end now, of its shape.

    By Gauss's rule of three points, which is exact for a motion that is a quintic over the window.

    Args:
        shown: from how much earlier each set's motion is looked at, shape (P,), to it, shape (2 or 1, P, N, 3).
        window: shape (P,), alike.
    """
    parts = zip(_PLACES, _WEIGHTS, strict=True)
    return np.asarray(sum(weight * shown(place * window) for place, weight in parts))


def gyro_errors(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array], rates: Array) -> list[Vectors3]:
    """Return by how much each run's gyro is off from ω, each of shape (N, 3), rad/s.

    By the effects in it, and where the actuators' telemetry is late: their sample of t goes with ω(t - s). Where
    momenta are held, nodes are on the clock of the telemetry.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        effects: their parameters, one set of them.
        rates: ω at the grid's nodes, shape (R, 1, M + 1, 3).
    """
    late = 0.0 if grid.momentum_held else lateness(hooks, effects)
    each = zip(readings(grid, hooks, effects, rates), grid.runs, grid.node_time, rates[:, 0], strict=True)
    return [
        read[0] - CubicSpline(time, moved)(np.clip(run.gyro_time - late, time[0], time[-1]))
        for read, run, time, moved in each
    ]


def lateness(hooks: Sequence[Hooks], effects: Sequence[Array]) -> float:
    """Return by how much the actuators' telemetry is late by the gyro's clock, s; arguments as `gyro_errors`."""
    return sum((float(hook.telemetry_lateness(value)[0]) for hook, value in zip(hooks, effects, strict=True)), 0.0)


def acts_in_gyro(hook: Hooks) -> bool:
    """Return whether an effect changes what the gyro makes of ω."""
    return overrides(hook, "gyro_time_constant", "gyro_delay", "gyro_clock_drift", "gyro_averaging", "gyro_reading")


def reads_otherwise(hook: Hooks) -> bool:
    """Return whether with an effect the gyro reads something else than the rate of the instant that it is of."""
    return overrides(hook, "gyro_reading")


def acts_on_clocks(hook: Hooks) -> bool:
    """Return whether with an effect the actuators' telemetry is on another clock than the gyro's."""
    return overrides(hook, "telemetry_lateness")
