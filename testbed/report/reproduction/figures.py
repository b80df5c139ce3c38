"""Figures of lines over time, from the reproduction's plain arrays."""

from __future__ import annotations

from collections.abc import Iterator

from testbed.report.frame.blocks import Figure
from testbed.report.frame.chart import Level, line_chart
from testbed.report.frame.series import Line, Style, component_lines
from testbed.reproduction.figures import Panel, PaperFigure
from testbed.signals import AXES

_STYLES: dict[str, Style] = {"line": "line", "reference": "dashed", "points": "points"}


def figure_blocks(figure: PaperFigure, note: str = "") -> tuple[Figure, ...]:
    """Return a chart for each panel of a figure, in half of the page's width each.

    Args:
        figure: to draw.
        note: below its last panel.
    """
    last = len(figure.panels) - 1
    return tuple(
        Figure(
            title=f"{figure.title}, {panel.title}",
            chart=line_chart(
                _lines(panel), y_title=f"{panel.title.partition(',')[0]}, {panel.unit}", levels=_levels(panel)
            ),
            note=note if index == last else "",
            wide=len(figure.panels) == 1,
        )
        for index, panel in enumerate(figure.panels)
    )


def _lines(panel: Panel) -> Iterator[Line]:
    for index, curves in enumerate(panel.curves):
        yield from component_lines(
            AXES, curves.time, curves.values, style=_STYLES[curves.style], listed=index == len(panel.curves) - 1
        )


def _levels(panel: Panel) -> tuple[Level, ...]:
    if panel.limit is None:
        return ()
    values = sorted({float(limit) for limit in panel.limit})
    return (Level(name="what the torque limits allow", values=(*values, *(-value for value in values))),)
