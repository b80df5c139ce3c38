"""The design: how the maneuver was found, and its information."""

from __future__ import annotations

from math import isfinite

import plotly.graph_objects as go

from testbed.maneuver.design import Design, Start
from testbed.report.frame.blocks import Cell, Column, Figure, Section, Table
from testbed.report.frame.style import color, layout
from testbed.report.wording import figures

CRITERIA = {
    "D": "D: largest determinant",
    "A": "A: smallest trace of the inverse",
    "E": "E: largest smallest eigenvalue",
    "condition": "smallest condition number",
}
_PARAMETRIZATIONS = {
    "body_rate": "splines of the body rate",
    "gimbal": "splines of the gimbal angles",
    "actuator": "splines of gimbal angles and wheel momenta",
}
_FEWEST_DRAWN = 2


def design_section(design: Design) -> Section:
    """Return the section of a designed maneuver."""
    chart = (_costs_figure(design),) if len(design.starts) >= _FEWEST_DRAWN else ()
    return Section(title="Design", blocks=(_metrics_table(design), _starts_table(design), *chart))


def _metrics_table(design: Design) -> Table:
    information = design.information
    entries = (
        ("Criterion", CRITERIA[design.criterion]),
        ("Parametrisation", _PARAMETRIZATIONS[design.parametrization]),
        ("Smallest eigenvalue of ΨᵀΨ", figures(information.min_eigenvalue, 4)),
        ("Trace of the inverse of ΨᵀΨ", figures(information.trace_inverse, 4)),
        ("Determinant of ΨᵀΨ", figures(information.determinant, 4)),
        ("Condition number of ΨᵀΨ", figures(information.condition_number, 4)),
        ("Condition number of Ψ", figures(information.regressor_condition_number, 4)),
        ("Set-up", f"{design.setup_seconds:.2f} s"),
    )
    return Table(
        columns=(Column(title="Design"), Column(title="value")),
        rows=tuple((Cell(text=what), Cell(text=value)) for what, value in entries),
        note="Ψ is the regressor Ψ_f behind the prefilter, without noise, in rad/s, as in the paper's Table 1.",
        numeric=False,
        wide=False,
    )


def _starts_table(design: Design) -> Table:
    columns = (Column(title="Start"), Column(title="cost"), Column(title="time", unit="s"), Column(title="optimiser"))
    rows = tuple(_start_row(start, chosen=start.index == design.best) for start in design.starts)
    return Table(columns=columns, rows=rows, note="The lowest cost within all limits was flown.", wide=False)


def _start_row(start: Start, *, chosen: bool) -> tuple[Cell, ...]:
    cost = Cell(text=figures(start.cost, 6)) if isfinite(start.cost) else Cell(text="broke a limit", tone="warn")
    title = f"{start.number}, flown" if chosen else f"{start.number}"
    return (
        Cell(text=title, tone="good" if chosen else "plain"),
        cost,
        Cell(text=f"{start.seconds:.2f}"),
        Cell(text=start.ended),
    )


def _costs_figure(design: Design) -> Figure:
    kept = [start for start in design.starts if isfinite(start.cost)]
    strokes = [color("good") if start.index == design.best else color("faint") for start in kept]
    chart = go.Figure(layout=layout("start", "cost"))
    chart.add_scatter(
        x=[start.number for start in kept],
        y=[start.cost for start in kept],
        mode="markers",
        marker={"color": strokes, "size": 9},
    )
    chart.update_xaxes(dtick=max(1, len(design.starts) // 10))
    return Figure(title="Cost of each start; the lowest was flown", chart=chart)
