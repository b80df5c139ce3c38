"""Where the gap is: on which axis, in which stretch of time, and what it goes along with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.stats import beta

from testbed.arrays import Array, Flags, Series
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, orthonormal
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import telemetry_spline
from testbed.signals import AXES

MOST = 6
"""Places that are told."""
_QUIET = 2.0
"""Squared whitened residual that a stretch has to exceed on the average to be told: noise has 1."""
_CHANCE = 0.01

Path = Literal["reading", "torque"]


@dataclass(frozen=True, kw_only=True)
class Place:
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
        enters_as: see `Place`.
        correlation: between -1 and 1.
    """

    signal: str
    enters_as: Path
    correlation: float


def located(runs: Runs, fit: Fit) -> tuple[Place, ...]:
    """Return the places of a fit's residual, the largest share first; none where there is only noise.

    Args:
        runs: that were fitted.
        fit: of them.
    """
    residual = whitened_by_run(runs, fit)
    total = sum(float((part**2).sum()) for part in residual)
    places = []
    for axis, name in enumerate(AXES):
        stretches = [_loudest(part[:, axis]) for part in residual]
        if not any(stretches):
            continue
        found = dependence(runs, fit, axis)
        for run, stretch in enumerate(stretches):
            if stretch is not None:
                time = runs.grid.runs[run].gyro_time[stretch]
                places.append(
                    Place(
                        signal=f"body_rate_{name}",
                        run=runs.names[run],
                        from_s=float(time[0]),
                        to_s=float(time[-1]),
                        share=float((residual[run][stretch, axis] ** 2).sum()) / total,
                        depends_on=None if found is None else found.signal,
                        enters_as=None if found is None else found.enters_as,
                        correlation=0.0 if found is None else found.correlation,
                    )
                )
    return tuple(sorted(places, key=lambda place: -place.share)[:MOST])


def whitened_by_run(runs: Runs, fit: Fit) -> list[Array]:
    """Return a fit's whitened residual of the gyro in each run, shape (N, 3)."""
    edges = np.cumsum([rates.size for rates in runs.measured])[:-1]
    return [part.reshape(-1, 3) for part in np.split(fit.residual[: runs.samples], edges)]


def dependence(runs: Runs, fit: Fit, axis: int) -> Dependence | None:
    """Return what an axis's residual goes along with by more than chance, all that the model can do projected out.

    Args:
        runs: that were fitted.
        fit: of them.
        axis: of the body.
    """
    names, columns = _candidates(runs, axis)
    nuisance = orthonormal(fit.jacobian[: runs.samples])
    free = columns - nuisance @ (nuisance.T @ columns)
    residual = fit.residual[: runs.samples]
    residual = residual - nuisance @ (nuisance.T @ residual)
    residual = np.where(_of_axis(len(residual), axis), residual, 0.0)
    length = np.linalg.norm(free, axis=0) * np.linalg.norm(residual)
    seen = np.linalg.norm(free, axis=0) > 1e-3 * np.linalg.norm(columns, axis=0)
    correlation = np.where(seen, free.T @ residual / np.where(seen, length, 1.0), 0.0)
    best = int(np.argmax(np.abs(correlation)))
    if not _by_more_than_chance(float(correlation[best]), len(residual) // 3, len(names)):
        return None
    signal, path = names[best]
    return Dependence(signal=signal, enters_as=path, correlation=float(correlation[best]))


def _by_more_than_chance(correlation: float, samples: int, tried: int) -> bool:
    """Return whether a correlation, the largest of so many, is too large for white noise: its square is a beta."""
    return bool(tried * beta.sf(correlation**2, 0.5, 0.5 * max(samples - 1, 1)) < _CHANCE)


def _loudest(values: Series) -> slice | None:
    """Return the stretch with the most power beyond what noise would have there; None where there is none (Kadane)."""
    excess = values**2 - _QUIET
    total = np.concatenate([[0.0], np.cumsum(excess)])
    lowest = np.minimum.accumulate(total)
    last = int(np.argmax(total - lowest))
    first = int(np.argmin(total[: last + 1]))
    # A lone outlier of noise is beyond it as well; a stretch has to be beyond what the longest record shows by chance.
    return slice(first, last) if total[last] - total[first] > 2.0 * np.log(len(values)) + 6.0 else None


def _of_axis(samples: int, axis: int) -> Flags:
    return np.asarray(np.arange(samples) % 3 == axis)


def _candidates(runs: Runs, axis: int) -> tuple[list[tuple[str, Path]], Array]:
    """Return what may drive the residual and, for each, what it would add to the axis's whitened samples."""
    names: list[tuple[str, Path]] = []
    parts = []
    for run, sigma in zip(runs.grid.runs, runs.sigma, strict=True):
        signals = dict(_signals(run))
        as_torque = {name: cumulative_trapezoid(each, run.gyro_time, initial=0.0) for name, each in signals.items()}
        names = [*((name, "reading") for name in signals), *((name, "torque") for name in as_torque)]
        column = np.column_stack([*signals.values(), *as_torque.values()]) / sigma[axis]
        parts.append(np.kron(column, np.eye(3)[:, [axis]]))
    return names, np.concatenate(parts)


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
    if run.gimbal_angle is not None:
        yield from _along("gimbal_angle", "gimbal_rate", run, 6)
    elif run.cluster_momentum is not None:
        yield from _along("cluster_momentum", "cluster_momentum_rate", run, 3)
    if run.applied_torque is not None:
        yield from _along("applied_torque", "applied_torque_rate", run, 3)


def _along(channel: str, derivative: str, run: Telemetry, width: int) -> Iterator[tuple[str, Series]]:
    spline = telemetry_spline(run, channel)
    for order, name in enumerate((channel, derivative)):
        for index, values in enumerate(spline(run.gyro_time, order).T):
            yield f"{name}_{AXES[index] if width == len(AXES) else index + 1}", values
