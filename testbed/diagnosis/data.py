"""Measured runs side by side, as the diagnosis compares them with a prediction: both in units of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from testbed.arrays import Array, Units
from testbed.effects.fast_changes import FEWEST, fast_power
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid, grid_of
from testbed.prediction.motor_torques import has_torques, measured_torques
from testbed.prediction.servo import response, ticks_of
from testbed.prediction.servo_response import by_stretches, by_units, constants, has_commands, measured_responses, shown
from testbed.prediction.smoothed import direction_of

_LEAST = 1e-3
"""Share of a channel's own scatter that its noise has at least: the model of a gimbal is no better than that."""
_NUDGES = np.repeat([1e-5, 1e-3, 1e-3], 6)
"""Lag, s, viscous friction, 1/s, and dry friction, rad/s², over the inertia, by which derivatives are taken."""
_USUAL = np.repeat([0.01, 1.0, 10.0], 6)
"""Sizes of the same; the search begins with a tenth. From a lag that is guessed too long, a servo swings, and no step
finds back: steps are bounded."""
_TRIALS = 20
_CLOSE = 1e-2
"""Share of the squares that a further step has to gain."""
_MODEL = 2.5e-4
"""rad. By which an answer may be missed for other reasons than noise: commands between samples and the plan are not
known, and what is missed by that stays for several samples. Without it, lags and dry frictions of eight detectable
sizes miss the truth by 4 to 6 standard deviations where encoders are as good as 1e-4 rad."""
_ENOUGH = 2
"""Numbers for each unknown of the servos without which nobody can tell whether they are followed."""
_FOLLOWING = 2.0
"""Of the noise: what gimbals may miss the answer of their servo by, with any lag and friction of each. A servo of
another kind misses more, and would be taken for a slow one."""


def torque_channel(grid: Grid) -> tuple[list[Array], Units] | None:
    """Return the measured motor torques of every run, each of shape (K, 6), N·m, and their noise; None without."""
    if not has_torques(grid):
        return None
    torques = measured_torques(grid)
    return torques, _noise(torques)


def response_channel(grid: Grid) -> tuple[list[Array], Array] | None:
    """Return what is compared of every run's gimbal angles, each of shape (K, 3), rad, and its noise, shape (3,).

    None where commands are not sent, or the gimbals do not follow them as their servo would.
    """
    if not has_commands(grid):
        return None
    responses = measured_responses(grid)
    if not any(len(each) for each in responses):
        return None
    left = _left(grid, responses)
    pairs = zip(grid.commanded_runs, left, strict=True)
    by_unit = [part for run, each in pairs for part in by_stretches(run, by_units(run, each))]
    noise = np.sqrt(2.0 * np.mean(_noise(by_unit) ** 2))  # six columns hold the noise of three directions
    unknowns = len(_NUDGES) + sum(constants(run).shape[1] for run in grid.commanded_runs)
    squares = np.concatenate(left).ravel() ** 2
    if len(squares) < _ENOUGH * unknowns:
        return None
    missed = np.sqrt(squares.sum() / (len(squares) - unknowns))
    return (responses, np.full(3, np.hypot(max(missed, noise), _MODEL))) if missed < _FOLLOWING * noise else None


def _left(grid: Grid, responses: Sequence[Array]) -> list[Array]:
    """Return what gimbals miss of the response of servos with a lag and friction each, of every run, (K, 3), rad."""

    def left(unknowns: Array) -> Array:
        return np.concatenate([part[0].ravel() for part in _missed(grid, responses, unknowns[None])])

    def slopes(unknowns: Array) -> Array:
        parts = _missed(grid, responses, np.vstack([unknowns, unknowns + np.diag(_NUDGES)]))
        changes = np.concatenate([(part[1:] - part[:1]).reshape(len(_NUDGES), -1) for part in parts], axis=1)
        return np.asarray(changes.T / _NUDGES)

    found = least_squares(
        left,
        0.1 * _USUAL,
        slopes,
        bounds=(0.0, np.inf),
        x_scale=_USUAL,
        ftol=_CLOSE,
        max_nfev=_TRIALS,
    )
    edges = np.cumsum([each.size for each in responses])[:-1]
    return [part.reshape(-1, 3) for part in np.split(found.fun, edges)]


