"""Where a log is cut into runs."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from testbed.arrays import Flags, Series
from testbed.errors import InputError
from testbed.logs.map import MOST_RUNS, GapRuns, TimedRuns, WholeRun
from testbed.logs.samples import Samples


@dataclass(frozen=True, kw_only=True)
class Span:
    """A part of a log.

    Attributes:
        start: its first time, s.
        end: its last time, s; where open, the first time behind it.
        open: whether the end itself is not in it.
    """

    start: float = -inf
    end: float = inf
    open: bool = False

    def rows(self, time: Series) -> Flags:
        """Return which times are in it."""
        return (time >= self.start) & ((time < self.end) if self.open else (time <= self.end))


def spans_of(runs: WholeRun | GapRuns | TimedRuns, body_rate: Samples) -> list[Span]:
    """Return the parts of a log that are runs, in order.

    Args:
        runs: what the map says of them.
        body_rate: whose pauses separate runs.
    """
    if isinstance(runs, WholeRun):
        return [Span()]
    if isinstance(runs, TimedRuns):
        return [Span(start=start, end=end) for start, end in runs.spans_s]
    pauses = np.flatnonzero(np.diff(body_rate.time) > runs.longer_than_s)
    starts = body_rate.time[[0, *(pauses + 1)]]
    ends = body_rate.time[[*pauses, -1]]
    return _few([Span(start=float(start), end=float(end)) for start, end in zip(starts, ends, strict=True)])


def flagged_spans(time: Series, flag: Series, above: float) -> list[Span]:
    """Return the parts of a log in which a flag is set; it holds from its sample to the next one.

    Args:
        time: of the flag's samples, increasing, shape (N,), s.
        flag: shape (N,).
        above: value above which it is set.
    """
    padded = np.concatenate([[False], flag > above, [False]])
    changes = np.flatnonzero(padded[1:] != padded[:-1])
    ends = np.append(time, inf)
    return _few(
        [
            Span(start=float(time[begin]), end=float(ends[end]), open=True)
            for begin, end in zip(changes[::2], changes[1::2], strict=True)
        ]
    )


def _few(spans: list[Span]) -> list[Span]:
    if len(spans) > MOST_RUNS:
        raise InputError(
            f"[runs] cuts the log into {len(spans):,} runs, at most {MOST_RUNS:,} are made: cut it otherwise"
        )
    return spans
