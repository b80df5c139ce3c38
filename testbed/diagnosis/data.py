"""Measured runs side by side, as the diagnosis compares them with a prediction: both in units of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Flags, Series, Theta, Vector3
from testbed.diagnosis.belief import Belief
from testbed.diagnosis.channels import ChannelNoise, impulse_channels, response_channel, torque_channel, wheel_channel
from testbed.diagnosis.settings import SETTINGS, PriorOdds
from testbed.diagnosis.window_noise import WindowNoise
from testbed.dynamics.inertia import (
    COLUMNS,
    ROWS,
)
from testbed.estimation.noise_color import NoiseColor
from testbed.estimation.slow_bias import SlowBias
from testbed.estimation.telemetry import ALL_AXES, Telemetry, has_momentum
from testbed.prediction.grid import Grid, grid_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Runs:
    """Runs of one role.

    Attributes:
        names: of the runs.
        windowed: for each run, the name of the stretch of a record of which it is a window; empty for whole stretches.
        estimated_noise: the part of the gyro's noise that noise effects estimate sample by sample, of each run, shape
            (N, 3), rad/s; empty where there are none.
        grid: their telemetry on the integration's grid.
        sigma: of the gyro, each run and axis, shape (R, 3), rad/s.
        inner: measured motor torques, responses to commands and impulses of one wheel after the other, blocks in the
            order in which they are predicted.
        inner_noise: of each block.
        noise_freedom: degrees of freedom with which sigma is known; infinite where it is stated and not estimated.
        belief: what is known of the parameters a priori; None where the runs alone decide them.
        torque_noise: noise of the samples and of a torque that nobody commanded, as `estimation.torque_noise` has it,
            by which windows are whitened instead of by sigma, shape (3, 3); None where it is not estimated.
        noise_stated: whether records state the gyro's noise; where they do not it comes from their samples.
        noise_uncertainty: share by which the stated standard deviation may be wrong, one standard deviation.
        color: of the gyro's noise; None where it is white.
        slow_bias: how the gyro's bias was found to wander; None where it is as each run's telemetry states.
        stated_sigma: sigma before the noise was estimated, shape (R, 3), rad/s; None where it was not.
        prior_odds: of none and of what is not modelled.
        trim_group: for each run, with which others it has its trim in common; empty where every record has its own.
        found_rate: initial rates where searches begin, shape (R, 3), rad/s; None for the first samples.
    """

    names: tuple[str, ...]
    grid: Grid
    sigma: Array
    inner: tuple[Array, ...] = ()
    inner_noise: tuple[ChannelNoise, ...] = ()
    noise_freedom: float = np.inf
    windowed: tuple[str, ...] = ()
    estimated_noise: tuple[Array, ...] = ()
    belief: Belief | None = None
    torque_noise: Array | None = None
    noise_stated: bool = True
    noise_uncertainty: float = SETTINGS.noise_uncertainty
    color: NoiseColor | None = None
    slow_bias: SlowBias | None = None
    stated_sigma: Array | None = None
    prior_odds: PriorOdds = field(default_factory=PriorOdds)
    trim_group: tuple[str, ...] = ()
    found_rate: Array | None = None

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
    def record_names(self) -> list[str]:
        """Names of the records, each once, in their order."""
        return list(dict.fromkeys(self.windowed or self.names))

    @cached_property
    def record_of(self) -> NDArray[np.intp]:
        """Index in `record_names` of every run, shape (R,)."""
        index = {name: number for number, name in enumerate(self.record_names)}
        return np.array([index[name] for name in self.windowed or self.names])

    @property
    def trim_names(self) -> list[str]:
        """Of what there is a trim: names of the records, or of groups of runs, each once, in their order."""
        return list(dict.fromkeys(self.trim_group or self.windowed or self.names))

    @cached_property
    def trim_of(self) -> NDArray[np.intp]:
        """Index in `trim_names` of every run, shape (R,)."""
        index = {name: number for number, name in enumerate(self.trim_names)}
        return np.array([index[name] for name in self.trim_group or self.windowed or self.names])

    @property
    def trimmed(self) -> bool:
        """Whether a constant torque of the actuators is free in records: nothing else fixes its mean."""
        return self.grid.runs[0].applied_torque is not None and not self.driven_by_momentum

    @cached_property
    def first_turn_std(self) -> Series | None:
        """How well the attitude at each run's first sample is known, shape (R,), rad; None where it is exact."""
        known = [run.surroundings.start_std if run.surroundings is not None else 0.0 for run in self.grid.runs]
        return np.array(known) if all(known) else None

    @property
    def own_size(self) -> int:
        """Number of parameters that each run has of its own: the initial rate, and where it is free the first turn."""
        return 3 if self.first_turn_std is None else 6

    @property
    def known_in_part(self) -> bool:
        """Whether the torque is known in part, so that runs are windows: what turns the platform beside it is noise."""
        return bool(self.windowed) and self.trimmed

    def mean_of_trims(self, torque_B: Array) -> Array:
        """Return the mean of a torque, shape (R, T, 3), N·m, over all runs that have the trim of each, (R, 1, 3)."""
        sums = np.zeros((len(self.trim_names), 3))
        np.add.at(sums, self.trim_of, torque_B.mean(axis=1))
        return (sums / np.bincount(self.trim_of)[:, None])[self.trim_of][:, None]

    @property
    def numbers(self) -> int:
        """Numbers of all channels that are compared."""
        return self.samples + sum(block.size for block in self.inner)

    @property
    def live(self) -> Flags:
        """About which body axes each run turns, shape (R, 3): of the others nothing is compared."""
        return self.grid.live

    @property
    def inertia_shown(self) -> Flags:
        """Which of θ any motion of the runs can show, shape (6,): not what is about axes that a bearing holds.

        A run about one axis shows its moment alone; one about two axes also the products of these with the third, by
        the torque that turns the momentum about it.
        """
        counts = self.live.sum(axis=1)
        both = self.live[:, ROWS] & self.live[:, COLUMNS]
        product = (self.live[:, ROWS] | self.live[:, COLUMNS]) & (ROWS != COLUMNS) & (counts == 2)[:, None]
        return np.asarray((both | product).any(axis=0))

    def mean_moment(self, theta: Theta) -> float:
        """Return the mean moment about the axes about which the platform turns, kg·m²; 0 where about none."""
        moments = theta[:3][self.inertia_shown[:3]]
        return float(np.abs(moments).mean()) if len(moments) else 0.0

    @property
    def sizes(self) -> list[int]:
        """How many numbers the gyro of each run gave: one a sample for each axis about which it turns."""
        return [len(run.gyro_time) * int(live.sum()) for run, live in zip(self.grid.runs, self.live, strict=True)]

    @property
    def samples(self) -> int:
        """Numbers that the gyro gave, three a sample of a platform that turns freely."""
        return sum(self.sizes)

    @property
    def driven_by_momentum(self) -> bool:
        """Whether gimbals or the momentum that they hold are known: torques that are applied have to be integrated."""
        return has_momentum(self.grid.runs[0])

    def with_sigma(self, sigma: Array) -> Runs:
        """Return the same runs with another standard deviation of the gyro, shape (R, 3) or (3,), rad/s."""
        return replace(self, sigma=np.broadcast_to(sigma, self.sigma.shape).copy())

    def whitened(self, predicted: Sequence[Array]) -> Array:
        """Return (measured - predicted) / sigma of all blocks, one after the other; the gyro's `samples` come first.

        Args:
            predicted: blocks of all channels, each of shape (N, 3), (N, M), (N, M - 3) or (N, 1).
        """
        pairs = zip((*self.measured, *self.inner), predicted, strict=True)
        return np.concatenate([block.ravel() for block in self._whitened([values - guess for values, guess in pairs])])

    def by_run(self, residual: Array) -> list[Array]:
        """Return the gyro's part of a whitened residual in each run, shapes (N, 3), or (N, 3, C) of C columns.

        About axes that a bearing holds it is zero.

        Args:
            residual: of all blocks, or of the gyro's alone, as `whitened` gives it, one or several side by side.
        """
        parts = np.split(residual[: self.samples], np.cumsum(self.sizes)[:-1])
        return [_on_all_axes(part, live) for part, live in zip(parts, self.live, strict=True)]

    def gyro_residual(self, residual: Array) -> list[Array]:
        """Return what of a whitened residual is the gyro's in each run, in rad/s and with its colour, shapes (N, 3)."""
        if self._window_noise is not None:
            return self._window_noise.colored(self.by_run(residual))
        colored = [
            part if self.color is None else self.color.correlated(part, run.gyro_time)
            for part, run in zip(self.by_run(residual), self.grid.runs, strict=True)
        ]
        return [self.wandering(run, part) * self.sigma[run] for run, part in enumerate(colored)]

    def as_stated(self) -> Runs:
        """Return the same runs with the noise that is stated."""
        sigma = self.sigma if self.stated_sigma is None else self.stated_sigma
        return replace(
            self, sigma=sigma, stated_sigma=None, color=None, slow_bias=None, estimated_noise=(), torque_noise=None
        )

    def gimbals_by_run(self, residual: Array) -> list[tuple[Array, ...]]:
        """Return the gimbal channels' part of a whitened residual in each run, one channel after the other.

        Args:
            residual: of all blocks, shape (numbers,); of the gyro's alone there is nothing of the gimbals.

        Returns:
            Of each run the blocks of `inner` that are its own, each of shape (K, 6), (K, 3) or (K, 1).
        """
        edges = self.samples + np.cumsum([0, *(block.size for block in self.inner)])
        parts = [
            residual[first:last].reshape(block.shape)
            for first, last, block in zip(edges[:-1], edges[1:], self.inner, strict=True)
            if last <= len(residual)
        ]
        count = len(self.names)
        return [tuple(parts[run::count]) for run in range(count)]

    def whitened_columns(self, derivatives: Sequence[Array]) -> list[Array]:
        """Return derivatives of all blocks in units of sigma, each of shape (numbers in the block, C).

        Args:
            derivatives: of each block, or of the gyro's alone, shape (N, 3, C), (N, M, C), (N, M - 3, C) or (N, 1, C).
        """
        return [block.reshape(-1, block.shape[-1]) for block in self._whitened(derivatives)]

    def _whitened(self, blocks: Sequence[Array]) -> list[Array]:
        """Return what is in the blocks' units in units of their noise, without its colour, and where it is compared."""
        own = [] if self._window_noise is None else self._window_noise.whitened(blocks)
        others = range(len(own), len(blocks))
        white = [*own, *(self._still(index, self._in_noise(index, blocks[index])) for index in others)]
        if self.color is not None:
            gyro = zip(white, self.grid.runs, strict=False)  # the inner blocks come behind
            own = [self.color.decorrelated(block, run.gyro_time) for block, run in gyro]
            white = [*own, *white[len(own) :]]
        return [block[:, self._compared(index)] for index, block in enumerate(white)]

    def _still(self, block: int, values: Array) -> Array:
        """Return a block's values in units of σ without what its gyro's bias is stated to wander."""
        bias = self._slow_bias(block)
        return values if bias is None else bias.whitened(values, *self._timed(block))

    def wandering(self, run: int, white: Array) -> Array:
        """Return what is in a run's samples in units of σ with the bias's course: the inverse of taking it off.

        Args:
            run: its index.
            white: shape (N, 3) or (N, 3, C).
        """
        bias = self._slow_bias(run)
        return white if bias is None else bias.wandering(white, *self._timed(run))

    def _slow_bias(self, block: int) -> SlowBias | None:
        """Return how a block's bias wanders; None where nothing says so, or over windows, which are short."""
        if block >= len(self.names) or self.windowed:
            return None
        return self.slow_bias or self.grid.runs[block].slow_bias

    def log_scale(self, run: int) -> Vector3:
        """Return the logarithm of what the density of a run's samples is multiplied by as against white ones."""
        bias, color = self._slow_bias(run), self.color
        colored = np.zeros(3) if color is None else color.log_scale(self.grid.runs[run].gyro_time)
        return colored if bias is None else colored - bias.log_deviation(*self._timed(run))

    def _timed(self, run: int) -> tuple[Series, Vector3]:
        """Return a run's times and σ as it is stated: what a bias foretells is the same for all models."""
        sigma = self.sigma if self.stated_sigma is None else self.stated_sigma
        return self.grid.runs[run].gyro_time, sigma[run]

    def _in_noise(self, block: int, values: Array) -> Array:
        """Return a block's values, shape (N, width) or (N, width, C), in units of σ."""
        if block >= len(self.names):
            return self.inner_noise[block - len(self.names)].whitened(values)
        return ChannelNoise(sigma=self.sigma[block]).whitened(values)

    @cached_property
    def noise_deviance(self) -> Array:
        """Twice the logarithm of what the density of each run's samples is divided by, shape (R,).

        It is that of a covariance which is estimated with every model. Zero where all models have the same noise.
        """
        if self._window_noise is None:
            return np.zeros(len(self.names))
        return np.asarray(np.where(self.live, self._window_noise.deviance, 0.0).sum(axis=1))

    @cached_property
    def _window_noise(self) -> WindowNoise | None:
        """By which windows are whitened; None where that is sigma."""
        if self.torque_noise is None:
            return None
        return WindowNoise([run.gyro_time for run in self.grid.runs], self.torque_noise)

    def _compared(self, block: int) -> Flags | slice:
        """Return which columns of a block are compared."""
        live = self.grid.runs[block].live if block < len(self.names) else ALL_AXES
        return slice(None) if live == ALL_AXES else np.array(live)


