"""Whether commands of wheels bend between their samples, as those do that change more often than they are sampled.

Of a command that holds from sample to sample, sampled at a phase of its control period, the impulse in between is on
the line between two samples. Of one that changes n times it is near the middle of the line, and as far beside it as a
smooth one bends, but for 1/n² of that. The two stand or fall by this bend: at 1 Hz, under control at 10 Hz, commands
that were taken to be sampled at 0.457 of their period missed 1 % of what wheels were asked for, which the factor of
every motor explained. Where the bend does not show, as in commands that scatter, they are taken to change in between if
the place on the line is that of a whole number of periods: what is asked for is then known less well. So they are where
it cannot be seen, as beside the jumps of a reference that steps every few samples, which leave no interval to compare.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array
from testbed.estimation.telemetry import Telemetry, WheelMotors
from testbed.prediction.command_scatter import (
    asked_if_held,
    changing_between,
    periods_of,
    share_of_next,
    twice_a_sample,
    with_scatter,
)
from testbed.prediction.impulse_noise import SURELY, Coefficients, explained_by_wheel
from testbed.prediction.wheel_commands import Motors, bends
from testbed.prediction.wheel_impulses import Impulses, impulses_of

_SHOWN = 3
"""First columns that impulses are explained by: a wheel's factor, which share of it is the next sample's, the bend."""
_BENT = 0.375
"""Share of a smooth command's bend from which on commands change in between.

Source: formula: half of 1 - 1/n² of those that change twice, 0.75; of those that hold it is zero."""


class Place(NamedTuple):
    """Where on the line between two samples the impulse in between is, as the share of the next one; standard error."""

    share: float
    error: float


def with_bent_commands(runs: Sequence[Telemetry], on_line: Place) -> list[Telemetry]:
    """Return runs whose wheels' commands change between their samples, if impulses show or suggest it; else the same.

    Args:
        runs: of one platform, whose commands are believed to hold from sample to sample.
        on_line: where impulses are if they do, which counts where no smooth interval shows it.
    """
    smooth = [twice_a_sample(run).with_motors(_near_jumps) for run in runs]
    impulses = [each for each in (impulses_of(run, commanded=True) for run in smooth) if each is not None]
    if len(impulses) < len(runs):
        return list(runs)
    columns = [_columns(run, each) for run, each in zip(smooth, impulses, strict=True)]
    found = explained_by_wheel(impulses, columns, shown=_SHOWN, commanded=True)
    if found:
        (share, doubt), (bent, error) = (_of_all(found, column) for column in (1, 2))
    else:
        (share, doubt), (bent, error) = on_line, (0.0, inf)
    surely = bent > max(SURELY * error, _BENT)
    whole = abs(share - share_of_next(periods_of(share))) < SURELY * doubt
    maybe = whole and bent > _BENT - SURELY * error
    return [changing_between(_without_scatter(run), share) for run in runs] if surely or maybe else list(runs)


def _near_jumps(motors: WheelMotors) -> WheelMotors:
    return replace(motors, near_jumps=True)


def _of_all(found: Sequence[Coefficients], column: int) -> tuple[float, float]:
    """Return a column's coefficient over the factor, the mean of all wheels, and its standard error."""
    ratio = np.array([each.values[column] / each.values[0] for each in found])
    variance = np.array([each.covariance[column, column] / each.values[0] ** 2 for each in found])
    weight = 1.0 / np.maximum(variance, np.finfo(float).tiny)
    return float(weight @ ratio / weight.sum()), float(1.0 / np.sqrt(weight.sum()))


def _columns(smooth: Telemetry, impulses: Impulses) -> Array:
    """Return what the motion took, then what may explain it, shape (1 + 5, L, W), N·m·s."""
    wheels = smooth.wheels
    assert wheels is not None
    assert wheels.motors is not None
    bend = bends(smooth, Motors(wheels.wheels.torque_limit, wheels.motors, commanded=True))
    return np.stack([impulses.needed, *asked_if_held(smooth), bend, impulses.turned, impulses.directed])


def _without_scatter(run: Telemetry) -> Telemetry:
    """Return a run of whose commands nothing scatters."""
    assert run.wheels is not None
    return with_scatter(run, np.zeros_like(run.wheels.momentum), 0.0, 0.0)
