"""What the motors of reaction wheels were asked for between samples, and over samples that were lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Flags, Series, Units, UnitSeries
from testbed.estimation.gaps import FEWEST_BURSTS, KEPT_BETWEEN, between_gaps, bursts, lost_samples
from testbed.estimation.telemetry import Telemetry, WheelMotors, WheelTelemetry
from testbed.prediction.compared import incomplete
from testbed.prediction.jumps import beside, jumps

_DEGREE = 2
"""Of the polynomial through neighbours of lost samples: as many bends as a smooth command has in some seconds."""
ROUNDING = 1e-6
"""Of an interval, by which clocks round."""
_LEAST_LOOP = 1e-6
"""Of a speed loop's bandwidth times the control period, below which its torque does not change within that: 0/0."""


class Motors(NamedTuple):
    """How motors give their torque between samples.

    Attributes:
        limit: of the torque, shape (W,), N·m.
        motors: what is known of them.
        commanded: whether torques are commands, or else measured.
    """

    limit: Units
    motors: WheelMotors
    commanded: bool

    def mean(self, sampled: UnitSeries, time: Series, jump: Flags | None = None) -> UnitSeries:
        """Return the mean torque of every interval between samples of shape (K, W), shape (K - 1, W), N·m.

        A command is what a motor gives from its sample on, less the phase for which it had held, a measured torque what
        it gave before, but for the phase for which it goes on: each for a control period, through which a loop on the
        wheel's speed lets it decline. Those that are not sampled in between lie on a spline.
        """
        motors, torque = self.motors, sampled
        if self.commanded:  # what a current shows was given, whatever the limit is believed to be
            torque = np.clip(sampled, -self.limit, self.limit)
        decline = np.maximum(motors.loop_bandwidth * motors.period, _LEAST_LOOP)
        period = np.minimum(motors.period / np.diff(time), 1.0)[:, None]
        phase = motors.command_phase if self.commanded else 1.0 - motors.torque_phase
        share = 0.5 - (1.0 - 2.0 * phase) * 0.5 * period
        held = -np.expm1(-decline) / decline if self.commanded else np.expm1(decline) / decline
        mean = torque[:-1] + share * np.diff(torque, axis=0)
        if np.any(period < 1.0):
            # A parabola that is held n = 1 / period times lies beside the line by 1 - 1 / n² of what its mean does.
            mean += (1.0 - period**2) * _beside_line(time, torque, jump)
        return np.asarray(held * mean)

    def jumps(self, sampled: UnitSeries, time: Series) -> Flags:
        """Return between which samples a torque jumps that changes in between, shape (K - 1,)."""
        changing = self.motors.period < (1.0 - ROUNDING) * float(np.median(np.diff(time)))
        return jumps(time, sampled) if changing else np.zeros(len(time) - 1, dtype=np.bool_)

    def change(self, sampled: UnitSeries, other: UnitSeries, time: Series) -> UnitSeries:
        """Return what impulses change by with other samples, shape (K - 1, W), N·m·s."""
        return (self.mean(other, time) - self.mean(sampled, time)) * np.diff(time)[:, None]


def _beside_line(time: Series, values: UnitSeries, jump: Flags | None) -> UnitSeries:
    """Return by how much the mean of splines through samples, shape (K, W), is beside that of lines, (K - 1, W).

    Args:
        time: of the samples, shape (K,), s.
        values: of the torques.
        jump: between which samples a spline ends and another one begins, shape (K - 1,); None for nowhere.
    """
    whole = np.zeros((len(time) - 1, values.shape[1]))
    for rows in between_gaps(np.zeros(len(time) - 1, dtype=np.bool_) if jump is None else jump):
        own, of = time[rows], values[rows]
        if len(own) > 1:
            integral = CubicSpline(own, of).antiderivative()(own)
            lines = 0.5 * (of[:-1] + of[1:])
            whole[rows.start : rows.stop - 1] = np.diff(integral, axis=0) / np.diff(own)[:, None] - lines
    return whole


def bends(run: Telemetry, motors: Motors) -> UnitSeries:
    """Return by how much impulses of smooth torques are beside those on lines between samples, (K - 1, W), N·m·s.

    Args:
        run: with K samples of its W wheels.
        motors: which torques, and how motors give them.
    """
    assert run.wheels is not None
    sampled, time = run.wheels.torque_command if motors.commanded else run.wheels.torque, run.actuator_time
    assert sampled is not None
    return _beside_line(time, sampled, motors.jumps(sampled, time)) * np.diff(time)[:, None]


