"""What the gyro should have read: the motion low-passed, delayed, and sampled at the gyro's own times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Series
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks


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
    predicted = []
    for run, telemetry in enumerate(grid.runs):
        motion = _Smooth(grid.node_time[run], rates[run])
        if np.any(lag):
            motion = motion.low_passed(np.broadcast_to(lag, rates.shape[1]))
        reading = motion.at(telemetry.gyro_time, np.broadcast_to(delay, rates.shape[1]))
        for hook, value in pairs:
            reading = hook.gyro_reading(reading, value, telemetry.gyro_time, run)
        predicted.append(reading)
    return predicted


class _Smooth:
    """A motion through its values and slopes at equidistant nodes, a cubic in between, a line before the first."""

    def __init__(self, time: Series, values: Array, slopes: Array | None = None) -> None:
        """Take values, shape (P, M + 1, 3), at nodes of shape (M + 1,), s; slopes from a cubic spline where absent."""
        self._time, self._values = time, values
        self._step = time[1] - time[0]
        self._slopes = CubicSpline(time, values, axis=1)(time, 1) if slopes is None else slopes

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

    def low_passed(self, time_constant: Array) -> _Smooth:
        """Return the motion behind T ẋ = u - x, exact for a cubic u between nodes; T of shape (P,), s.

        With u(s) = Σ c_j sʲ on a step, the particular solution is Σ d_j sʲ, d_3 = c_3, d_j = c_j - (j + 1) T d_(j+1).
        """
        lag = time_constant[:, None]
        decay = np.exp(-self._step / lag)
        values, rise = self._values, self._slopes[:, :-1]
        change = (values[:, 1:] - values[:, :-1]) / self._step - rise
        bend = (self._slopes[:, 1:] - rise) / self._step
        cubic = (bend - 2 * change / self._step) / self._step
        square = 3 * change / self._step - bend
        lagged = lag[..., None]
        square = square - 3 * lagged * cubic
        linear = rise - 2 * lagged * square
        constant = values[:, :-1] - lagged * linear
        end = constant + self._step * (linear + self._step * (square + self._step * cubic))
        # Steady before the record: the filter has settled on the line that the first step begins with.
        state, filtered = constant[:, 0], [constant[:, 0]]
        for index in range(end.shape[1]):
            state = end[:, index] + decay * (state - constant[:, index])
            filtered.append(state)
        result = np.stack(filtered, axis=1)
        return _Smooth(self._time, result, (values - result) / lagged)
