"""Measured runs as the diagnosis takes them: fit and held-out, each with the standard deviation of its gyro."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbed.arrays import Array
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid, grid_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Runs:
    """Runs of one role.

    Attributes:
        names: of the runs.
        grid: their telemetry on the integration's grid.
        sigma: of the gyro, each run and axis, shape (R, 3), rad/s.
    """

    names: tuple[str, ...]
    grid: Grid
    sigma: Array

    @property
    def measured(self) -> list[Array]:
        """The gyro's samples of each run, shape (N, 3), rad/s."""
        return [run.body_rate for run in self.grid.runs]

    @property
    def samples(self) -> int:
        """Numbers that the gyro gave, three a sample."""
        return sum(rates.size for rates in self.measured)

    def with_sigma(self, sigma: Array) -> Runs:
        """Return the same runs with another standard deviation of the gyro, shape (R, 3) or (3,), rad/s."""
        return replace(self, sigma=np.broadcast_to(sigma, self.sigma.shape).copy())

    def whitened(self, predicted: Sequence[Array]) -> Array:
        """Return (measured - predicted) / sigma of all runs, one after the other, shape (samples,)."""
        pairs = zip(self.measured, predicted, self.sigma, strict=True)
        return np.concatenate([((rates - guess) / sigma).ravel() for rates, guess, sigma in pairs])


def runs_of(names: Sequence[str], telemetry: Sequence[Telemetry]) -> Runs:
    """Put runs side by side, with the gyro noise that their telemetry states.

    Raises:
        InputError: too few samples in a run, or runs whose channels differ.
    """
    grid = grid_of(telemetry)
    sigma = np.array([[run.gyro_noise] * 3 for run in grid.runs])
    return Runs(names=tuple(names), grid=grid, sigma=sigma)