def _on_all_axes(part: Array, live: Flags) -> Array:
    """Return a run's numbers, shape (n,) or (n, C), on all three axes, zero about those that a bearing holds."""
    own = part.reshape(-1, int(live.sum()), *part.shape[1:])
    if live.all():
        return own
    whole = np.zeros((len(own), 3, *own.shape[2:]))
    whole[:, live] = own
    return whole


def runs_of(names: Sequence[str], telemetry: Sequence[Telemetry], like: Runs | None = None) -> Runs:
    """Put runs side by side, with the gyro noise that their telemetry states.

    Args:
        names: of the runs.
        telemetry: of each.
        like: other runs of the platform, in whose noise the wheels' impulses are compared if the same wheels are
            compared here; in that which these runs show themselves where there are none.

    Raises:
        InputError: too few samples in a run, or runs whose channels differ.
    """
    grid = grid_of(telemetry)
    sigma = np.array([[run.gyro_noise] * 3 for run in grid.runs])
    torques, responses = torque_channel(grid), response_channel(grid)
    own, others = wheel_channel(grid), None if like is None else like.grid.wheel_noise
    as_others = others is not None and own is not None and others.compares_as(own)
    grid = replace(grid, follows_commands=responses is not None, wheel_noise=others if as_others else own)
    inner = [each for each in (torques, responses, *impulse_channels(grid)) if each is not None]
    return Runs(
        names=tuple(names),
        grid=grid,
        sigma=sigma,
        inner=tuple(block for channel in inner for block in channel.measured),
        inner_noise=tuple(noise for channel in inner for noise in channel.noise),
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
        color=runs.color,
        slow_bias=runs.slow_bias,
        windowed=[name for each in both for name in each.windowed],
        belief=runs.belief,
        torque_noise=runs.torque_noise,
        # Held-out runs have a trim of their own, as they have initial rates.
        trim_group=[f"{group} of {number}" for number, each in enumerate(both) for group in each.trim_group],
    )


