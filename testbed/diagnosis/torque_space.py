"""What torques of many shapes would do to the samples, linearised along the motion of a fit.

A torque is linear between knots. Those around a sample move it each in its own way; those long before it only by what
they left in the state of the motion, which is a few numbers. So a run's response, as many numbers as samples times
knots, is kept as a band along its diagonal and, below it, as products of narrow matrices. Of a run of five minutes that
is a hundredth of it, and what a thousand shapes do takes as much less time.

Source: Chandrasekaran et al., "Some fast algorithms for sequentially semiseparable representations", SIAM Journal on
Matrix Analysis and Applications (2005).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, orthonormal, projected_out
from testbed.prediction import prediction

_WINDOW = 16
"""Knots of a window. Torques count for samples from the window before their own on: of the splines through the motion
0.27 reaches one step further ahead, a billionth as many steps as these knots, which are no closer than steps.

Source: the slopes of a cubic spline decay by 2 - √3 = 0.27 from node to node."""
_UNDIVIDED = 6 * _WINDOW
"""Knots up to which a run is one window: of fewer than six nearly all are beside one another."""
_NEGLIGIBLE = 1e-10
"""Share of the largest singular value below which what a window's torques leave behind is rounding.

Source: chosen, far above rounding and far below what evidences are printed to."""
_TAKEN = 1e-7
"""Share of a torque's effect below which all of it is what the model can do: above rounding, the root of 1e-16."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Window:
    """Samples of one window: their response to torques near them, and to what earlier ones left in the state.

    Attributes:
        first: number of the first of C knots that are near.
        near: response to torques at these about each axis, shape (3, C, K).
        state: response to S numbers of the state, shape (S, K).
    """

    first: int
    near: Array
    state: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Response:
    """Response of a run's samples, in K numbers, to torques at its T knots.

    Attributes:
        windows: of its samples, in order.
        left: what the torques of each window but the last two leave, as few numbers as that is, shapes (3, C, S).
        carried: from these numbers of all windows, one after the other, to those of the states, shape (sum, sum).
    """

    windows: tuple[_Window, ...]
    left: tuple[Array, ...]
    carried: Array

    def by_axis(self, torques: Array) -> Array:
        """Return what torques about each axis do, shape (3, F, K), for torques of shape (1 or 3, F, T)."""
        near = [torques[..., own.first : own.first + own.near.shape[1]] @ own.near for own in self.windows]
        if not self.left:
            return np.concatenate(near, axis=-1)
        starts = [number * _WINDOW for number in range(len(self.left))]
        left = [torques[..., at : at + own.shape[1]] @ own for at, own in zip(starts, self.left, strict=True)]
        states = np.concatenate(left, axis=-1) @ self.carried
        edges = np.cumsum([0, *(len(own.state) for own in self.windows)])
        parts = zip(near, self.windows, pairwise(edges), strict=True)
        return np.concatenate([each + states[..., slice(*ends)] @ own.state for each, own, ends in parts], axis=-1)


class Moved(NamedTuple):
    """What torques would do to a run.

    Attributes:
        samples: to its samples, in as few numbers as that takes, shape (..., C, K).
        beside: their products with r directions of what the model can do, and with the residual, shape (..., C, r + 1).
    """

    samples: Array
    beside: Array

    def chosen(self, which: NDArray[np.intp]) -> Moved:
        """Return the same of some torques about each axis, shape (S, 3 F, ...), for indices of shape (S, F)."""
        samples, beside = (np.moveaxis(each[:, which], 0, 1) for each in self)
        return Moved(*(each.reshape(len(which), -1, each.shape[-1]) for each in (samples, beside)))

    def rows(self, which: slice) -> Moved:
        """Return the same of some of C torques."""
        return Moved(self.samples[which], self.beside[which])


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueSpace:
    """What torques at the knots can do to the samples.

    Attributes:
        responses: of each run.
        beside: products of the response to torques about each axis with r directions of what the model can do, and with
            the residual, of each run, shapes (3, T, r + 1).
    """

    responses: list[_Response]
    beside: list[Array]

    def along(self, torques: Array) -> list[Moved]:
        """Return what torques at the knots do to every run, shape (R, T, 3, C)."""
        axes_first = np.transpose(torques, (0, 2, 3, 1))
        runs = zip(self.responses, self.beside, axes_first, strict=True)
        return [Moved(of.by_axis(own).sum(axis=0), (own @ beside).sum(axis=0)) for of, beside, own in runs]

    def at_knots(self) -> list[Moved]:
        """Return what a torque at each knot by itself does to every run, about each axis: (T, 3, ...)."""
        every = zip(self.responses, self.beside, strict=True)
        moved = ((of.by_axis(np.eye(beside.shape[1])[None]), beside) for of, beside in every)
        return [Moved(*(np.ascontiguousarray(np.swapaxes(each, 0, 1)) for each in own)) for own in moved]

    def about_axes(self, functions: Array) -> list[Moved]:
        """Return what torques about each axis do to every run that follow functions, shape (R, T, F): (3, F, ...)."""
        turned = [np.ascontiguousarray(own.T) for own in functions]
        runs = zip(self.responses, self.beside, turned, strict=True)
        return [Moved(of.by_axis(own), own @ beside) for of, beside, own in runs]


