"""The axes of a recording's plots: ranges with numbers beside them, and room for the legend."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from testbed.arrays import Series
from testbed.recording.traces import Trace

_MOST_STEPS = 12
"""Steps that a plot may span before the viewer leaves their numbers out: it writes those whose step has 20 points or
more, and of three plots in a column each is 240 points high in a window of 950."""
_MARGIN = 0.05
"""Of the span, at either end: a number at the very edge is not written."""
_LEGEND = 0.22
"""Of the flight's time, kept free behind its end: the legend stands there instead of over the curves."""
_GLOBAL_VIEW = "view/5c0dca6a-e63f-9cf7-f657-2602590474cc"
"""Where rerun 0.41 keeps the time axis that linked plots share (`GLOBAL_VIEW_ID` in its source). A viewer that has it
elsewhere shows the flight's time, and the legends over the curves."""

_ALIKE = 2.0 / 3.0
"""Of the longest tab's time: what a shorter one has to take of a shared axis, or each has its own."""

LINKED = rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal)
"""The time axis of plots that are zoomed together."""


def time_axes(tabs: Sequence[Sequence[Trace]]) -> tuple[rrb.TimeAxis, ...]:
    """Return the time axis of the plots of each tab: shared, unless one of them would fill too little of it.

    Args:
        tabs: their traces.
    """
    extents = [_extent([trace.time for trace in tab]) for tab in tabs]
    lengths = [0.0 if extent is None else extent[1] - extent[0] for extent in extents]
    if all(length >= _ALIKE * max(lengths) for length in lengths):
        return (LINKED,) * len(tabs)
    alone = rrb.components.LinkAxis.Independent
    return tuple(
        LINKED if extent is None else rrb.TimeAxis(link=alone, view_range=_shown(extent)) for extent in extents
    )


def _extent(times: Sequence[Series]) -> tuple[float, float] | None:
    """Return the first and the last of all times, s; None where there are none."""
    ends = [float(time[end]) for time in times if len(time) for end in (0, -1)]
    return (min(ends), max(ends)) if ends else None


def _shown(extent: tuple[float, float]) -> rrb.TimeRange:
    """Return a stretch of time with the legend's room behind it."""
    first, last = extent
    return rrb.TimeRange(
        start=rrb.TimeRangeBoundary.absolute(seconds=first),
        end=rrb.TimeRangeBoundary.absolute(seconds=last + _LEGEND * (last - first)),
    )


def value_axis(traces: Sequence[Trace]) -> rrb.ScalarAxis | None:
    """Return the vertical axis of a plot; None where nothing but one value is drawn, and the viewer chooses."""
    known = [trace.values[np.isfinite(trace.values)] for trace in traces]
    ends = [float(end) for values in known if len(values) for end in (values.min(), values.max())]
    if not ends or min(ends) == max(ends):
        return None
    return rrb.ScalarAxis(range=numbered_range(min(ends), max(ends)))


def numbered_range(low: float, high: float) -> tuple[float, float]:
    """Return the range of an axis that shows low to high, and at least two of the numbers that the viewer writes.

    The viewer writes numbers at the multiples of a power of ten. Between -0.09 and 0.09 that is 0 alone, and nobody
    can read a value off the plot.
    """
    step = 10.0 ** np.ceil(np.log10((high - low) / _MOST_STEPS))
    first, last = np.ceil(low / step), np.floor(high / step)
    if first == last:  # the span exceeds a step, so that one lies within
        below, above = step * (first - 1), step * (last + 1)
        low, high = (below, high) if low - below < above - high else (low, above)
    margin = _MARGIN * (high - low)
    return float(low - margin), float(high + margin)


class SharedTime(rrb.TimePanel):
    """The time panel, paused; and what linked plots show at first: the flight, and the legend's room behind it."""

    def __init__(self, timeline: str, times: Sequence[Series]) -> None:
        """Take the timeline's name and the times that are shown, each of shape (N,), s."""
        super().__init__(timeline=timeline, play_state="paused", state="collapsed")
        self._times = _extent(times)

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        super()._log_to_stream(stream)
        if self._times is not None:
            stream.log(f"{_GLOBAL_VIEW}/TimeAxis", rrb.TimeAxis(view_range=_shown(self._times)))
