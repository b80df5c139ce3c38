"""Motions through values at equidistant nodes, behind a delay or a first-order low-pass; analytic in both."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Series

_FORGOTTEN = 40.0
"""Time constants after which exp(-t/T) no longer shows in a double."""


class Smooth:
    """A motion through its values and slopes at equidistant nodes, a cubic in between, a line before the first."""

    def __init__(self, time: Series, values: Array) -> None:
        """Take values, shape (P, M + 1, 3), at nodes of shape (M + 1,), s."""
        self._time, self._values = time, values
        self._step = time[1] - time[0]
        self._slopes = CubicSpline(time, values, axis=1)(time, 1)

    @property
    def values(self) -> Array:
        """At the nodes, shape (P, M + 1, 3)."""
        return self._values

    def at(self, time: Series, delay: Array) -> Array:
        """Return the motion at times of shape (N,) less a delay of shape (P,), shape (P, N, 3)."""
        place = (time - delay[:, None] - self._time[0]) / self._step
        index = np.clip(np.floor(place.real).astype(np.intp), 0, len(self._time) - 2)
        part = (place - index)[..., None]
        sets = np.arange(len(delay))[:, None]
        first, last = self._values[sets, index], self._values[sets, index + 1]
        rise, fall = self._step * self._slopes[sets, index], self._step * self._slopes[sets, index + 1]
        change = last - first
        bend = part * (3 * change - 2 * rise - fall + part * (rise + fall - 2 * change))
        return np.asarray(first + part * (rise + np.where(part.real < 0.0, 0.0, bend)))

    def low_passed(self, time_constant: Array) -> Smooth:
        """Return the motion behind T ẋ = u - x, exact for a cubic u between nodes; T of shape (P,), s.

        With u(s) = Σ c_j sʲ on a step, the particular solution is Σ d_j sʲ, d_3 = c_3, d_j = c_j - (j + 1) T d_(j+1).
        """
        lagged = time_constant[:, None, None]
        rise = self._slopes[:, :-1]
        change = (self._values[:, 1:] - self._values[:, :-1]) / self._step - rise
        bend = (self._slopes[:, 1:] - rise) / self._step
        cubic = (bend - 2 * change / self._step) / self._step
        square = 3 * change / self._step - bend - 3 * lagged * cubic
        linear = rise - 2 * lagged * square
        constant = self._values[:, :-1] - lagged * linear
        end = constant + self._step * (linear + self._step * (square + self._step * cubic))
        decay = self._decay(time_constant)[:, None]
        # Steady before the record: the filter has settled on the line that the first step begins with.
        state, filtered = constant[:, 0], [constant[:, 0]]
        for index in range(end.shape[1]):
            state = end[:, index] + decay * (state - constant[:, index])
            filtered.append(state)
        return Smooth(self._time, np.stack(filtered, axis=1))

    def _decay(self, time_constant: Array) -> Array:
        """Return exp(-step/T), shape (P,): zero, as all its derivatives are, where T is zero or nearly so."""
        lasting = time_constant.real > self._step / _FORGOTTEN
        return np.where(lasting, np.exp(-self._step / np.where(lasting, time_constant, self._step)), 0.0)
