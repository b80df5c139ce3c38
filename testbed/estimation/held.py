"""Torques that are held from sample to sample, and jump between them: what they give, exactly, on even grids."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from testbed.arrays import Array, Matrix3, Series
from testbed.estimation.gaps import FEWEST_SAMPLES, HELD_PERIODS, gaps

_UNEVEN, _FEW = 0.1, 0.2
"""Share of the usual period by which one has to differ to be uneven, and share of the periods that may.

Source: chosen: a clock that is read late by a tenth of its period is no rare one, and of twenty commands one or two may
be lost; commands that are logged when they change, or that come as they are computed, have hardly two periods alike."""
_ROUNDING = 1e-9
"""Periods by which a whole number of them may be missed: times are differences of numbers with sixteen digits."""


class HeldPeriods(NamedTuple):
    """Periods over which a torque is held, all of one length but for those that were lost.

    Attributes:
        middle: shape (K,), s.
        means: makes of samples, shape (N, C), the means over these periods, shape (K, C).
    """

    middle: Series
    means: Callable[[Array], Array]


def held_periods(time: Series, gyro_time: Series) -> HeldPeriods:
    """Return the periods of samples that are held from their times until the next.

    Where these times are even, a sample has a period, and one that was lost leaves a gap. Where they are not, as of
    commands that are logged when they change, nothing was lost, and the periods are the gyro's: it sees no more of a
    torque than the impulse between two of its samples.

    Args:
        time: of the samples, shape (N,), s.
        gyro_time: s.
    """
    if len(time) < FEWEST_SAMPLES:  # whoever uses them says so
        return HeldPeriods(time, lambda samples: samples)
    periods = np.diff(time)
    usual = float(np.median(periods))
    if np.mean(np.abs(periods / usual - 1.0) > _UNEVEN) <= _FEW:
        kept = np.append(np.where(gaps(time, HELD_PERIODS), usual, periods), usual)
        return HeldPeriods(time + 0.5 * kept, lambda samples: samples)
    step = float(np.median(np.diff(gyro_time)))
    first = gyro_time[min(int(np.searchsorted(gyro_time, time[0])), len(gyro_time) - 1)]
    edges = first + step * np.arange(math.ceil((gyro_time[-1] - first) / step - _ROUNDING) + 2)
    held = np.append(time, max(edges[-1], time[-1] + usual))

    def means(samples: Array) -> Array:
        return np.asarray(np.diff(_impulse_between(held, samples)(edges), axis=0) / step)

    return HeldPeriods(edges[:-1] + 0.5 * step, means)


def impulse_of_held(middle: Series, samples: Array, axis: int = 0) -> BSpline:
    """Return the impulse that held samples have given since the first began.

    Args:
        middle: of the periods over which they are held, shape (K,), s.
        samples: shape (K, C), or with K on another axis.
        axis: along which they follow each other.
    """
    return _impulse_between(_edges(middle), samples, axis)


def within_held(time: Series, middle: Series) -> Series:
    """Return instants, those of the first and the last period moved to the middle of these; others as they are.

    Args:
        time: of the instants, shape (N,), s.
        middle: of the periods over which samples are held, shape (K,), s; only the first and last one reach beyond it.
    """
    edges = _edges(middle)
    inside = (time >= edges[0] - _ROUNDING * np.ptp(middle)) & (time <= edges[-1] + _ROUNDING * np.ptp(middle))
    return np.where(inside, np.clip(time, middle[0], middle[-1]), time)


def _edges(middle: Series) -> Series:
    """Return the instants between periods, from the beginning of the first to the end of the last, shape (K + 1,)."""
    between = 0.5 * (middle[:-1] + middle[1:])
    return np.concatenate([[2.0 * middle[0] - between[0]], between, [2.0 * middle[-1] - between[-1]]])


def _impulse_between(edges: Series, samples: Array, axis: int = 0) -> BSpline:
    """Return the impulse since the first edge of samples that are each held from one edge to the next."""
    gained = np.cumsum(np.moveaxis(samples, axis, 0).T * np.diff(edges), axis=-1).T
    impulse = np.concatenate([np.zeros_like(gained[:1]), gained])
    return make_interp_spline(edges, np.moveaxis(impulse, 0, axis), k=1, axis=axis)


def corners_of(impulse: BSpline, inertia: Matrix3) -> BSpline:
    """Return the body rate that a held torque gives an inertia at rest, rad/s: it bends wherever the torque jumps.

    A measured rate less that of an inertia near the true one is smooth, and can be joined by a cubic spline.

    Args:
        impulse: as of `impulse_of_held`, N·m·s, body axes.
        inertia: shape (3, 3), kg·m².
    """
    by_axis = np.moveaxis(impulse.c, impulse.axis, -2) @ np.linalg.inv(inertia).T
    return BSpline(impulse.t, np.moveaxis(by_axis, -2, impulse.axis), impulse.k, axis=impulse.axis)


def step_within(period: float, longest_step: float) -> float:
    """Return the longest step, s, of which half a period holds a whole number: a held torque jumps at nodes then.

    Args:
        period: over which it is held, s.
        longest_step: that the motion allows, s.
    """
    half = 0.5 * period
    return half / math.ceil(half / longest_step - _ROUNDING)


def along_steps(impulse: BSpline, at: Series) -> Array:
    """Return what is held along the grid of an integration, shape (T, C), on the impulse's axis.

    At nodes the mean about them stands; between two of them what makes the integration's rule, a sixth, four sixths and
    a sixth, give the step the very impulse that was held.

    Args:
        impulse: as of `impulse_of_held`.
        at: every half step, the last a node, shape (T,), s.
    """
    step, first = 2.0 * (at[1] - at[0]), (len(at) - 1) % 2
    reach = step / 6.0
    found = np.moveaxis((impulse(at + reach) - impulse(at - reach)) / (2.0 * reach), impulse.axis, 0)
    mean = np.moveaxis(np.diff(impulse(at[first::2]), axis=impulse.axis) / step, impulse.axis, 0)
    found[first + 1 :: 2] = (6.0 * mean - found[first:-1:2] - found[first + 2 :: 2]) / 4.0
    return np.asarray(np.moveaxis(found, 0, impulse.axis))