def torques_between(run: Telemetry, wheels: WheelTelemetry, motors: Motors) -> tuple[UnitSeries, UnitSeries, Array]:
    """Return `torque`, `last` and `unseen` of `Impulses`, each of shape (L, W).

    Over lost samples a curve through or among the others stands for them, which errs as much as where samples came
    through. Where a torque that changes between its samples jumps, nobody knows when.

    Args:
        run: whose samples they lie between, L + 1 of them.
        wheels: its wheels, W of them, whose commands or measured torques these are.
        motors: which of the two, and how motors give it.
    """
    sampled, time = wheels.torque_command if motors.commanded else wheels.torque, run.actuator_time
    assert sampled is not None
    scatter = wheels.scatter if motors.commanded else None
    smooth = sampled if scatter is None else sampled - scatter.samples
    jump = motors.jumps(sampled, time)
    doubted = jump if motors.motors.near_jumps else beside(jump)
    gap, held = incomplete(run), motors.mean(smooth, time, jump)
    torque = held.copy()
    if scatter is not None:  # it is over when the interval ends
        torque += scatter.behind * scatter.samples[:-1] + scatter.before * scatter.samples[1:]
    unseen = np.where(doubted[:, None], np.inf, np.zeros_like(torque))
    if not gap.any():
        return torque, held, unseen
    lost = np.where(gap, lost_samples(time), 0)
    of_interval = np.repeat(np.arange(len(lost)), lost + 1)
    first = np.cumsum(lost + 1) - lost - 1
    number = np.arange(len(of_interval)) - first[of_interval]
    whole = np.append(time[of_interval] + number * (np.diff(time) / (lost + 1))[of_interval], time[-1])
    filled = np.append(smooth[of_interval], smooth[-1:], axis=0)
    for each in np.unique(lost[gap]).tolist():
        variances = [_variance_over_gap(run, sampled, motors, each, fill) for fill in _FILLS]
        rows = lost == each
        unseen[gap & ~doubted & rows] = np.min(variances, axis=0)
        gone = np.append(rows[of_interval] & (number > 0), False)
        filled[gone] = np.choose(np.argmin(variances, axis=0), [fill(time, smooth, whole[gone]) for fill in _FILLS])
    mean = motors.mean(filled, whole, jump[of_interval])
    last = np.where(gap[:, None], mean[first + lost], held)
    impulse = mean * np.diff(whole)[:, None]
    torque[gap] = (np.add.reduceat(impulse, first, axis=0) / np.diff(time)[:, None])[gap]
    return torque, last, unseen


def _variance_over_gap(run: Telemetry, sampled: UnitSeries, motors: Motors, lost: int, fill: _Fill) -> Units:
    """Return the variance of impulses over so many lost samples, (N·m·s)², shape (W,); infinite where unknown."""
    errors = [np.zeros((0, sampled.shape[1]))]
    for rows in between_gaps(incomplete(run)):
        time, torque = run.actuator_time[rows], sampled[rows]
        gone = bursts(len(time), lost)
        if gone.any():
            filled = torque.copy()
            filled[gone] = fill(time[~gone], torque[~gone], time[gone])
            change = motors.change(torque, filled, time)
            errors.append(np.add.reduceat(change, np.flatnonzero(np.diff(gone.astype(int)) > 0), axis=0))
    found = np.concatenate(errors)
    return np.mean(found**2, axis=0) if len(found) >= FEWEST_BURSTS else np.full(sampled.shape[1], np.inf)


def _through_neighbours(time: Series, torque: UnitSeries, at: Series) -> UnitSeries:
    """Return a spline through the samples."""
    return np.asarray(CubicSpline(time, torque)(at))


def _among_neighbours(time: Series, torque: UnitSeries, at: Series) -> UnitSeries:
    """Return polynomials among as many samples on either side as bursts leave, by least squares.

    Feedback makes noise of the tachometers' anew in each period: a spline would carry it across a gap, amplified.
    """
    count = min(2 * KEPT_BETWEEN, len(time))
    first = np.clip(np.searchsorted(time, at) - KEPT_BETWEEN, 0, len(time) - count)
    near = first[:, None] + np.arange(count)
    apart = (time[near] - at[:, None]) / np.median(np.diff(time))
    weights = np.linalg.pinv(np.vander(apart.ravel(), _DEGREE + 1, increasing=True).reshape(*near.shape, -1))[:, 0]
    return np.asarray(np.einsum("ln,lnw->lw", weights, torque[near]))


_Fill: TypeAlias = Callable[[Series, UnitSeries, Series], UnitSeries]
"""Takes times and values of samples, and times, to values at these."""
_FILLS: tuple[_Fill, ...] = (_through_neighbours, _among_neighbours)
"""Of lost samples; whichever errs less where samples came through."""
