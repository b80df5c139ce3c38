"""How the gimbals' angles should have responded to their commands, in the directions that hold no load."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import block_diag

from testbed.arrays import Array, Flags
from testbed.cmg.cluster import transverse_axes
from testbed.estimation.gaps import between_gaps
from testbed.estimation.telemetry import CommandedRun
from testbed.prediction.compared import compared, long_gaps
from testbed.prediction.grid import Gimbals, Grid, at_nodes, unit_count
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import effective_gimbals
from testbed.prediction.jumps import beside, jumps
from testbed.prediction.servo import response, set_point, shown_at, ticks_of
from testbed.prediction.smoothed import body_motion, gimbal_motion
from testbed.prediction.unit_axes import along_units

_COMPARED = 0.1
"""s. Time constant of the high-pass behind which angles are compared: slower differences are the plan's, not known."""
_SLOWEST = 0.15
"""s between samples from which on responses are not compared: half as much again as that time constant, so that only
what splines through the commands miss would be.

Source: measured, on five healthy flights of the shipped parabola: at 8 Hz no name, at 5.3 Hz a late gimbal."""
_AT_LIMIT = 0.98
"""Share of the rate limit from which on a set point may be cut: 0.04 rad/s is what 1.5 mrad of an angle add to it."""
_SETTLED = 0.4
"""s. Until a servo that was not followed responds as if it had been, but for a constant: its poles are at 25 1/s."""
_FEWEST = 6
"""Samples in a row that are worth comparing: constants alone take up as much as two. With 12, responses are the same
and estimates move by 0.03 standard errors (three sets of seed 90817)."""
_SEEN = 1e-2
"""Norm with which a constant of 1 rad has to show to be seen at all: 1e-3 rad then make 1e-5 rad, a tenth of a good
encoder's noise. With 0.1, estimates move by 0.2 standard errors (three sets of seed 90817)."""
_LOADED = 3
"""Directions of gimbal angles that a body rate loads; what the units can do beyond them is compared."""
_REMEMBERED = 64
"""Runs whose directions, stretches and constants are kept, as many as in `motor_torques`; a miss costs time only."""


def has_commands(grid: Grid) -> bool:
    """Return whether the runs carry the commanded gimbal rates often enough, and units can turn without load."""
    often = all(np.median(np.diff(run.actuator_time)) < _SLOWEST for run in grid.runs)
    return often and unit_count(grid) > _LOADED and len(grid.commanded_runs) == len(grid.runs)


def measured_responses(grid: Grid) -> list[Array]:
    """Return what is compared of the gimbal angles of every run, each of shape (K, M - 3), rad."""
    return [shown(run, np.unwrap(run.gimbals.angle, axis=0)) for run in grid.commanded_runs]


