"""Where a torque jumps between two samples of it, at an instant that nobody recorded."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Flags, Series, UnitSeries

_SCATTERS = 10.0
"""Standard deviations of what samples scatter about their neighbours, by which two in a row miss them: white noise
never does so, and what is robustly known of it in a few hundred samples errs by a tenth."""
_LEAST = 0.05
"""Share of the torque's own standard deviation that a jump is at least: of less, half of it in one interval is within
what impulses between samples are compared to (`impulse_noise._BETWEEN`)."""
_SIDE = 2
"""Neighbours on either side that foretell a sample, by the cubic through them."""
_TO_DEVIATION = 1.4826
"""Standard deviation over the median of absolute values, of normal numbers."""


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
    missed = _missed(time, samples)
    apart = np.abs(np.diff(missed, axis=0))
    scatter = _TO_DEVIATION * np.median(np.abs(missed), axis=0)
    large = apart > np.maximum(2.0 * _SCATTERS * scatter, _LEAST * samples.std(axis=0))
    found[_SIDE:-_SIDE] = np.any(large, axis=1)
    return found


def _missed(time: Series, samples: UnitSeries) -> Array:
    """Return by how much samples with two neighbours on either side miss the cubic through these, (K - 4, W), N·m."""
    count = len(time) - 2 * _SIDE
    places = [place for place in range(2 * _SIDE + 1) if place != _SIDE]
    times = {place: time[place : place + count] for place in range(2 * _SIDE + 1)}
    foretold = np.zeros((count, samples.shape[1]))
    for place in places:
        weight = np.ones(count)
        for other in places:
            if other != place:
                weight *= (times[_SIDE] - times[other]) / (times[place] - times[other])
        foretold += weight[:, None] * samples[place : place + count]
    return np.asarray(samples[_SIDE:-_SIDE] - foretold)
