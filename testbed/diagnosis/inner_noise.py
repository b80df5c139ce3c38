"""The gimbals' inner channels as measured, and their noise, which nobody states: told from their fastest changes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from testbed.arrays import Array, Units
from testbed.effects.fast_changes import FEWEST, fast_power
from testbed.prediction.grid import Grid
from testbed.prediction.inner import has_commands, has_torques, lagging_rates, measured_rates, measured_torques

_LEAST = 1e-3
"""Share of a channel's own scatter that its noise has at least: the model of a gimbal is no better than that."""
_SLOWEST_SERVO = 0.5
"""s."""
_FOLLOWING = 1.5
"""Of the noise: what a gimbal's rate may miss its lagging command by. A soft servo that its load pushes about misses
more, and would be taken for a slow one."""


def torque_channel(grid: Grid) -> tuple[list[Array], Units] | None:
    """Return the measured motor torques of every run, each of shape (K, 6), N·m, and their noise; None without."""
    if not has_torques(grid):
        return None
    torques = measured_torques(grid)
    return torques, _noise(torques, torques)


def rate_channel(grid: Grid) -> tuple[list[Array], Units] | None:
    """Return the measured mean gimbal rates of every run, each of shape (K - 1, 6), rad/s, and their noise.

    None where commands are not sent, or the gimbals do not follow them.
    """
    if not has_commands(grid):
        return None
    rates = measured_rates(grid)
    noise = _noise(rates, _missed(rates, lagging_rates(grid, np.zeros((1, 6)))))
    left = np.array([_left(grid, rates, unit) for unit in range(6)])
    return (rates, noise) if bool((left < _FOLLOWING * noise).all()) else None


def _left(grid: Grid, rates: Sequence[Array], unit: int) -> float:
    """Return the root mean square by which a gimbal misses its command behind the lag that fits best, rad/s."""

    def missed(lag: float) -> float:
        behind = lagging_rates(grid, lag * (np.arange(6) == unit)[None])
        return float(np.sqrt(np.mean(np.concatenate(_missed(rates, behind))[:, unit] ** 2)))

    return float(minimize_scalar(missed, bounds=(0.0, _SLOWEST_SERVO), method="bounded").fun)


def _missed(rates: Sequence[Array], predicted: Sequence[Array]) -> list[Array]:
    return [measured - told[0] for measured, told in zip(rates, predicted, strict=True)]


def _noise(channel: Sequence[Array], noisy: Sequence[Array]) -> Units:
    """Return the standard deviation of every unit's noise, shape (6,), of all runs together.

    Args:
        channel: of every run, shape (K, 6).
        noisy: the same less all of it that is known, shape (K, 6).
    """
    least = _LEAST * np.concatenate(channel).std(axis=0) + np.finfo(float).tiny
    long = [each for each in noisy if len(each) >= FEWEST]
    if not long:
        return np.asarray(np.concatenate(channel).std(axis=0) + least)
    return np.asarray(np.maximum(np.sqrt(np.mean(np.concatenate([fast_power(each) for each in long]), axis=0)), least))
