"""Charts in the page's style.

All charts are drawn in the browser by plotly.js, which stands in the page once. A control engineer zooms into a time
series, reads values off it and switches lines off; a drawing in SVG made beforehand can do none of this, and could not
follow the reader's light or dark colours either. The few charts that nobody zooms share the library, its fonts and its
colours rather than bring a second one. Colours are names of the style sheet's custom properties, which the page's
script looks up when it draws.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Flags, Series
from testbed.report.frame.series import Line, thinned
from testbed.signals import UNITS

TIME_AXIS = "time, s"
_SHORTEST_TIME = 1e-4
"""s; less than a chart shows."""
_DASHES = ("dash", "dot", "dashdot")
_FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"


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
    """A stretch of the horizontal axis that is shaded."""

    start: float
    end: float


def color(name: str) -> str:
    """Return a colour of the style sheet."""
    return f"var(--{name})"


def line_chart(
    lines: Iterable[Line],
    *,
    y_title: str,
    x_title: str = TIME_AXIS,
    levels: Iterable[Level] = (),
    shaded: Iterable[Span] = (),
) -> go.Figure:
    """Return a chart of lines.

    Args:
        lines: drawn in this order, the last on top.
        y_title: of the vertical axis, with its unit.
        x_title: of the horizontal axis, with its unit.
        levels: limits and the like.
        shaded: stretches that need a look.
    """
    drawn = tuple(lines)
    extent = _extent(drawn)
    chart = go.Figure([_trace(line) for line in drawn], layout=layout(x_title, y_title))
    _add_levels(chart, levels, extent)
    for span in shaded:
        chart.add_vrect(x0=span.start, x1=span.end, fillcolor=color("shade"), line_width=0, layer="below")
    units = any(line.name in UNITS for line in drawn)
    chart.update_layout(legend_title_text="CMG " if units else "", showlegend=len(chart.data) > 1)
    return chart.update_xaxes(range=extent)


def layout(x_title: str, y_title: str) -> go.Layout:
    """Return the layout that all charts share."""
    axis = _axis()
    return go.Layout(
        template=None,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": _FONT, "size": 12, "color": color("ink")},
        margin={"l": 64, "r": 12, "t": 8, "b": 44},
        xaxis={**axis, "title": {"text": x_title, "standoff": 8}, "hoverformat": ".4~f"},
        yaxis={**axis, "title": {"text": y_title, "standoff": 8}, "hoverformat": ".4~g"},
        legend={"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "bgcolor": "rgba(0,0,0,0)"},
        hovermode="x unified",
        hoverlabel={"bgcolor": color("card"), "bordercolor": color("rule"), "font": {"color": color("ink")}},
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": color("faint"), "activecolor": color("ink")},
        uirevision="kept",  # a redraw in other colours keeps the zoom
    )


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


def _axis() -> dict[str, Any]:
    return {
        "gridcolor": color("grid"),
        "linecolor": color("rule"),
        "zerolinecolor": color("rule"),
        "zerolinewidth": 1,
        "showline": True,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": color("rule"),
        "exponentformat": "power",
        "showexponent": "all",
        "automargin": True,
    }


def _trace(line: Line) -> go.Scatter:
    x, y = thinned(line.x, line.y)
    return go.Scatter(
        x=_short(x),
        y=y.astype(np.float32),  # seven digits are more than a screen shows, in half the file
        name=line.name,
        legendgroup=line.name,
        showlegend=line.listed,
        cliponaxis=line.style != "points",  # a sample at the edge is drawn whole
        opacity=0.5 if line.pale else 1.0,
        **_stroke(line),
    )


def _short(x: Series) -> Series:
    """Return x in single precision where that moves no sample by more than 0.1 ms; a clock's date needs double."""
    single = x.astype(np.float32)
    return single if len(x) and np.abs(single - x).max() < _SHORTEST_TIME else x


def _stroke(line: Line) -> Mapping[str, Any]:
    if line.style == "points":
        return {"mode": "markers", "marker": {"color": color(line.color), "size": 4}}
    dash = "dash" if line.style == "dashed" else "solid"
    return {"mode": "lines", "line": {"color": color(line.color), "width": 1.5, "dash": dash}}


def _extent(lines: tuple[Line, ...]) -> list[float]:
    ends = [line.x[[0, -1]] for line in lines]
    return [float(np.min(ends)), float(np.max(ends))]


def _add_levels(chart: go.Figure, levels: Iterable[Level], extent: list[float]) -> None:
    """Draw each level as a line of its own, so that it has a place in the legend and can be switched off."""
    for dash, level in zip(_DASHES, levels, strict=False):
        x = [x for _ in level.values for x in (*extent, None)]
        y = [y for value in level.values for y in (value, value, None)]
        stroke = {"color": color("limit"), "width": 1.2, "dash": dash}
        chart.add_scatter(x=x, y=y, name=level.name, mode="lines", line=stroke, hoverinfo="skip")
