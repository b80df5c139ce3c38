"""Where the residual is more than noise: runs, channels, times, frequencies, and what it follows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
import scipy
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Flags, Series
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, orthonormal, projected_out
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.compared import torques_compared
from testbed.prediction.grid import unit_count
from testbed.prediction.motor_torques import has_torques
from testbed.prediction.servo_response import by_units, followed
from testbed.prediction.wheel_response import compared_wheels, impulse_times
from testbed.signals import AXES, unit_numbers

Path = Literal["reading", "torque"]


def candidates(runs: Runs, axis: int) -> tuple[list[tuple[str, Path]], Array]:
    """Return what may drive the residual and, for each, what it would add to the axis's whitened samples.

    Args:
        runs: that were fitted.
        axis: of the body.
    """
    names: list[tuple[str, Path]] = []
    parts = []
    for run in runs.grid.runs:
        signals = dict(_signals(run))
        as_torque = {
            name: scipy.integrate.cumulative_trapezoid(each, run.gyro_time, initial=0.0)
            for name, each in signals.items()
        }
        names = [*((name, "reading") for name in signals), *((name, "torque") for name in as_torque)]
        column = np.column_stack([*signals.values(), *as_torque.values()])
        parts.append(column[:, None] * np.eye(3)[axis, :, None])
    return names, np.concatenate(runs.whitened_columns(parts))


def _signals(run: Telemetry) -> Iterator[tuple[str, Series]]:
    """Yield body rates, their products, gimbal angles and rates, and time, at the gyro's samples."""
    time, rate = run.gyro_time, run.body_rate
    yield "time", time - time[0]
    for first in range(3):
        yield f"body_rate_{AXES[first]}", rate[:, first]
        yield f"body_acceleration_{AXES[first]}", np.gradient(rate[:, first], time)
        for second in range(first, 3):
            yield f"body_rate_{AXES[first]}*body_rate_{AXES[second]}", rate[:, first] * rate[:, second]
        yield f"body_rate_{AXES[first]}*abs(body_rate_{AXES[first]})", rate[:, first] * np.abs(rate[:, first])
    if run.gimbals is not None:
        units = range(1, run.gimbals.angle.shape[1] + 1)
        yield from _along(("gimbal_angle", "gimbal_rate"), units, run, run.gimbals.angle)
    if run.wheels is not None:
        wheels = range(1, run.wheels.momentum.shape[1] + 1)
        speed = run.wheels.momentum / run.wheels.wheels.spin_inertia
        yield from _along(("wheel_speed", "wheel_acceleration"), wheels, run, speed)
    if run.gimbals is None and run.wheels is None and run.cluster_momentum is not None:
        yield from _along(("cluster_momentum", "cluster_momentum_rate"), AXES, run, run.cluster_momentum)
    if run.applied_torque is not None:
        yield from _along(("applied_torque", "applied_torque_rate"), AXES, run, run.applied_torque)


def _along(
    names: tuple[str, str], columns: Sequence[str | int], run: Telemetry, samples: Array
) -> Iterator[tuple[str, Series]]:
    """Yield a channel's columns and their derivatives, by name, at the gyro's samples."""
    spline = run.through(samples)
    for order, name in enumerate(names):
        for column, values in zip(columns, spline(run.gyro_time, order).T, strict=True):
            yield f"{name}_{column}", values


MOST = 6
"""Segments that are reported: as many as a reader compares in a table; they decide nothing."""
_QUIET = 2.0
"""Squared whitened residual that a stretch has to exceed on average to be reported: noise has 1."""
_OF_THE_PEAK = 0.1
"""Of the largest square; what is quieter than that is the residual bending towards it, by which stretches were
too long."""
_CHANCE = 0.01
"""p-value, times the number of signals (Bonferroni), below which a residual is said to go along with one. Convention;
it is reported beside a segment and decides nothing."""
_SHOWN = 1e-3
"""Share of a signal's length that has to remain when all that the model can do is projected out: of less, rounding and
the model's own errors would be compared."""
_LONE = 6.0
"""By how much, beyond twice the logarithm of the samples, a stretch's squares have to exceed the quiet: the largest of
n squared normal numbers is about 2 log n. Of 3,000 axes of white noise (seed 0) 1.2 % have such a stretch at 30
samples, 2.4 % at 500, 3.0 % at 2,000."""


