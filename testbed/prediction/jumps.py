"""Where a torque changes too fast for its samples: jumps, at instants that nobody recorded, and parts of a flight."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation, uniform_filter1d

from testbed.arrays import Flags, Series, UnitSeries
from testbed.estimation.differences import divided_differences, median_std

_SCATTERS = 10.0
"""Standard deviations of what samples scatter about their neighbours, by which two in a row miss them.

Source: chosen; white noise never does so, and what is robustly known of it in a few hundred samples errs by a tenth."""
_LEAST = 0.05
"""Share of the torque's own standard deviation that a jump is at least.

Source: chosen; half of a smaller one in one interval is near the noise that impulses between samples have in any case
(`impulse_noise._BETWEEN`)."""
_SIDE = 2
"""Neighbours on either side that foretell a sample, by the cubic through them."""
_BESIDE = 3
"""Intervals on either side of a jump in which a spline that ends there is not believed.

Source: formula; in the last one it misses 19/720 of the torque's fourth difference, inside 1/720, and 0.27 of what it
misses goes on to the interval before, 0.02 to the third."""
_PART = 11
"""Samples about an interval from which it is seen how much a torque changes there.

Source: chosen; no longer than what it is to find, the maneuver of a flight that mostly rests."""
_RESTLESS = 3.0
"""Times by which a torque changes more than it mostly does, where that is another part of the flight.

Source: chosen; white noise seems to change by half as much again in one of so many parts."""
_OF_SAMPLE = float(np.sqrt(70.0)) / 6.0
"""What a sample misses that cubic by, over the fourth difference: its weights 1, -4, 6, -4, 1 have the length √70."""


def jumps(time: Series, samples: UnitSeries) -> Flags:
    """Return between which samples some torque jumps, shape (K - 1,).

    The cubic through four neighbours misses the sample before a jump of J by -J/2 and the one behind it by J/2, and
    hardly misses what changes smoothly.

    Args:
        time: of the samples, shape (K,), s.
        samples: of each torque, shape (K, W), N·m.
    """
    found = np.zeros(max(len(time) - 1, 0), dtype=np.bool_)
    if len(time) <= 2 * _SIDE + 1:
        return found
    missed = _OF_SAMPLE * divided_differences(time, samples, 2 * _SIDE)
    apart = np.abs(np.diff(missed, axis=0))
    large = apart > np.maximum(2.0 * _SCATTERS * median_std(missed), _LEAST * samples.std(axis=0))
    found[_SIDE:-_SIDE] = np.any(large, axis=1)
    return found


def beside(jump: Flags) -> Flags:
    """Return between which samples a spline that ends at jumps is not to be believed, shape (K - 1,)."""
    return np.asarray(binary_dilation(jump, iterations=_BESIDE))


def restless(time: Series, samples: UnitSeries) -> Flags:
    """Return between which samples each torque changes far more than it mostly does, shape (K - 1, W).

    In a flight that goes on behind its maneuver, what is known of all samples together is known of the rest.

    Args:
        time: of the samples, shape (K,), s.
        samples: of each torque, shape (K, W), N·m.
    """
    if len(time) <= _PART:
        return np.zeros((max(len(time) - 1, 0), samples.shape[1]), dtype=np.bool_)
    square = uniform_filter1d(np.square(divided_differences(time, samples, 2)), _PART, axis=0, mode="nearest")
    found = square > _RESTLESS**2 * np.median(square, axis=0)
    return np.asarray(np.concatenate([found, found[-1:]]))
