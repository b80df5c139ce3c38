"""What a torque that is held from sample to sample gives the bodies of several runs: lines that bend where it jumps."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from typing_extensions import override

from testbed.arrays import Array
from testbed.prediction.grid import Grid
from testbed.prediction.integration import GRIDS
from testbed.prediction.kernels import followed
from testbed.prediction.smooth import Motion, decay

_AT_EDGE = 1e-6
"""Steps by which rounding moves a time that is an edge.

Source: chosen: far above what is rounded of 100,000 steps with sixteen digits, 1e-11, and far below what shows."""


def lines_of(grid: Grid, sets: int) -> Lines | None:
    """Return what the torques of runs give bodies of about the platform's inertia, of so many parameter sets each.

    None where no torque is held that bends the motion of every run.
    """
    pieces = _pieces(grid)
    return None if pieces is None else Lines(pieces, sets)


class Lines(Motion):
    """Motions along straight lines from edge to edge, of runs with as many parameter sets each.

    Times are in steps of each run from its first node. Arrays of pieces have those of one run behind another's.
    """

    def __init__(self, pieces: _Pieces, sets: int) -> None:
        """Take the pieces of all runs, and the number of parameter sets."""
        self._pieces, self._sets, self.begin = pieces, sets, 0.0

    @property
    @override
    def first(self) -> Array:
        return self.between(np.zeros((self._pieces.runs * self._sets, 1)))

    @override
    def between(self, time: Array) -> Array:
        piece, since = self._since(time)
        along = self._pieces.values[piece] + since[..., None] * self._slopes(piece, since)
        return np.asarray(along.reshape(*time.shape, -1))

    @override
    def settled(self, time_constant: Array) -> Motion:
        return _Settled(self, time_constant)

    def _slopes(self, piece: NDArray[np.intp], since: Array) -> Array:
        """Return slopes, shape (R, P, N, 3): at an edge the mean of both sides, as its time may step to either."""
        slopes = self._pieces.slopes
        before = np.maximum(piece - 1, self._pieces.begin[:, None, None])
        at_edge = (np.abs(since.real[:, :1] if piece.shape[1] == 1 else since.real) < 2.0 * _AT_EDGE)[..., None]
        return np.where(at_edge, 0.5 * (slopes[before] + slopes[piece]), slopes[piece])

    def _since(self, time: Array) -> tuple[NDArray[np.intp], Array]:
        """Return pieces, shape (R, 1 or P, N), and the time since each began, shape (R, P, N)."""
        pieces = self._pieces
        at = time.reshape(pieces.runs, self._sets, -1)
        real = at.real if (at.real != at.real[:, :1]).any() else at.real[:, :1]  # most sets differ in other things
        beside = (pieces.apart * np.arange(pieces.runs))[:, None, None]
        looked_up = np.clip(real + _AT_EDGE, pieces.earliest, pieces.latest) + beside
        found = np.searchsorted(pieces.beside, looked_up, side="right") - 1
        piece = np.clip(found, pieces.begin[:, None, None], pieces.end[:, None, None])
        return piece, at - pieces.edges[piece]


class _Settled(Motion):
    """Lines behind T ẋ = u - x: behind every edge what was T times the slope before falls to T times the one there."""

    def __init__(self, lines: Lines, time_constant: Array) -> None:
        pieces = lines._pieces
        self._lines, self.begin = lines, lines.begin
        self._lag = time_constant.reshape(pieces.runs, -1)
        lag = self._lag[pieces.run].T  # (P, pieces)
        bend = np.where((pieces.edges > 0.0)[:, None], np.diff(pieces.slopes, axis=0, prepend=pieces.slopes[:1]), 0.0)
        lasted = np.diff(pieces.edges, prepend=pieces.edges[:1])
        kept = np.where(pieces.edges > 0.0, decay(np.maximum(lasted, 0.0), lag), 0.0)
        jumps = lag[..., None] * bend
        self._left = followed(np.zeros_like(jumps[:, 1:]), jumps[:, 1:], kept[:, 1:])

    @property
    @override
    def first(self) -> Array:
        return self.between(np.zeros((self._lag.size, 1)))

    @override
    def between(self, time: Array) -> Array:
        piece, since = self._lines._since(time)
        lag, sets = self._lag[:, :, None], np.arange(self._lag.shape[1])[None, :, None]
        steady = lag[..., None] * self._lines._pieces.slopes[piece]
        fallen = self._left[sets, piece] * decay(np.where(since.real > 0.0, since, 0.0), lag)[..., None]
        return np.asarray(self._lines.between(time) + (fallen - steady).reshape(*time.shape, -1))

    @override
    def settled(self, time_constant: Array) -> Motion:
        raise NotImplementedError  # one low-pass is all that a gyro has


class _Pieces:
    """The pieces of all runs, one run's behind another's; values in rad/s, times in steps of the run.

    Attributes:
        runs: R.
        run: of each piece, shape (pieces,).
        edges: where it begins, shape (pieces,).
        values: there, shape (pieces, 3).
        slopes: from there, alike, a step.
        begin, end: first and last piece of each run, shape (R,).
        earliest, latest: between which all edges lie.
        apart: by which the runs' edges are moved apart to be looked up at once.
        beside: the edges then, shape (pieces,), in order.
    """

    def __init__(self, grid: Grid, corners: Sequence[BSpline]) -> None:
        known = [(each.t[1:-1], np.moveaxis(each.c, each.axis, 0)) for each in corners]
        starts, steps = grid.node_time[:, 0], grid.step
        edges = [(time - start) / step for (time, _), start, step in zip(known, starts, steps, strict=True)]
        slopes = [np.diff(values, axis=0) / np.diff(at)[:, None] for (_, values), at in zip(known, edges, strict=True)]
        counts = np.array([len(each) for each in slopes])
        self.runs = len(counts)
        self.run = np.repeat(np.arange(self.runs), counts)
        self.edges = np.concatenate([at[:-1] for at in edges])
        self.values = np.concatenate([values[:-1] for _, values in known])
        self.slopes = np.concatenate(slopes)
        self.end = np.cumsum(counts) - 1
        self.begin = self.end - counts + 1
        self.earliest, self.latest = self.edges.min() - 1.0, self.edges.max() + 1.0
        self.apart = self.latest - self.earliest + 1.0
        self.beside = self.edges + self.apart * self.run


@lru_cache(maxsize=GRIDS)
def _pieces(grid: Grid) -> _Pieces | None:
    corners = [each for run in grid.runs if (each := run.corners) is not None]
    return _Pieces(grid, corners) if len(corners) == len(grid.runs) else None