def chosen(runs: Runs, which: Sequence[int], telemetry: Sequence[Telemetry] | None = None) -> Runs:
    """Return the gyro's samples of some runs, without the gimbals' inner channels.

    Args:
        runs: to choose from.
        which: of them; one may be chosen for several parts.
        telemetry: parts of them, in which no noise has been estimated; None for the whole of each.
    """
    return _gyro_only(
        names=[runs.names[index] for index in which],
        telemetry=telemetry or [runs.grid.runs[index] for index in which],
        sigma=runs.sigma[list(which)],
        noise_freedom=runs.noise_freedom,
        estimated_noise=[runs.estimated_noise[index] for index in which if runs.estimated_noise and not telemetry],
        color=runs.color,
        slow_bias=runs.slow_bias,
        windowed=[runs.windowed[index] for index in which if runs.windowed],
        belief=runs.belief,
        torque_noise=runs.torque_noise,
        trim_group=[runs.trim_group[index] for index in which if runs.trim_group],
    )


def _gyro_only(
    names: Sequence[str],
    telemetry: Sequence[Telemetry],
    sigma: Array,
    noise_freedom: float,
    estimated_noise: Sequence[Array],
    color: NoiseColor | None,
    slow_bias: SlowBias | None,
    windowed: Sequence[str],
    belief: Belief | None,
    torque_noise: Array | None,
    trim_group: Sequence[str],
) -> Runs:
    outer = [
        replace(run, gimbals=run.gimbals and run.gimbals.angles_only(), gyro_error=None, reading_error=None)
        for run in telemetry
    ]
    grid = replace(grid_of(outer), follows_commands=False)
    return Runs(
        names=tuple(names),
        grid=grid,
        sigma=sigma,
        noise_freedom=noise_freedom,
        estimated_noise=tuple(estimated_noise),
        color=color,
        slow_bias=slow_bias,
        windowed=tuple(windowed),
        belief=belief,
        torque_noise=torque_noise,
        trim_group=tuple(trim_group),
    )
