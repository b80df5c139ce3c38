"""Motions through values at equidistant nodes, behind a low-pass or a delay; analytic in both.

Before the first node nothing has moved: a flight that is recorded from its release had turned at one rate until then.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from scipy.interpolate import CubicSpline
from typing_extensions import override

from testbed.arrays import Array, Series
from testbed.prediction.kernels import cubic_between, settled_cubics, slopes_a_unit_apart

_FORGOTTEN = 40.0
"""Time constants after which exp(-t/T) no longer shows in a double."""
_FEWEST_NODES = 4
"""Of a cubic whose third derivative is the same on both sides of the node beside either end."""


class Motion(ABC):
    """A motion of P parameter sets; before its first instant it stood still, or went on as behind."""

    begin: float
    """Its first instant, s."""

    @property
    @abstractmethod
    def first(self) -> Array:
        """What it was then, shape (P, 1, 3)."""

    @abstractmethod
    def between(self, time: Array) -> Array:
        """Return what it is at times of shape (P, N), s, shape (P, N, 3), as it went on before its first instant."""

    @abstractmethod
    def settled(self, time_constant: Array) -> Motion:
        """Return the motion behind T ẋ = u - x, T of shape (P,), settled on how it goes on at first."""

    def at(self, time: Array, time_constant: Array, delay: Array) -> Array:
        """Return what a low-pass T ẋ = u - x with a delay behind it shows of the motion, shape (P, N, 3).

        Before its first value the motion stood still, as before a release.

        Args:
            time: shape (N,) or (P, N), s.
            time_constant: T, shape (P,), s; zero for none.
            delay: shape (P,), s.
        """
        return np.asarray(self.either_way(time, time_constant, delay)[0])

    def either_way(self, time: Array, time_constant: Array, delay: Array) -> Array:
        """Return the same, shape (2, P, N, 3), of a motion that stood still before, and of one that went on as behind.

        Of shape (1, P, N, 3) where nothing of the time before shows.
        """
        late = time - delay[:, None]
        inside = late.real >= self.begin
        if not np.any(time_constant):
            went_on = self.between(late)
            if inside.all():
                return went_on[None]
            return np.stack([np.where(inside[..., None], went_on, self.first), went_on])
        settled = self.settled(time_constant)
        went_on, start = settled.between(late), self.first - settled.first
        elapsed = np.where(inside, late - self.begin, 0.0)
        released = went_on + start * decay(elapsed, time_constant[:, None])[..., None]
        return np.stack([np.where(inside[..., None], released, self.first), went_on])


class Sum(Motion):
    """The sum of motions that begin together."""

    def __init__(self, *parts: Motion) -> None:
        """Take motions of as many parameter sets each."""
        self._parts, self.begin = parts, parts[0].begin

    @property
    @override
    def first(self) -> Array:
        return np.asarray(sum(part.first for part in self._parts))

    @override
    def between(self, time: Array) -> Array:
        return np.asarray(sum(part.between(time) for part in self._parts))

    @override
    def settled(self, time_constant: Array) -> Motion:
        return Sum(*(part.settled(time_constant) for part in self._parts))


class Smooth(Motion):
    """A motion through its values at equidistant nodes, a cubic in between."""

    def __init__(self, time: Series, values: Array, slopes: Array | None = None) -> None:
        """Take values, shape (P, M + 1, 3), at nodes of shape (M + 1,), s, and their slopes where they are known."""
        self._time, self._values, self.begin = time, values, float(time[0])
        self._step = time[1] - time[0]
        self._slopes = node_slopes(values, self._step) if slopes is None else slopes

    @property
    @override
    def first(self) -> Array:
        return self._values[:, :1]

    @override
    def between(self, time: Array) -> Array:
        """Return the cubics at times of shape (P, N), s, shape (P, N, 3).

        Before the first node the first of them goes on, behind the last node the last one for a step, and then a line.
        """
        place, last = (time - self._time[0]) / self._step, self._values.shape[1] - 1.0
        behind = np.where(place.real > last + 1.0, place - last - 1.0, 0.0)
        within = cubic_between(self._values, self._step * self._slopes, place - behind)
        if not np.any(behind):
            return within
        return np.asarray(within + behind[..., None] * (self._values[:, -1:] - self._values[:, -2:-1]))

    @override
    def settled(self, time_constant: Array) -> Smooth:
        """Return the motion behind T ẋ = u - x, u a cubic in each step, settled on the first one."""
        sets = len(self._values), len(time_constant)
        values, slopes, lag = (
            np.broadcast_to(each, (max(sets), *each.shape[1:]))
            for each in (self._values, self._step * self._slopes, time_constant / self._step)
        )
        left = np.broadcast_to(decay(np.array([self._step]), time_constant), len(lag))
        return Smooth(self._time, settled_cubics(values, slopes, lag, left))


def node_slopes(values: Array, step: float | Array) -> Array:
    """Return the slopes at equidistant nodes of the cubic spline through values, both of shape (..., M + 1, 3).

    With y the values at nodes a unit apart and r their rises, the slopes s solve s_(k-1) + 4 s_k + s_(k+1) =
    3 (r_(k-1) + r_k), and s_0 + 2 s_1 = (5 r_0 + r_1)/2 at an end, where the first two pieces are one cubic. Solved
    here by elimination, as it stands: a `CubicSpline` gives the same to rounding in ten times the time.

    Args:
        values: at the nodes.
        step: between nodes, s; broadcasts.
    """
    nodes = values.shape[-2]
    if nodes < _FEWEST_NODES:
        return np.asarray(CubicSpline(np.arange(nodes), values, axis=-2)(np.arange(nodes), 1) / step)
    return np.asarray(slopes_a_unit_apart(values) / step)


def decay(time: Array, time_constant: Array) -> Array:
    """Return exp(-t/T): one at t = 0; beyond it zero, as all its derivatives are, where T is zero or nearly so."""
    lasting = time_constant.real * _FORGOTTEN > time.real
    exponent = np.where(lasting, time, 0.0) / np.where(time_constant.real > 0.0, time_constant, 1.0)
    return np.where(lasting, np.exp(-exponent), time.real == 0.0)
