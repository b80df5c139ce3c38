"""The ladder of gaps, what was added on each rung, and where the gap was."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from math import isclose

import numpy as np
import plotly.graph_objects as go

from testbed.diagnosis.findings import Addition, additions
from testbed.diagnosis.location import Place
from testbed.diagnosis.state import Diagnosis, Gap
from testbed.report.diagnosis_verdict import effect_name
from testbed.report.frame.blocks import Block, Cell, Column, Figure, Paragraph, Section, Table
from testbed.report.frame.style import color, layout
from testbed.report.wording import BAND, figures, listed

_SAME = 1e-6
"""Share by which a gap differs when it is computed twice in the same noise."""


def gaps_section(diagnosis: Diagnosis) -> Section:
    """Return the ladder of gaps and the table of what was added."""
    blocks: list[Block] = [_ladder(diagnosis)]
    rows = tuple(_rows(diagnosis))
    blocks += [_sentences(diagnosis), _table(rows)] if rows else []
    return Section(title="The gap, step by step", blocks=tuple(block for block in blocks if block is not None))


def where_section(places: Sequence[Place]) -> Section:
    """Return where the gap was before anything was added."""
    if not places:
        text = "No stretch of any axis leaves more than noise once inertia and initial rates are re-estimated."
        return Section(title="Where the gap is", blocks=(Paragraph(text=text),))
    titles = ("Signal", "run", "from, s", "to, s", "share of the residual", "goes along with", "as", "correlation")
    rows = tuple(
        (
            Cell(text=place.signal),
            Cell(text=place.run),
            Cell(text=f"{place.from_s:.3f}"),
            Cell(text=f"{place.to_s:.3f}"),
            Cell(text=f"{place.share:.1%}"),
            Cell(text=place.depends_on or "nothing"),
            Cell(text=place.enters_as or ""),
            Cell(text=f"{place.correlation:+.2f}" if place.depends_on else ""),
        )
        for place in places
    )
    note = (
        "Before anything was added. The stretch of each axis and run with the most power beyond noise; the share is of "
        "the whole residual's power, noise included. A reading goes straight into the gyro's samples, a torque as its "
        "integral; both after all that inertia and initial rates can explain."
    )
    table = Table(columns=tuple(Column(title=title) for title in titles), rows=rows, note=note, numeric=False)
    return Section(title="Where the gap is", blocks=(table,))


def _ladder(diagnosis: Diagnosis) -> Figure:
    rungs = list(_rungs(diagnosis))
    chart = go.Figure(layout=layout("", "rms of (measured - predicted) / σ"))
    places = list(range(len(rungs)))
    for name, values, stroke in (
        ("fitted runs", [gap.fit for _, gap in rungs], "axis-z"),
        ("held-out runs", [gap.heldout for _, gap in rungs], "axis-x"),
    ):
        if np.isfinite(values).all():
            marker = {"color": color(stroke), "size": 9}
            line = {"color": color(stroke), "width": 1.5}
            chart.add_scatter(x=places, y=values, name=name, mode="lines+markers", marker=marker, line=line)
    dashes = {"color": color("limit"), "width": 1.2, "dash": "dash"}
    ends = [-0.4, len(rungs) - 0.6]
    chart.add_scatter(x=ends, y=[1.0, 1.0], name="noise alone", mode="lines", line=dashes, hoverinfo="skip")
    chart.update_xaxes(
        tickvals=places, ticktext=[name for name, _ in rungs], range=ends, showgrid=False, zeroline=False
    )
    chart.update_yaxes(rangemode="normal")
    return Figure(title="Gap after each step", chart=chart, wide=True)


def _rungs(diagnosis: Diagnosis) -> Iterator[tuple[str, Gap]]:
    """Yield the gap after each change; where the noise was told anew before a step or at the end, in that noise."""
    last = diagnosis.gap_before
    yield "nominal, inertia re-estimated", last
    for (before, after), together in groupby(additions(diagnosis), key=lambda each: (each.before, each.after)):
        if not isclose(before.fit, last.fit, rel_tol=_SAME):
            yield "noise told anew", before
        yield "+ " + listed(effect_name(each.effect, each.component) for each in together), after
        last = after
    if not isclose(diagnosis.gap.fit, last.fit, rel_tol=_SAME):
        yield "noise told anew", diagnosis.gap


def _sentences(diagnosis: Diagnosis) -> Paragraph:
    alike = [
        f"These data do not tell {each.effect.id} from "
        f"{listed(effect_name(other.effect, other.component) for other in each.look_alikes)}. What would: "
        f"{each.effect.confirm}"
        for each in diagnosis.added
        if each.look_alikes
    ]
    return Paragraph(text=" ".join([*(each.effect.told(each.component) for each in diagnosis.added), *alike]))


def _rows(diagnosis: Diagnosis) -> Iterator[tuple[Cell, ...]]:
    for addition in additions(diagnosis):
        yield from _quantity_rows(addition)


def _quantity_rows(addition: Addition) -> Iterator[tuple[Cell, ...]]:
    for index, each in enumerate(addition.quantities):
        reach = BAND * each.std
        texts = (
            effect_name(addition.effect, addition.component) if index == 0 else "",
            each.name,
            figures(each.value, 4),
            f"{figures(each.value - reach, 4)} to {figures(each.value + reach, 4)}",
            each.unit,
            f"{addition.probability:.3f}" if index == 0 else "",
        )
        yield tuple(Cell(text=text) for text in texts)


def _table(rows: tuple[tuple[Cell, ...], ...]) -> Table:
    titles = ("Effect", "parameter", "value", "95 % interval", "unit", "probability")
    note = "Probability: exp(evidence/2) among all effects that were compared in that step, none and unknown."
    return Table(columns=tuple(Column(title=title) for title in titles), rows=rows, note=note, numeric=False)
