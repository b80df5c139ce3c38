"""Writing to a rerun stream: exact time columns, in blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from testbed.arrays import Series

TIMELINE = "sim_time"
BLOCK_ROWS = 16_384
"""Rows sent at once: large enough to be fast, small enough for a viewer to load a part."""

Durations: TypeAlias = NDArray[np.timedelta64]
Columns: TypeAlias = Callable[[slice], rr.ComponentColumnList]
"""The component columns of a block of rows."""


def durations(time: Series) -> Durations:
    """Return times as whole nanoseconds, rounded: truncated, most multiples of a step would be 1 ns early.

    Args:
        time: shape (N,), s.
    """
    return np.rint(np.asarray(time) * 1e9).astype("timedelta64[ns]")


def send(stream: rr.RecordingStream, path: str, time: Series, columns: Columns) -> None:
    """Send the rows of one entity.

    Args:
        stream: the recording.
        path: of the entity.
        time: shape (N,), s.
        columns: called with each block's slice of the N rows.
    """
    stamps = durations(time)
    for rows in _blocks(len(stamps)):
        stream.send_columns(path, [rr.TimeColumn(TIMELINE, duration=stamps[rows])], columns(rows))


def _blocks(count: int) -> Iterator[slice]:
    for first in range(0, count, BLOCK_ROWS):
        yield slice(first, min(first + BLOCK_ROWS, count))