@dataclass(frozen=True, kw_only=True)
class ResidualSegment:
    """A stretch of one axis of one run in which the residual is large.

    Attributes:
        signal: e.g. `body_rate_y`.
        run: its name.
        from_s: first sample of the stretch, s.
        to_s: last.
        share: of the whole residual's power.
        depends_on: what the residual of this axis goes along with, e.g. `gimbal_rate_3`; None where with nothing.
        enters_as: whether as a reading of the gyro, or as a torque, which it follows as its integral.
        correlation: of residual and what it depends on.
    """

    signal: str
    run: str
    from_s: float
    to_s: float
    share: float
    depends_on: str | None
    enters_as: Path | None
    correlation: float


@dataclass(frozen=True, kw_only=True)
class Dependence:
    """What the residual of an axis goes along with.

    Attributes:
        signal: its name.
        enters_as: see `ResidualSegment`.
        correlation: between -1 and 1.
    """

    signal: str
    enters_as: Path
    correlation: float


def located(runs: Runs, fit: Fit) -> tuple[ResidualSegment, ...]:
    """Return the segments of a fit's residual, the largest share first; none where there is only noise.

    Args:
        runs: that were fitted.
        fit: of them.
    """
    compared_numbers = fit.residual[: runs.numbers]
    total = float(compared_numbers @ compared_numbers)
    segments = [segment for channel in (_gyro(runs, fit), *_inner(runs, fit)) for segment in _segments(channel, total)]
    return tuple(sorted(segments, key=lambda segment: -segment.share)[:MOST])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Residual:
    """Residual of a fit in one channel of all runs.

    Attributes:
        signals: name of each column.
        runs: names of the runs.
        time: of each run, shape (N,), s.
        values: whitened, of each run, shape (N, width).
        dependence: what a column goes along with.
    """

    signals: tuple[str, ...]
    runs: tuple[str, ...]
    time: Sequence[Series]
    values: Sequence[Array]
    dependence: Callable[[int], Dependence | None]


def _gyro(runs: Runs, fit: Fit) -> _Residual:
    return _Residual(
        signals=tuple(f"body_rate_{name}" for name in AXES),
        runs=runs.names,
        time=[run.gyro_time for run in runs.grid.runs],
        values=runs.by_run(fit.residual),
        dependence=lambda axis: dependence(runs, fit, axis),
    )


def _inner(runs: Runs, fit: Fit) -> Iterator[_Residual]:
    """Yield the residuals of motor torques and of the servo response, where the runs carry these channels."""
    edges = np.cumsum([runs.samples, *(block.size for block in runs.inner)])[:-1]
    parts = np.split(fit.residual[: runs.numbers], edges)[1:]
    blocks = [part.reshape(block.shape) for part, block in zip(parts, runs.inner, strict=True)]
    names = ["gimbal_torque"] * has_torques(runs.grid) + ["gimbal_angle"] * runs.grid.follows_commands
    for index, name in enumerate(names):
        values = blocks[index * len(runs.names) : (index + 1) * len(runs.names)]
        times = [run.actuator_time[torques_compared(run)] for run in runs.grid.runs]
        if name == "gimbal_angle":
            commanded = runs.grid.commanded_runs
            values = [by_units(run, block) for run, block in zip(commanded, values, strict=True)]
            times = [run.actuator_time[followed(run)] for run in commanded]
        splines = [run.through(run.gimbals.angle) for run in runs.grid.gimbal_runs]
        yield _Residual(
            signals=tuple(f"{name}_{unit}" for unit in unit_numbers(unit_count(runs.grid))),
            runs=runs.names,
            time=times,
            values=values,
            dependence=partial(_inner_dependence, "gimbal", splines, 1, times, values, 0),
        )
    yield from _of_wheels(runs, blocks[len(names) * len(runs.names) :])


def _of_wheels(runs: Runs, blocks: Sequence[Array]) -> Iterator[_Residual]:
    """Yield the residual of the impulses of each wheel's motor, at the ends of their intervals."""
    count = len(runs.names)
    splines = [run.momentum_through(run.wheels.momentum) for run in runs.grid.runs if run.wheels is not None]
    for place, wheel in enumerate(compared_wheels(runs.grid)):
        times, values = impulse_times(runs.grid, wheel), blocks[place * count : (place + 1) * count]
        yield _Residual(
            signals=(f"wheel_torque_{wheel + 1}",),
            runs=runs.names,
            time=times,
            values=values,
            dependence=partial(_inner_dependence, "wheel", splines, 0, times, values, wheel),
        )