def servo_responses(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> list[Array]:
    """Return what is compared of the predicted responses to the commands in every run, each (P, K, M - 3), rad.

    Args:
        grid: the runs; they carry commands.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, Q).
    """
    pairs = list(zip(hooks, effects, strict=True))
    sets = max([1, *(len(value) for value in effects)])
    gimbals = effective_gimbals(grid, hooks, effects)
    responses = []
    for index, run in enumerate(grid.commanded_runs):
        rate = ticks_of(run).gimbal_rate
        friction, lag = np.zeros((1, 1, rate.shape[1])), np.zeros((sets, rate.shape[1]))
        for hook, value in pairs:
            friction = hook.motor_torque(friction, value, rate[None])
            lag = lag + hook.servo_lag(value, rate.shape[1])
        against = (friction - _further_load(grid, gimbals, index)) / run.gimbals.cluster.gimbal_axis_inertia
        responses.append(shown(run, response(run, lag, np.broadcast_to(against, (sets, *rate.shape)))))
    return responses


def shown(run: CommandedRun, angle: Array) -> Array:
    """Return what is compared of gimbal angles, shape (..., K, M - 3), rad: in the directions that hold no load.

    The servo is fed forward the load at a body rate that was planned and is not sent; what it misses by that lies in
    the three directions that a body rate loads. Constants count for nothing: the rates that were sent say how the angle
    changes that is asked for, and not where it began. With the encoder's first reading its noise would stay for the
    whole run, and an encoder that is off its zero begins beside the plan.

    Args:
        run: its gimbals.
        angle: at its samples, shape (..., K', M), rad.
    """
    changes, constant = _unloaded_changes(run, angle), constants(run)
    flat = changes.reshape(*changes.shape[:-2], -1)
    return np.asarray((flat - np.matvec(constant, flat @ constant)).reshape(changes.shape))


@lru_cache(maxsize=_REMEMBERED)
def constants(run: CommandedRun) -> Array:
    """Return how constant angles show as the directions without load turn, an orthonormal basis of shape (3 K, Q).

    Every stretch has constants of its own: what was asked for while nobody knew the set point stays as an angle.
    """
    units = unloaded(run).shape[1]
    held = np.repeat(np.eye(units)[:, None], len(run.actuator_time), axis=1)
    blocks = []
    for part in by_stretches(run, _unloaded_changes(run, held).transpose(1, 2, 0)):
        basis, sizes, _ = np.linalg.svd(part.reshape(-1, units), full_matrices=False)
        blocks.append(basis[:, sizes > _SEEN])
    return np.asarray(block_diag(*blocks))


def _unloaded_changes(run: CommandedRun, angle: Array) -> Array:
    """Return the high-passed angles in the directions without load, stretch by stretch, (..., K, M - 3)."""
    free = unloaded(run)
    beside = np.matvec(free, np.matvec(np.swapaxes(free, -1, -2), angle))
    forgotten = np.exp(-float(np.median(np.diff(run.actuator_time))) / _COMPARED)
    parts = [beside[..., :0, : free.shape[-1]]]
    for part in stretches(run):
        changes = np.diff(beside[..., part, :], axis=-2, prepend=beside[..., part, :][..., :1, :])
        passed = scipy.signal.lfilter([1.0], [1.0, -forgotten], changes, axis=-2)
        parts.append(np.matvec(np.swapaxes(free[part], -1, -2), passed))
    return np.concatenate(parts, axis=-2)


def by_units(run: CommandedRun, values: Array) -> Array:
    """Return compared values, shape (K, M - 3), as the gimbal angles that they stand for, shape (K, M), rad."""
    return np.asarray(np.einsum("kui,ki->ku", unloaded(run)[followed(run)], values))


def by_stretches(run: CommandedRun, values: Array) -> list[Array]:
    """Return values at the compared samples, shape (K, ...), split into stretches of consecutive samples."""
    return np.split(values, np.cumsum([len(part) for part in stretches(run)])[:-1])


@lru_cache(maxsize=_REMEMBERED)
def unloaded(run: CommandedRun) -> Array:
    """Return the directions of gimbal angles that the load by a body rate does not change, shape (K', M, M - 3).

    The servo responds to a load as late as ω_b / ω_n²: the directions are those of the angles then.
    """
    cluster, servo = run.gimbals.cluster, run.gimbals.servo
    before = run.actuator_time - servo.bandwidth / servo.stiffness
    loaded = transverse_axes(cluster, gimbal_motion(run)(np.maximum(before, run.actuator_time[0])))
    return np.asarray(np.linalg.qr(loaded, mode="complete")[0][..., 3:])


def followed(run: CommandedRun) -> NDArray[np.intp]:
    """Return the indices of the samples at which the responses are compared, shape (K,)."""
    return np.concatenate([np.zeros(0, dtype=np.intp), *stretches(run)])


@lru_cache(maxsize=_REMEMBERED)
def stretches(run: CommandedRun) -> list[NDArray[np.intp]]:
    """Return the indices of the compared samples, an array for each stretch of consecutive ones.

    The set point is unknown while it, or a command, is clipped between samples, in a gap, and where commands jump: a
    maneuver that ends while gimbals turn. The error of the angle that follows has decayed to a constant after
    `_SETTLED`.
    """
    time = ticks_of(run).time
    rates = np.hstack([set_point(run), ticks_of(run).command])
    cut = time[(np.abs(rates) > _AT_LIMIT * run.gimbals.servo.rate_limit).any(axis=1)]
    unknown = np.sort(np.concatenate([[-np.inf], cut, run.actuator_time[1:][_uncommanded(run)]]))
    last = unknown[np.searchsorted(unknown, run.actuator_time, side="right") - 1]
    kept = np.flatnonzero(compared(run) & (run.actuator_time - last > _SETTLED))
    parts = np.split(kept, np.flatnonzero(np.diff(kept) > 1) + 1)
    return [part for part in parts if len(part) >= _FEWEST]


def _uncommanded(run: CommandedRun) -> Flags:
    """Return between which samples the commands are not known, shape (K' - 1,): in a long gap, and beside a jump."""
    unknown = long_gaps(run)
    for rows in between_gaps(unknown):
        unknown[rows.start : rows.stop - 1] = beside(jumps(run.actuator_time[rows], run.gimbals.rate_command[rows]))
    return unknown


def _further_load(grid: Grid, gimbals: Gimbals | None, index: int) -> Array | float:
    """Return the load of units as they are less that of telemetry, at a run's ticks, shape (P, N, M), N·m."""
    if gimbals is grid.gimbals or gimbals is None or grid.gimbals is None:
        return 0.0
    time, run = grid.node_time[index], grid.commanded_runs[index]
    body_rate = body_motion(run)(time)
    further = _load(gimbals, body_rate, index) - _load(grid.gimbals, body_rate, index)
    at = np.clip(shown_at(run, ticks_of(run).time), time[0], time[-1])
    return np.asarray(CubicSpline(time, further, axis=1)(at))


def _load(gimbals: Gimbals, body_rate: Array, run: int) -> Array:
    """Return Js Ω ω·t of a run's gimbals at the nodes, shape (P, N + 1, M), N·m."""
    return np.asarray(at_nodes(gimbals.rotor_momentum, run) * along_units(gimbals, body_rate, run)[1])
