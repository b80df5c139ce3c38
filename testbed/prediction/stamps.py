"""How unevenly the rows of a log are stamped."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from testbed.arrays import Series

_USUAL = 0.5
"""Share of the usual interval by which one may differ and still be the usual one: no samples are lost in it."""


def stamp_jitter(times: Sequence[Series]) -> float:
    """Return the standard deviation of stamps about a clock that is even, s.

    Args:
        times: stamps of every run, each of shape (N,), s.
    """
    intervals = [np.diff(time) for time in times]
    apart = [each - np.median(each) for each in intervals if len(each)]
    near = np.concatenate(
        [each[np.abs(each) < _USUAL * np.median(steps)] for each, steps in zip(apart, intervals, strict=True)]
    )
    return float(near.std()) / sqrt(2.0) if len(near) else 0.0
