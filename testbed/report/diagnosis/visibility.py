"""What the data can show: the smallest detectable size of every effect, and which of them are confounded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Array
from testbed.diagnosis.detectable import (
    Detectable,
    confounded,
    detectable_sizes,
    distances,
    first_screening,
    shown_signatures,
)
from testbed.diagnosis.result import needs_of, unconfounded_needs
from testbed.diagnosis.signatures import Signature
from testbed.diagnosis.state import Diagnosis
from testbed.report.diagnosis.sizes import lacking, size_lines, smallest_words
from testbed.report.frame.blocks import Block, Cell, Column, Figure, Section, Table
from testbed.report.frame.style import color, layout
from testbed.report.wording import figures


def visibility_section(diagnosis: Diagnosis) -> Iterator[Section]:
    """Yield the section, once the effects were looked at."""
    if first_screening(diagnosis) is None:
        return
    sizes = detectable_sizes(diagnosis)
    seen = tuple(each for each in shown_signatures(first_screening(diagnosis)) if each.rank)
    blocks: list[Block] = [_heat_map(seen)] if seen else []
    blocks += [_lines_table(diagnosis), *_frequencies(sizes), _sizes_table(sizes)]
    yield Section(title="What these data can show", blocks=tuple(blocks))
    rows = tuple(_untestable(diagnosis, sizes))
    if rows:
        columns = (Column(title="Effect"), Column(title="component"), Column(title="would take"))
        yield Section(title="Untestable", blocks=(Table(columns=columns, rows=rows, numeric=False),))


def _heat_map(seen: Sequence[Signature]) -> Figure:
    names, apart = by_effect(seen)
    hover = "%{y} and %{x}: %{z:.2f}<extra></extra>"
    scale = [[0.0, color("alike")], [0.5, color("grid")], [1.0, color("apart")]]
    heat = go.Heatmap(
        x=names, y=names, z=apart, zmin=0.0, zmax=1.0, colorscale=scale, hovertemplate=hover, colorbar={"thickness": 12}
    )
    chart = go.Figure(heat, layout=layout("", ""))
    chart.update_layout(hovermode="closest")
    chart.update_yaxes(autorange="reversed", tickfont={"size": 10}, dtick=1, showgrid=False)
    chart.update_xaxes(tickangle=-60, tickfont={"size": 10}, dtick=1, showgrid=False)
    note = (
        "Sine of the angle between what two effects can do to these data, inertia and initial rates projected out: 0 "
        "for aliases, 1 for orthogonal signatures. Of an effect with several components the closest pair; on the "
        "diagonal its own components among each other."
    )
    return Figure(title="How distinguishable the effects are", chart=chart, note=note, wide=True, tall=True)


def by_effect(seen: Sequence[Signature]) -> tuple[list[str], Array]:
    """Return effects and the distance of the closest components of every two, shape (E, E); NaN for one of its kind.

    Args:
        seen: signatures that are not zero.
    """
    apart = distances(tuple(seen)) + np.diag(np.full(len(seen), np.nan))
    names = list(dict.fromkeys(each.placed.effect.id for each in seen))
    of = np.array([names.index(each.placed.effect.id) for each in seen])
    closest = np.full((len(names), len(names)), np.inf)
    for row, col in np.ndindex(apart.shape):
        if row != col:
            closest[of[row], of[col]] = min(closest[of[row], of[col]], apart[row, col])
    return names, np.where(np.isfinite(closest), closest, np.nan)


def _lines_table(diagnosis: Diagnosis) -> Table:
    """Return a row for each effect; of several components, from the most to the least visible."""
    titles = (
        "Effect",
        "components",
        "typical size",
        "smallest detectable",
        "times typical",
        "hard to distinguish from",
    )
    rows = tuple(
        (
            Cell(text=line.effect),
            Cell(text=str(line.components)),
            Cell(text=line.typical),
            Cell(text=line.smallest),
            Cell(text=line.multiple, tone="plain" if line.seen == line.components else "warn"),
            Cell(text=line.confounded),
        )
        for line in size_lines(diagnosis)
    )
    note = (
        "The size that is found in nine of ten such data sets at 5 % false alarms over all effects together, inertia "
        "and initial rates re-estimated; of effects with several components, from the most to the least visible one, "
        "of effects whose frequency is not known, from the best to the worst frequency."
    )
    return Table(columns=tuple(Column(title=title) for title in titles), rows=rows, note=note, numeric=False)


def _frequencies(sizes: Sequence[Detectable]) -> Iterator[Figure]:
    """Yield the smallest detectable sizes over the frequency of effects that have one."""
    scanned = [size for size in sizes if size.by_frequency]
    if not scanned:
        return
    chart = go.Figure(layout=layout("frequency, Hz", "smallest detectable size, times typical"))
    for size, stroke in zip(scanned, ("fitted", "held-out", "extended", "nominal"), strict=False):
        seen = [one for one in size.by_frequency if one.smallest]
        chart.add_scatter(
            x=[one.smallest[0].value for one in seen],
            y=[one.multiple for one in seen],
            name=size.placed.effect.id,
            mode="lines+markers",
            line={"color": color(stroke), "width": 1.5},
            hovertemplate="%{y:.3~g} times typical at %{x:.3~g} Hz",
        )
    chart.update_xaxes(type="log")
    chart.update_yaxes(type="log")
    note = (
        "An effect whose frequency is not known is looked for at each of these; shown is the axis that "
        "shows it the least. The table has the range."
    )
    yield Figure(title="Smallest detectable size by frequency", chart=chart, note=note, wide=True)


def _sizes_table(sizes: Sequence[Detectable]) -> Table:
    titles = ("Effect", "component", "smallest detectable", "times typical")
    rows = tuple(
        (
            Cell(text=size.placed.effect.id),
            Cell(text=size.placed.component),
            Cell(text=smallest_words([size])),
            Cell(
                text=figures(size.multiple, 2) if np.isfinite(size.multiple) else "",
                tone="plain" if size.seen_when_typical else "warn",
            ),
        )
        for size in sizes
    )
    columns = tuple(Column(title=title) for title in titles)
    return Table(columns=columns, rows=rows, numeric=False, folded="Of every component")


def _untestable(diagnosis: Diagnosis, sizes: Sequence[Detectable]) -> Iterator[tuple[Cell, ...]]:
    for needs, effects in lacking(diagnosis).items():
        yield Cell(text=", ".join(effects)), Cell(text=""), Cell(text=needs)
    for size in sizes:
        if not size.seen_when_typical:
            yield Cell(text=size.placed.effect.id), Cell(text=size.placed.component), Cell(text=needs_of(size))
    for placed, by in confounded(diagnosis):
        yield Cell(text=placed.effect.id), Cell(text=placed.component), Cell(text=unconfounded_needs(by))
