"""Gaps in time: which intervals between samples are too long to interpolate over, and the samples between gaps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Flags, Series

BRIDGED_PERIODS = 2.5
"""A gap of one lost sample is interpolated over; a longer one is not (0.25 s at 16 Hz already costs 2e-5 N·m·s)."""
HELD_PERIODS = 1.5
"""The same of commands that are held: one that was lost had a value of its own, and nothing tells it."""
FEWEST_SAMPLES = 4
"""A cubic spline needs four samples, and so does every estimator."""
GYRO_BRIDGED = 0.3
"""s without a gyro sample, beyond which the attitude that the estimators integrate from it is lost.

Source: that of the actuators' telemetry (`testbed.diagnosis.bridging`). Of 40 s at 20 Hz a second without the
gyro put the momentum form off by seven of its standard deviations."""

_ROUNDED = 1e-4
"""Share by which an interval may be longer: time stamps are rounded, and of three periods of 0.1 s half are more than
0.3 s in floating point.

Source: chosen: stamps of microseconds at 100 Hz."""


def gaps(time: Series, periods: float = BRIDGED_PERIODS, shortest: float = 0.0) -> Flags:
    """Return which intervals between samples are gaps, shape (N-1,): the one rule for gaps in time.

    Args:
        time: of the samples, shape (N,), s.
        periods: of the usual interval, the median, beyond which an interval is a gap.
        shortest: s; no interval within it is a gap, however fast the samples come.
    """
    interval = np.diff(time)
    usual = float(np.median(interval)) if len(interval) else 0.0
    return np.asarray(interval > (1.0 + _ROUNDED) * max(periods * usual, shortest))


def between_gaps(gap: Flags) -> list[slice]:
    """Return the runs of samples between gaps.

    Args:
        gap: which intervals are gaps, shape (N-1,), from `gaps`.
    """
    edges = [0, *(np.flatnonzero(gap) + 1).tolist(), len(gap) + 1]
    return [slice(first, last) for first, last in pairwise(edges)]


def stretches(time: Series) -> list[slice]:
    """Return the runs of samples without a gap between them that are long enough for a spline."""
    return [run for run in between_gaps(gaps(time)) if run.stop - run.start >= FEWEST_SAMPLES]


KEPT_BETWEEN = 8
"""Samples that are kept between two bursts, twice as many as a cubic spline's slope on one side depends on."""
FEWEST_BURSTS = 8
"""Bursts from which a mean square is taken: it is then known to a half."""


def bursts(count: int, lost: int) -> Flags:
    """Return which of samples without a gap to leave out, to learn what it costs to lose so many in a row, (count,).

    Args:
        count: of the samples.
        lost: of one burst; samples are kept before, between and behind.
    """
    index, block = np.arange(count), KEPT_BETWEEN + lost
    return np.asarray((index % block >= KEPT_BETWEEN) & (index < (count - KEPT_BETWEEN) // block * block))


def lost_samples(time: Series) -> NDArray[np.intp]:
    """Return how many samples are missing in each interval, by the usual one, shape (N-1,)."""
    interval = np.diff(time)
    return np.round(interval / np.median(interval)).astype(np.intp) - 1


def covered_by(time: Series, samples: Series) -> Flags:
    """Return which instants lie between two samples without a gap, or on one, shape (N,).

    Args:
        time: of the instants, shape (N,), s.
        samples: times of another channel, s.
    """
    following = np.clip(np.searchsorted(samples, time), 1, len(samples) - 1)
    inside = (time >= samples[0]) & (time <= samples[-1])
    return np.asarray(inside & (np.isin(time, samples) | ~gaps(samples)[following - 1]))
