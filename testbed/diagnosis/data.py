"""Measured runs as the diagnosis takes them: fit and held-out, each with the standard deviation of its gyro."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.inner_noise import answer_channel, torque_channel
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid, grid_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Runs:
    """Runs of one role.

    Attributes:
        names: of the runs.
        windowed: names of what each is a window of, one after the other; empty where they are whole.
        told: what of the gyro's samples of each run effects on them tell sample by sample, shape (N, 3), rad/s; empty
            where there are none.
        grid: their telemetry on the integration's grid.
        sigma: of the gyro, each run and axis, shape (R, 3), rad/s.
        inner: measured motor torques and answers to commands, blocks in the order in which they are predicted.
        inner_sigma: of each block, shape (6,) or (3,), in the block's unit.
        noise_freedom: degrees of freedom with which sigma is known; infinite where it is stated.
    """

    names: tuple[str, ...]
    grid: Grid
    sigma: Array
    inner: tuple[Array, ...] = ()
    inner_sigma: tuple[Array, ...] = ()
    noise_freedom: float = np.inf
    windowed: tuple[str, ...] = ()
    told: tuple[Array, ...] = ()

    @property
    def measured(self) -> list[Array]:
        """The gyro's samples of each run less what is told of them, shape (N, 3), rad/s."""
        rates = [run.body_rate for run in self.grid.runs]
        return [rate - told for rate, told in zip(rates, self.told, strict=True)] if self.told else rates

    @property
    def samples(self) -> int:
        """Numbers that the gyro gave, three a sample."""
        return sum(rates.size for rates in self.measured)

    @property
    def driven_by_momentum(self) -> bool:
        """Whether gimbals or the momentum that they hold are known: torques that are applied have to be integrated."""
        run = self.grid.runs[0]
        return run.gimbal_angle is not None or run.cluster_momentum is not None

    def with_sigma(self, sigma: Array) -> Runs:
        """Return the same runs with another standard deviation of the gyro, shape (R, 3) or (3,), rad/s."""
        return replace(self, sigma=np.broadcast_to(sigma, self.sigma.shape).copy())

    def whitened(self, predicted: Sequence[Array]) -> Array:
        """Return (measured - predicted) / sigma of all blocks, one after the other; the gyro's `samples` come first.

        Args:
            predicted: blocks of all channels, each of shape (N, 3) or (N, 6).
        """
        measured = (*self.measured, *self.inner)
        pairs = zip(measured, predicted, self._sigmas, strict=True)
        return np.concatenate([((values - guess) / sigma).ravel() for values, guess, sigma in pairs])

    def by_run(self, residual: Array) -> list[Array]:
        """Return what of a whitened residual is the gyro's in each run, shapes (N, 3), or (N, 3, C) of C columns.

        Args:
            residual: of all blocks, or of the gyro's alone, as `whitened` gives it, one or several side by side.
        """
        edges = np.cumsum([rates.size for rates in self.measured])[:-1]
        return [part.reshape(-1, 3, *part.shape[1:]) for part in np.split(residual[: self.samples], edges)]

    def whitened_columns(self, derivatives: Sequence[Array]) -> list[Array]:
        """Return derivatives of all blocks in units of sigma, each of shape (numbers in the block, C).

        Args:
            derivatives: of each block, shape (N, 3, C) or (N, 6, C).
        """
        pairs = zip(derivatives, self._sigmas, strict=True)
        return [(block / sigma[:, None]).reshape(-1, block.shape[-1]) for block, sigma in pairs]

    @property
    def _sigmas(self) -> tuple[Array, ...]:
        return (*self.sigma, *self.inner_sigma)


def runs_of(names: Sequence[str], telemetry: Sequence[Telemetry]) -> Runs:
    """Put runs side by side, with the gyro noise that their telemetry states.

    Raises:
        InputError: too few samples in a run, or runs whose channels differ.
    """
    grid = grid_of(telemetry)
    sigma = np.array([[run.gyro_noise] * 3 for run in grid.runs])
    torques, rates = torque_channel(grid), answer_channel(grid)
    inner = [channel for channel in (torques, rates) if channel is not None]
    return Runs(
        names=tuple(names),
        grid=replace(grid, follows_commands=rates is not None),
        sigma=sigma,
        inner=tuple(block for blocks, _ in inner for block in blocks),
        inner_sigma=tuple(noise for blocks, noise in inner for _ in blocks),
    )


def joined(runs: Runs, heldout: Runs | None) -> Runs:
    """Return the gyro's samples of all runs, the fitted ones first, without the gimbals' inner channels."""
    both = (runs,) if heldout is None else (runs, heldout)
    return _gyro_only(
        names=[name for each in both for name in each.names],
        telemetry=[run for each in both for run in each.grid.runs],
        sigma=np.concatenate([each.sigma for each in both]),
        noise_freedom=runs.noise_freedom,
        told=[told for each in both for told in each.told],
    )


def chosen(runs: Runs, which: Sequence[int]) -> Runs:
    """Return the gyro's samples of some runs, without the gimbals' inner channels."""
    return _gyro_only(
        names=[runs.names[index] for index in which],
        telemetry=[runs.grid.runs[index] for index in which],
        sigma=runs.sigma[list(which)],
        noise_freedom=runs.noise_freedom,
        told=[runs.told[index] for index in which if runs.told],
    )


def _gyro_only(
    names: Sequence[str], telemetry: Sequence[Telemetry], sigma: Array, noise_freedom: float, told: Sequence[Array]
) -> Runs:
    outer = [replace(run, gimbal_torque=None, gimbal_rate_command=None, gyro_error=None) for run in telemetry]
    grid = replace(grid_of(outer), follows_commands=False)
    return Runs(names=tuple(names), grid=grid, sigma=sigma, noise_freedom=noise_freedom, told=tuple(told))
