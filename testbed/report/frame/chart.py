"""Charts in the page's style.

All charts are drawn in the browser by plotly.js, which stands in the page once. A control engineer zooms into a time
series, reads values off it and switches lines off; a static SVG can do none of this, and could not
follow the reader's light or dark colours either. The few charts that nobody zooms share the library, its fonts and its
colours rather than bring a second one. Colours are names of the style sheet's custom properties, which the page's
script looks up when it draws.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from testbed.arrays import Flags, Series
from testbed.report.frame.series import Line, thinned
from testbed.report.frame.style import color, layout
from testbed.signals import MOST_UNITS, unit_numbers

TIME_AXIS = "time, s"
"""Title of the axis that charts over time have."""
_SHORTEST_TIME = 1e-4
"""s; less than a chart shows."""
_WIDE = 4.0
"""px; of a line that shows below another one that it agrees with."""
_DASHES = ("dash", "dot", "dashdot")


@dataclass(frozen=True, kw_only=True)
class Level:
    """A value that a chart marks with horizontal lines.

    Attributes:
        name: in the legend.
        values: where, in the chart's unit.
    """

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Span:
    """A stretch of time that is shaded, s."""

    start: float
    end: float


def line_chart(
    lines: Iterable[Line],
    *,
    y_title: str,
    levels: Iterable[Level] = (),
    shaded: Iterable[Span] = (),
) -> go.Figure:
    """Return a chart of lines over time.

    Args:
        lines: drawn in this order, the last on top.
        y_title: of the vertical axis, with its unit.
        levels: limits and the like.
        shaded: stretches that need a look.
    """
    drawn = tuple(lines)
    extent = extent_of(drawn)
    traces = (*traces_of(drawn), *level_lines(levels, drawn))
    chart = go.Figure(traces, layout=layout(TIME_AXIS, y_title))
    for span in shaded:
        chart.add_vrect(x0=span.start, x1=span.end, fillcolor=color("shade"), line_width=0, layer="below")
    units = any(line.name in unit_numbers(MOST_UNITS) for line in drawn)
    chart.update_layout(legend_title_text="CMG " if units else "", showlegend=len(chart.data) > 1)
    return chart.update_xaxes(range=extent if extent[0] < extent[1] else None)  # a single sample spans nothing


def raised(time: Series, flags: Flags, period: float) -> tuple[Span, ...]:
    """Return the stretches of time in which a flag is up.

    Args:
        time: shape (N,), s.
        flags: shape (N,).
        period: that each sample stands for, s.
    """
    steps = np.diff(np.concatenate([[False], flags, [False]]).astype(int))
    first, behind = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    return tuple(
        Span(start=float(time[a]), end=float(time[b - 1] + period)) for a, b in zip(first, behind, strict=True)
    )


def traces_of(lines: Iterable[Line]) -> tuple[go.Scatter, ...]:
    """Return lines as plotly draws them."""
    return tuple(map(_trace, lines))


def _trace(line: Line) -> go.Scatter:
    x, y = thinned(line.x, line.y)
    with np.errstate(over="ignore"):  # what diverged may be too large; it leaves the chart, and that is how it looks
        short_y = y.astype(np.float32)  # seven digits are more than a screen shows, in half the file
    return go.Scatter(
        x=_short(x),
        y=short_y,
        name=line.name,
        legendgroup=line.name,
        showlegend=line.listed,
        cliponaxis=line.style != "points",  # a sample at the edge is drawn whole
        opacity=0.5 if line.pale else 1.0,
        **_stroke(line),
    )


def _short(x: Series) -> NDArray[np.floating[Any]]:
    """Return x in single precision where that moves no sample by more than 0.1 ms; a clock's date needs double."""
    single = x.astype(np.float32)
    return single if len(x) and np.abs(single - x).max() < _SHORTEST_TIME else x


def _stroke(line: Line) -> Mapping[str, Any]:
    if line.style == "points":
        return {"mode": "markers", "marker": {"color": color(line.color), "size": 4}}
    dash = "dash" if line.style == "dashed" else "solid"
    width = _WIDE if line.style == "wide" else 1.5
    return {"mode": "lines", "line": {"color": color(line.color), "width": width, "dash": dash}}


def extent_of(lines: Sequence[Line]) -> list[float]:
    """Return where lines begin and end on the horizontal axis."""
    ends = [line.x[[0, -1]] for line in lines]
    return [float(np.min(ends)), float(np.max(ends))]


def level_lines(levels: Iterable[Level], lines: Sequence[Line]) -> Iterator[go.Scatter]:
    """Yield each level as a line of its own along all others: it has a place in the legend and can be switched off."""
    extent = extent_of(lines)
    for dash, level in zip(_DASHES, levels, strict=False):
        x = [x for _ in level.values for x in (*extent, None)]
        y = [y for value in level.values for y in (value, value, None)]
        stroke = {"color": color("limit"), "width": 1.2, "dash": dash}
        yield go.Scatter(x=x, y=y, name=level.name, legendgroup=level.name, mode="lines", line=stroke, hoverinfo="skip")