def _missed(grid: Grid, responses: Sequence[Array], unknowns: Array) -> list[Array]:
    """Return measured less predicted responses of servos with lag, viscous and dry friction, each (P, K, 3)."""
    lag, viscous, dry = np.split(unknowns, 3, axis=1)
    parts = []
    for run, measured in zip(grid.commanded_runs, responses, strict=True):
        rate = ticks_of(run).gimbal_rate
        against = viscous[:, None] * rate + dry[:, None] * direction_of(rate)
        parts.append(measured - shown(run, response(run, lag, against)))
    return parts


def _noise(channel: Sequence[Array]) -> Units:
    """Return the standard deviation of every column's noise, shape (W,), of all runs together.

    Args:
        channel: of every run, shape (K, W).
    """
    least = _LEAST * np.concatenate(channel).std(axis=0) + np.finfo(float).tiny
    long = [each for each in channel if len(each) >= FEWEST]
    if not long:
        return np.asarray(np.concatenate(channel).std(axis=0) + least)
    return np.asarray(np.maximum(np.sqrt(np.mean(np.concatenate([fast_power(each) for each in long]), axis=0)), least))


@dataclass(frozen=True, kw_only=True, eq=False)
class Runs:
    """Runs of one role.

    Attributes:
        names: of the runs.
        windowed: names of what each is a window of, one after the other; empty where they are whole.
        estimated_noise: the part of the gyro's noise that noise effects estimate sample by sample, of each run, shape
            (N, 3), rad/s; empty where there are none.
        grid: their telemetry on the integration's grid.
        sigma: of the gyro, each run and axis, shape (R, 3), rad/s.
        inner: measured motor torques and responses to commands, blocks in the order in which they are predicted.
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
    estimated_noise: tuple[Array, ...] = ()

    @property
    def measured(self) -> list[Array]:
        """The gyro's samples of each run less the estimated noise, shape (N, 3), rad/s."""
        rates = [run.body_rate for run in self.grid.runs]
        return (
            [rate - noise for rate, noise in zip(rates, self.estimated_noise, strict=True)]
            if self.estimated_noise
            else rates
        )

    @property
    def samples(self) -> int:
        """Numbers that the gyro gave, three a sample."""
        return sum(rates.size for rates in self.measured)

    @property
    def driven_by_momentum(self) -> bool:
        """Whether gimbals or the momentum that they hold are known: torques that are applied have to be integrated."""
        run = self.grid.runs[0]
        return run.gimbals is not None or run.cluster_momentum is not None

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
    torques, rates = torque_channel(grid), response_channel(grid)
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
        estimated_noise=[noise for each in both for noise in each.estimated_noise],
    )


def chosen(runs: Runs, which: Sequence[int]) -> Runs:
    """Return the gyro's samples of some runs, without the gimbals' inner channels."""
    return _gyro_only(
        names=[runs.names[index] for index in which],
        telemetry=[runs.grid.runs[index] for index in which],
        sigma=runs.sigma[list(which)],
        noise_freedom=runs.noise_freedom,
        estimated_noise=[runs.estimated_noise[index] for index in which if runs.estimated_noise],
    )


def _gyro_only(
    names: Sequence[str],
    telemetry: Sequence[Telemetry],
    sigma: Array,
    noise_freedom: float,
    estimated_noise: Sequence[Array],
) -> Runs:
    outer = [replace(run, gimbals=run.gimbals and run.gimbals.angles_only(), gyro_error=None) for run in telemetry]
    grid = replace(grid_of(outer), follows_commands=False)
    return Runs(
        names=tuple(names), grid=grid, sigma=sigma, noise_freedom=noise_freedom, estimated_noise=tuple(estimated_noise)
    )