def normal(runs: Sequence[Moved]) -> tuple[Array, Array]:
    """Return the information of amplitudes that all runs share, shape (..., C, C), and the slope, shape (..., C).

    Args:
        runs: what a unit of each amplitude does to every run.
    """
    return _free(np.sum([_gram(own) for own in runs], axis=0), np.sum([own.beside for own in runs], axis=0))


def normal_by_run(runs: Sequence[Moved]) -> tuple[Array, Array]:
    """Return the same of amplitudes that every run has of its own, run after run, R C of them."""
    *sides, count, _ = runs[0].samples.shape
    gram = np.zeros((*sides, len(runs) * count, len(runs) * count))
    for run, moved in enumerate(runs):
        own = slice(run * count, (run + 1) * count)
        gram[..., own, own] = _gram(moved)
    return _free(gram, np.concatenate([own.beside for own in runs], axis=-2))


def _gram(moved: Moved) -> Array:
    return np.asarray(moved.samples @ np.swapaxes(moved.samples, -1, -2))


def _free(gram: Array, beside: Array) -> tuple[Array, Array]:
    """Return information and slope of amplitudes with what the model can do projected out; of what it can do, nothing.

    Args:
        gram: products of what they do with one another, shape (..., C, C).
        beside: as `Moved` has it.
    """
    taken, slope = beside[..., :-1], beside[..., -1]
    information = gram - taken @ np.swapaxes(taken, -1, -2)
    whole, left = (np.diagonal(each, axis1=-2, axis2=-1) for each in (gram, information))
    seen = left > _TAKEN**2 * whole
    return information * (seen[..., :, None] & seen[..., None, :]), slope * seen


