"""The ladders of misfits and gaps, what was added on each rung, and where the gap was."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TypeAlias

import numpy as np
import plotly.graph_objects as go

from testbed.diagnosis.findings import Addition, additions
from testbed.diagnosis.location import ResidualSegment
from testbed.diagnosis.misfit import Misfit
from testbed.diagnosis.state import Diagnosis, Gap
from testbed.report.diagnosis.misfit import MEANING, in_other_noise
from testbed.report.diagnosis.verdict import effect_name, names_of_all
from testbed.report.frame.blocks import Block, Cell, Column, Figure, Paragraph, Section, Table
from testbed.report.frame.style import color, layout
from testbed.report.wording import BAND, figures_to, listed

_Rung: TypeAlias = tuple[str, Gap]
_ROLES = ("fitted runs", "held-out runs")
_SIDE_BY_SIDE = 2
"""Rungs whose names can be read on a chart of half the page's width."""


def gaps_section(diagnosis: Diagnosis) -> Section:
    """Return the ladders of misfits and gaps, and the table of what was added."""
    rungs = tuple(_rungs(diagnosis))
    blocks: list[Block] = [_misfit_ladder(rungs), _gap_ladder(rungs)]
    rows = tuple(_rows(diagnosis))
    blocks += [_sentences(diagnosis), _table(rows)] if rows else []
    return Section(title="Misfit and gap, step by step", blocks=tuple(blocks))


def where_section(places: Sequence[ResidualSegment]) -> Section:
    """Return where the gap was before anything was added."""
    if not places:
        text = "No stretch of any axis has a residual beyond noise once inertia and initial rates are re-estimated."
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


def _misfit_ladder(rungs: Sequence[_Rung]) -> Figure:
    misfits = {"fitted": [gap.misfit for _, gap in rungs], "held-out": [gap.heldout_misfit for _, gap in rungs]}
    chart = _ladder(rungs, "misfit beyond noise, σ", [[_sigma(each) for each in own] for own in misfits.values()])
    for stroke, name, own in zip(misfits, _ROLES, misfits.values(), strict=True):
        limits = [each.noise_limit for each in own if each is not None]
        if len(limits) == len(rungs):
            line = {"color": color(stroke), "width": 1.2, "dash": "dash"}
            first, last = _ends(rungs)
            places, heights = [first, *range(len(rungs)), last], [limits[0], *limits, limits[-1]]
            chart.add_scatter(x=places, y=heights, name=f"noise alone, {name}", mode="lines", line=line)
    chart.update_yaxes(rangemode="tozero")
    note = (
        f"In standard deviations, {MEANING}: the root of χ² less its mean. Below the dashed lines noise alone stays in "
        "99 of 100 data sets."
    )
    return Figure(title="Misfit after each step", chart=chart, note=note, wide=len(rungs) > _SIDE_BY_SIDE)


def _gap_ladder(rungs: Sequence[_Rung]) -> Figure:
    values = [[gap.fit for _, gap in rungs], [gap.heldout for _, gap in rungs]]
    chart = _ladder(rungs, "rms of (measured - predicted) / σ", values)
    dashes = {"color": color("limit"), "width": 1.2, "dash": "dash"}
    chart.add_scatter(x=_ends(rungs), y=[1.0, 1.0], name="noise alone", mode="lines", line=dashes, hoverinfo="skip")
    chart.update_yaxes(rangemode="normal")
    note = "Over all samples of all channels, most of which know little of most effects."
    return Figure(title="Gap after each step", chart=chart, note=note, wide=len(rungs) > _SIDE_BY_SIDE)


def _ladder(rungs: Sequence[_Rung], title: str, values: Sequence[Sequence[float]]) -> go.Figure:
    """Return a chart of a figure of every rung, of fitted and held-out runs where they have it."""
    chart = go.Figure(layout=layout("", title))
    places = list(range(len(rungs)))
    for name, stroke, own in zip(_ROLES, ("fitted", "held-out"), values, strict=True):
        if np.isfinite(own).all():
            marker = {"color": color(stroke), "size": 9}
            line = {"color": color(stroke), "width": 1.5}
            chart.add_scatter(
                x=places, y=own, name=name, mode="lines+markers", marker=marker, line=line, cliponaxis=False
            )
    names = [name for name, _ in rungs]
    # The last name is turned out of the chart's side, where plotly would leave it out.
    overflow = {"ticklabeloverflow": "allow", "automargin": True}
    chart.update_xaxes(tickvals=places, ticktext=names, range=_ends(rungs), showgrid=False, zeroline=False, **overflow)
    return chart


def _ends(rungs: Sequence[_Rung]) -> list[float]:
    return [-0.4, len(rungs) - 0.6]


def _sigma(misfit: Misfit | None) -> float:
    return np.nan if misfit is None else misfit.sigma


def _rungs(diagnosis: Diagnosis) -> Iterator[_Rung]:
    """Yield the gap after each change; where the noise was re-estimated before a step or at the end, in that noise."""
    last = diagnosis.gap_before
    yield "nominal, inertia re-estimated", last
    for (before, after), together in groupby(additions(diagnosis), key=lambda each: (each.before, each.after)):
        if in_other_noise(before, last):
            yield "noise re-estimated", before
        yield "+ " + listed(effect_name(each.effect, each.component) for each in together), after
        last = after
    if in_other_noise(diagnosis.gap, last):
        yield "noise re-estimated", diagnosis.gap


def _sentences(diagnosis: Diagnosis) -> Paragraph:
    alike = [
        f"These data do not tell {each.effect.id} from "
        f"{listed(names_of_all(each.look_alikes))}. What would: "
        f"{each.effect.confirm}"
        for each in diagnosis.added
        if each.look_alikes
    ]
    return Paragraph(text=" ".join([*(each.effect.described(each.component) for each in diagnosis.added), *alike]))


def _rows(diagnosis: Diagnosis) -> Iterator[tuple[Cell, ...]]:
    for addition in additions(diagnosis):
        yield from _quantity_rows(addition)


def _quantity_rows(addition: Addition) -> Iterator[tuple[Cell, ...]]:
    for index, each in enumerate(addition.quantities):
        reach = BAND * each.std
        texts = (
            effect_name(addition.effect, addition.component) if index == 0 else "",
            each.name,
            figures_to(each.value, each.std),
            f"{figures_to(each.value - reach, each.std)} to {figures_to(each.value + reach, each.std)}",
            each.unit,
            f"{addition.probability:.3f}" if index == 0 else "",
        )
        yield tuple(Cell(text=text) for text in texts)


def _table(rows: tuple[tuple[Cell, ...], ...]) -> Table:
    titles = ("Effect", "parameter", "value", "95 % interval", "unit", "probability")
    note = "Probability: among all effects that were compared in that step, none and unknown."
    return Table(columns=tuple(Column(title=title) for title in titles), rows=rows, note=note, numeric=False)
