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
_LEGEND = 0.18
"""Of the flight's time, kept free behind its end: the legend stands there instead of over the curves."""
_GLOBAL_VIEW = "view/5c0dca6a-e63f-9cf7-f657-2602590474cc"
"""Where rerun 0.41 keeps the time axis that linked plots share (`GLOBAL_VIEW_ID` in its source). A viewer that has it
elsewhere shows the flight's time, and the legends over the curves."""

LINKED = rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal)
"""The time axis of every plot: zoomed together."""


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
        ends = [float(time[end]) for time in times if len(time) for end in (0, -1)]
        self._extent = (min(ends), max(ends)) if ends else None

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        super()._log_to_stream(stream)
        if self._extent is not None:
            first, last = self._extent
            shown = rrb.TimeRange(
                start=rrb.TimeRangeBoundary.absolute(seconds=first),
                end=rrb.TimeRangeBoundary.absolute(seconds=last + _LEGEND * (last - first)),
            )
            stream.log(f"{_GLOBAL_VIEW}/TimeAxis", rrb.TimeAxis(view_range=shown))