def _inner_dependence(
    kind: Literal["gimbal", "wheel"],
    splines: Sequence[CubicSpline],
    order: int,
    times: Sequence[Series],
    values: Sequence[Array],
    first: int,
    column: int,
) -> Dependence | None:
    """Return which of its unit's motions a residual goes along with.

    Args:
        kind: of the unit.
        splines: through its motion, of every run.
        order: of the derivative that is its rate.
        times: of the residual, of every run.
        values: of the residual, of every run, shape (K, M).
        first: index of the unit whose residual is in the first of its columns.
        column: of the residual.
    """
    unit = first + column
    moving = f"{kind}_{'rate' if kind == 'gimbal' else 'speed'}_{unit + 1}"
    names = (moving, f"sign({moving})", f"{kind}_acceleration_{unit + 1}")
    rate, change = (
        np.concatenate([spline(time, each)[:, unit] for spline, time in zip(splines, times, strict=True)])
        for each in (order, order + 1)
    )
    residual = np.concatenate([part[:, column] for part in values])
    columns = np.stack([rate, np.sign(rate), change])
    lengths = np.linalg.norm(columns, axis=1) * np.linalg.norm(residual)
    correlation = columns @ residual / np.where(lengths > 0.0, lengths, 1.0)
    best = int(np.argmax(np.abs(correlation)))
    if not _by_more_than_chance(float(correlation[best]), len(residual), len(names)):
        return None
    return Dependence(signal=names[best], enters_as="reading", correlation=float(correlation[best]))


def _segments(residual: _Residual, total: float) -> Iterator[ResidualSegment]:
    for column, signal in enumerate(residual.signals):
        stretches = [_loudest(values[:, column]) for values in residual.values]
        if not any(stretches):
            continue
        found = residual.dependence(column)
        for run, time, values, stretch in zip(residual.runs, residual.time, residual.values, stretches, strict=True):
            if stretch is not None:
                yield ResidualSegment(
                    signal=signal,
                    run=run,
                    from_s=float(time[stretch][0]),
                    to_s=float(time[stretch][-1]),
                    share=float((values[stretch, column] ** 2).sum()) / total,
                    depends_on=None if found is None else found.signal,
                    enters_as=None if found is None else found.enters_as,
                    correlation=0.0 if found is None else found.correlation,
                )


def dependence(runs: Runs, fit: Fit, axis: int) -> Dependence | None:
    """Return what an axis's residual goes along with by more than chance, all that the model can do projected out.

    Args:
        runs: that were fitted.
        fit: of them.
        axis: of the body.
    """
    names, columns = candidates(runs, axis)
    nuisance = orthonormal(fit.jacobian[: runs.samples])
    free = projected_out(columns, nuisance)
    residual = projected_out(fit.residual[: runs.samples], nuisance)
    of_axis = _of_axis(runs, axis)
    residual = np.where(of_axis, residual, 0.0)
    length = np.linalg.norm(free, axis=0) * np.linalg.norm(residual)
    seen = np.linalg.norm(free, axis=0) > _SHOWN * np.linalg.norm(columns, axis=0)
    correlation = np.where(seen, free.T @ residual / np.where(seen, length, 1.0), 0.0)
    best = int(np.argmax(np.abs(correlation)))
    if not _by_more_than_chance(float(correlation[best]), int(of_axis.sum()), len(names)):
        return None
    signal, path = names[best]
    return Dependence(signal=signal, enters_as=path, correlation=float(correlation[best]))


def _by_more_than_chance(correlation: float, samples: int, tried: int) -> bool:
    """Return whether a correlation, the largest of so many, is too large for white noise: its square is a beta."""
    return bool(tried * scipy.stats.beta.sf(correlation**2, 0.5, 0.5 * max(samples - 1, 1)) < _CHANCE)


def _loudest(values: Series) -> slice | None:
    """Return the stretch with the most power beyond what noise would have there; None where there is none (Kadane)."""
    if not len(values):  # a stretch between gaps may be too short to compare its motors
        return None
    excess = values**2 - max(_QUIET, _OF_THE_PEAK * float((values**2).max()))
    total = np.concatenate([[0.0], np.cumsum(excess)])
    lowest = np.minimum.accumulate(total)
    last = int(np.argmax(total - lowest))
    first = int(np.argmin(total[: last + 1]))
    # A lone outlier of noise is beyond it as well; a stretch has to be beyond what the longest record shows by chance.
    return slice(first, last) if total[last] - total[first] > 2.0 * np.log(len(values)) + _LONE else None


def _of_axis(runs: Runs, axis: int) -> Flags:
    """Return which of the gyro's whitened numbers are about an axis, shape (samples,)."""
    counts = [len(run.gyro_time) for run in runs.grid.runs]
    return np.concatenate(
        [np.tile(np.flatnonzero(live) == axis, count) for count, live in zip(counts, runs.live, strict=True)]
    )