def torque_space(runs: Runs, fit: Fit, knots: int) -> TorqueSpace:
    """Return what torques can do to the samples of runs.

    Args:
        runs: to be explained.
        fit: of the present model to them; what it can absorb is projected out.
        knots: of each run, evenly from its first sample to its last; torques are linear between them.
    """
    model, residual = orthonormal(fit.jacobian[: runs.samples]), fit.residual[: runs.samples]
    columns = np.column_stack([model, projected_out(residual, model)])
    beside = np.split(columns, np.cumsum(runs.sizes)[:-1])
    count = _UNDIVIDED if knots <= _UNDIVIDED else _WINDOW
    windows = [range(first, min(first + count, knots)) for first in range(0, knots, count)]
    of_runs = [
        _Parts(np.repeat(_window_of(run.gyro_time, knots, count), size // len(run.gyro_time)), len(windows))
        for run, size in zip(runs.grid.runs, runs.sizes, strict=True)
    ]
    products: list[list[Array]] = [[] for _ in beside]
    for number, which in enumerate(windows):
        for run, response in enumerate(torque_responses(runs, fit, knots, which)):
            of_runs[run].add(number, response)
            products[run].append((response.T @ beside[run]).reshape(len(which), 3, -1))
    return TorqueSpace(
        responses=[parts.joined() for parts in of_runs],
        beside=[np.ascontiguousarray(np.swapaxes(np.concatenate(own), 0, 1)) for own in products],
    )


def torque_responses(runs: Runs, fit: Fit, knots: int, which: range | None = None) -> list[Array]:
    """Return every run's whitened response to a torque at each of its knots, shapes (samples, knots * 3).

    Args:
        runs: to be explained.
        fit: of the present model to them.
        knots: of each run, evenly from its first sample to its last; the torque is linear between them.
        which: of them; None for all.
    """
    hooks = [each.hooks for each in fit.placed]
    responses = prediction.torque_responses(runs.grid, hooks, fit.values, knots, which)
    # A bearing gives back what acts about an axis that it holds; rounding errors of it would pass for a signature.
    acting = [np.tile(live, each.shape[-1] // 3) for each, live in zip(responses, runs.live, strict=True)]
    return runs.whitened_columns([each * own for each, own in zip(responses, acting, strict=True)])


def _window_of(time: Array, knots: int, count: int) -> NDArray[np.intp]:
    """Return in which window of so many knots each sample is, shape (N,)."""
    place = (time - time[0]) / (time[-1] - time[0]) * (knots - 1)
    return np.asarray(np.minimum(place // count, (knots - 1) // count).astype(np.intp))


class _Parts:
    """The response of one run, taken in window by window."""

    def __init__(self, window: NDArray[np.intp], windows: int) -> None:
        """Begin with the window that each row is in, in order, shape (samples,), and the number of windows."""
        self._edges = np.searchsorted(window, np.arange(windows + 1))
        self._near: list[list[Array]] = [[] for _ in range(windows)]
        self._left: list[Array] = []
        self._states: list[list[Array]] = [[] for _ in range(windows)]

    def add(self, number: int, response: Array) -> None:
        """Take in the response to the torques of a window, shape (samples, C * 3)."""
        windows = len(self._near)
        for beside in range(max(number - 1, 0), min(number + 2, windows)):
            self._near[beside].append(response[self._edges[beside] : self._edges[beside + 1]])
        if number + 2 >= windows:
            return
        later = response[self._edges[number + 2] :]
        _, strength, directions = np.linalg.svd(np.linalg.qr(later, mode="r"), full_matrices=False)
        # A torque about an axis that is held does nothing, to the last bit: not even what a factorisation rounds.
        kept = directions[strength > _NEGLIGIBLE * strength.max(initial=0.0)] * later.any(axis=0)
        self._left.append(_by_axis(kept))
        behind = later @ kept.T
        start = self._edges[number + 2]
        for window in range(number + 2, windows):
            self._states[window].append(behind[self._edges[window] - start : self._edges[window + 1] - start])

    def joined(self) -> _Response:
        """Return the response, in as few numbers as it takes."""
        windows, carried = list[_Window](), list[Array]()
        sizes = [each.shape[-1] for each in self._left]
        for number, near in enumerate(self._near):
            response = np.concatenate(near, axis=1)
            count = response.shape[1]
            state, by_left = _narrow(self._states[number], len(response))
            carried.append(np.pad(by_left, ((0, 0), (0, sum(sizes) - by_left.shape[1]))))
            whole = np.concatenate([response, state], axis=1)
            if len(whole) > whole.shape[1]:
                whole = np.asarray(np.linalg.qr(whole, mode="r"))
            of_axes = _by_axis(whole[:, :count])
            of_state = np.ascontiguousarray(whole[:, count:].T)
            windows.append(_Window(first=max(number - 1, 0) * _WINDOW, near=of_axes, state=of_state))
        return _Response(windows=tuple(windows), left=tuple(self._left), carried=np.concatenate(carried).T)


def _by_axis(columns: Array) -> Array:
    """Return columns of torques about three axes in turn, shape (rows, C * 3), as (3, C, rows); rows may be none."""
    rows, count = columns.shape
    return np.ascontiguousarray(columns.reshape(rows, count // 3, 3).transpose(2, 1, 0))


def _narrow(states: Sequence[Array], rows: int) -> tuple[Array, Array]:
    """Return a basis of what torques left in windows before, shape (rows, S), and what each number of it is there."""
    if not states:
        return np.zeros((rows, 0)), np.zeros((0, 0))
    left, strength, right = np.linalg.svd(np.concatenate(states, axis=1), full_matrices=False)
    seen = strength > _NEGLIGIBLE * strength.max(initial=0.0)
    return left[:, seen], strength[seen, None] * right[seen]
