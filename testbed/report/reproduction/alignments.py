"""The paper's future work: null motion that makes the actuators' alignments observable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.report.frame.blocks import Block, Cell, Column, Figure, Paragraph, Section, Table
from testbed.report.frame.style import color, layout
from testbed.report.reproduction.rows import text_rows
from testbed.report.wording import figures
from testbed.reproduction.alignment_flights import AXIS_SPREAD, SCALE_SPREAD
from testbed.reproduction.alignments import Alignments, SteeringStatistics


def alignments_section(found: Alignments) -> Section:
    """Return what was estimated with null motion and without, and what stays unobservable."""
    blocks: tuple[Block, ...] = (
        _introduction(found),
        _gain_figure(found),
        _table(found),
        _null_space((found.null_motion, found.pseudo_inverse)),
    )
    return Section(title="Actuator alignments", blocks=blocks)


def _introduction(found: Alignments) -> Paragraph:
    null_motion, pseudo_inverse = found.null_motion, found.pseudo_inverse
    return Paragraph(
        text=f"Inertia, gimbal axes, encoder zeros and momentum scales of the six units, {len(found.names)} "
        f"parameters, from one record. {found.runs} platforms, each built out of alignment in its own way "
        f"({AXIS_SPREAD} rad, {SCALE_SPREAD:.0%} of the momentum), fly the same body rates twice: with the null motion "
        f"designed for these parameters, and by pseudo-inverse steering. Without an estimate: {null_motion.failed} and "
        f"{pseudo_inverse.failed}. At a limit on average: {null_motion.saturated:.2g} and "
        f"{pseudo_inverse.saturated:.2g} s."
    )


def _gain_figure(found: Alignments) -> Figure:
    chart = go.Figure(layout=layout("", "scatter without / with null motion"))
    chart.add_bar(x=found.names, y=np.round(found.scatter_ratio, 3), marker={"color": color("single")}, name="ratio")
    chart.add_hline(y=1.0, line={"color": color("ink"), "width": 1})
    chart.add_hline(y=found.median_ratio, line={"color": color("limit"), "width": 1.2, "dash": "dash"})
    chart.update_xaxes(showgrid=False, tickangle=-60, tickfont={"size": 10})
    chart.update_layout(hovermode="closest", showlegend=False)
    return Figure(
        title="How many times smaller the scatter is with null motion",
        chart=chart,
        note=f"Dashed: the median, {found.median_ratio:.2f}.",
        wide=True,
    )


def _table(found: Alignments) -> Table:
    columns = (
        Column(title="Parameter"),
        Column(title="unit"),
        Column(title="scatter", unit="null motion"),
        Column(title="scatter", unit="pseudo-inverse"),
        Column(title="ratio"),
        Column(title="scatter / claimed", unit="null motion"),
        Column(title="95 % intervals hold", unit="null motion"),
        Column(title="95 % intervals hold", unit="pseudo-inverse"),
    )
    low, high = found.coverage_range
    rows = tuple(_row(found, index) for index in range(len(found.names)))
    note = f"In bold: a share that honest intervals of {found.runs} platforms do not have, {low:.0%} to {high:.0%}."
    return Table(columns=columns, rows=rows, note=note)


def _row(found: Alignments, index: int) -> tuple[Cell, ...]:
    with_it, without = found.null_motion, found.pseudo_inverse
    texts = (
        found.names[index],
        found.units[index],
        figures(with_it.scatter[index]),
        figures(without.scatter[index]),
        f"{found.scatter_ratio[index]:.2f}",
        f"{with_it.scatter[index] / with_it.claimed[index]:.2f}",
    )
    return (
        *(Cell(text=text) for text in texts),
        *(_coverage(found, each.coverage[index]) for each in (with_it, without)),
    )


def _coverage(found: Alignments, share: float) -> Cell:
    low, high = found.coverage_range
    return Cell(text=f"{share:.0%}", tone="plain" if low <= share <= high else "warn")


def _null_space(flown: Sequence[SteeringStatistics]) -> Table:
    columns = (Column(title="Steering"), Column(title="what stays unobservable: null space of the first record"))
    rows = text_rows((each.steering, line) for each in flown for line in each.null_space or ("nothing",))
    return Table(columns=columns, rows=rows, numeric=False)
