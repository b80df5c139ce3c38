"""What a residual may go along with: motions of the body and of the units, as readings and as torques."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from scipy.integrate import cumulative_trapezoid

from testbed.arrays import Array, Series
from testbed.diagnosis.data import Runs
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import telemetry_spline
from testbed.signals import AXES

Path = Literal["reading", "torque"]


def candidates(runs: Runs, axis: int) -> tuple[list[tuple[str, Path]], Array]:
    """Return what may drive the residual and, for each, what it would add to the axis's whitened samples.

    Args:
        runs: that were fitted.
        axis: of the body.
    """
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
