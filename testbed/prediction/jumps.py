"""Where a torque jumps between two samples of it, at an instant that nobody recorded."""

from __future__ import annotations

import numpy as np

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
