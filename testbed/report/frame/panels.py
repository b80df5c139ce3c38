"""Several charts in one, over the same time: zoomed together, one legend for all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from testbed.report.frame.chart import TIME_AXIS, Level, extent_of, level_lines, traces_of
from testbed.report.frame.series import Line
from testbed.report.frame.style import axis_style, layout


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One of them.

    Attributes:
        y_title: of its vertical axis, with the unit.
        lines: drawn in this order, the last on top.
        levels: limits and the like.
        title: above it; empty where the figure's title says it.
    """

    y_title: str
    lines: tuple[Line, ...]
    levels: tuple[Level, ...] = ()
    title: str = ""


def panel_chart(rows: Sequence[Sequence[Panel]], row_heights: Sequence[float] | None = None) -> go.Figure:
    """Return a chart of panels.

    Args:
        rows: from top to bottom, each from left to right.
        row_heights: relative to each other; all alike where None.
    """
    panels = [panel for row in rows for panel in row]
    chart = make_subplots(
        rows=len(rows),
        cols=len(rows[0]),
        shared_xaxes="all",
        row_heights=row_heights,
        vertical_spacing=0.07 if len(rows[0]) == 1 else 0.12,
        subplot_titles=[panel.title for panel in panels],
    )
    chart.update_layout(layout("", ""))
    chart.update_annotations(font_size=12)
    if any(panel.title for panel in panels):
        chart.update_layout(legend_y=1.07)
    extent = extent_of([line for panel in panels for line in panel.lines])
    listed: set[str] = set()
    for row, line_of_panels in enumerate(rows, start=1):
        for column, panel in enumerate(line_of_panels, start=1):
            for trace in (*traces_of(panel.lines), *level_lines(panel.levels, panel.lines)):
                trace.showlegend = trace.showlegend is not False and trace.name not in listed
                listed |= {trace.name} if trace.showlegend else set()
                chart.add_trace(trace, row=row, col=column)
            chart.update_yaxes(**axis_style(panel.y_title), hoverformat=".4~g", row=row, col=column)
            bottom = row == len(rows)
            chart.update_xaxes(**axis_style(TIME_AXIS if bottom else ""), hoverformat=".4~f", row=row, col=column)
            chart.update_xaxes(showticklabels=bottom, range=extent, row=row, col=column)
    return chart
