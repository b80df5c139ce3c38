"""Torques by formulas in the prediction: the expressions that are flown, along the predicted motion."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array, Series
from testbed.formulas.motion import Moment
from testbed.formulas.pattern import Pattern
from testbed.prediction.grid import Grid, begin_of_runs
from testbed.prediction.hooks import Hooks, Instant


def formula_hooks(pattern: Pattern) -> Hooks:
    """Return how a torque by formulas enters the prediction."""
    return _AlongMotion(pattern) if pattern.follows_motion or pattern.states else _AlongTime(pattern)


class _OfFormula(Hooks):
    """What both kinds share."""

    def __init__(self, pattern: Pattern) -> None:
        self._pattern = pattern


@final
class _AlongTime(_OfFormula):
    """A torque that time and the gimbals alone decide: it is known along the grid, as that of actuators is."""

    @override
    def applied_torque(self, torque_B: Array, value: Array, grid: Grid) -> Array:
        whole = value[:, None]  # (P, 1, K), against (R, P, T)
        at = _along_grid(grid)
        torque = sum(
            law.value(at, np.zeros(0), self._pattern.constants(whole))[..., None] * sizes
            for law, sizes in zip(
                self._pattern.laws, np.moveaxis(self._pattern.coefficients(whole), -2, 0), strict=True
            )
        )
        return np.asarray(torque_B + torque)


@final
class _AlongMotion(_OfFormula):
    """A torque that the motion decides, or that has a memory."""

    def __init__(self, pattern: Pattern) -> None:
        super().__init__(pattern)
        self._grid: Grid | None = None
        self.states = pattern.states
        self.needs_attitude = pattern.reads_attitude

    @override
    def applied_torque(self, torque_B: Array, value: Array, grid: Grid) -> Array:
        """Only the grid is taken here, on which time and the gimbals stand by its instants."""
        self._grid = grid
        return torque_B

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        return self._pattern.torque(value, self._moment(at), at.state)

    @override
    def initial_state(self, value: Array, body_rate: Array) -> Array:
        first = np.zeros((len(body_rate), 1))
        return self._pattern.first_state(value, self._read(first, body_rate, np.eye(3), np.zeros(len(body_rate), int)))

    @override
    def state_rate(self, value: Array, at: Instant) -> Array:
        return self._pattern.state_rate(value, self._moment(at), at.state)

    def _moment(self, at: Instant) -> Moment:
        assert self._grid is not None
        start = np.repeat(self._grid.time[:, 0], len(at.time) // len(self._grid.runs))[:, None]
        half_step = np.repeat(0.5 * self._grid.step, len(at.time) // len(self._grid.runs))[:, None]
        places = np.rint((at.time - start) / half_step).astype(int)[:, 0]
        return self._read(at.time - start, at.body_rate, at.attitude, places)

    def _read(self, time: Array, body_rate: Array, attitude: Array, places: Array) -> Moment:
        """Return what formulas read at instants of the grid, those of one run after those of the other."""
        assert self._grid is not None
        run = np.repeat(np.arange(len(self._grid.runs)), len(places) // len(self._grid.runs))
        at = Moment(
            time=time,
            body_rate=body_rate,
            attitude=attitude,
            elapsed=time + laid_end_to_end(self._grid)[run][:, None],
            applied_torque=applied_torque(self._grid)[run, :, places],
        )
        gimbals = self._grid.gimbals
        if gimbals is None:
            return at
        return replace(at, gimbal_angle=gimbals.angle[run, :, places], gimbal_rate=gimbals.rate[run, :, places])


def _along_grid(grid: Grid) -> Moment:
    """Return time and actuators along the grid, shapes (R, 1, T) and (R, 1, T, M or 3); the motion is not known."""
    time, unknown = (grid.time - grid.time[:, :1])[:, None], np.zeros((1, 1, 1, 3))
    elapsed = time + laid_end_to_end(grid)[:, None, None]
    at = Moment(time=time, body_rate=unknown, elapsed=elapsed, applied_torque=applied_torque(grid))
    if grid.gimbals is None:
        return at
    return replace(at, gimbal_angle=grid.gimbals.angle, gimbal_rate=grid.gimbals.rate)


def laid_end_to_end(grid: Grid) -> Series:
    """Return how long after the first run each one begins, shape (R,), s, the runs laid end to end."""
    return np.asarray(begin_of_runs(grid) + grid.time[:, 0])


def applied_torque(grid: Grid) -> Array:
    """Return the torque of actuators that store no momentum along the grid, shape (R, 1, T, 3), N·m, body axes."""
    return grid.applied_torque_B[:, :, -grid.time.shape[1] :]
