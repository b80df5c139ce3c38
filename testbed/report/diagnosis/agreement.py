"""The size of every effect, estimated run by run: an effect that acts in all runs has one size."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Indices
from testbed.diagnosis.findings import quantities_of
from testbed.diagnosis.run_agreement import Agreement
from testbed.diagnosis.state import Diagnosis
from testbed.effects.contract import Quantity
from testbed.report.diagnosis.verdict import agreement_words, effect_name
from testbed.report.frame.blocks import Figure, Paragraph, Section
from testbed.report.frame.style import color, layout
from testbed.report.wording import BAND

_MOST_NAMED = 12
"""Runs whose names find room below a chart."""


def agreement_section(diagnosis: Diagnosis, agreements: Sequence[Agreement]) -> Iterator[Section]:
    """Yield how the runs agree on what was added, where there are several."""
    if not agreements:
        return
    text = (
        "Each effect estimated in every run by itself, all else shared; the band is the estimate of all fitted runs, "
        "95 %. " + " ".join(f"{_name(each)}: {agreement_words(each)}." for each in agreements)
    )
    figures = tuple(figure for each in agreements for figure in _figures(diagnosis, each))
    yield Section(title="Run by run", blocks=(Paragraph(text=text), *figures))


def _figures(diagnosis: Diagnosis, agreement: Agreement) -> Iterator[Figure]:
    by_run = [agreement.quantities(run) for run in range(len(agreement.runs))]
    for index, together in enumerate(quantities_of(diagnosis.runs, diagnosis.model, agreement.placed)):
        own = [quantities[index] for quantities in by_run]
        if any(np.isfinite(each.std) for each in own):
            yield Figure(title=f"{_name(agreement)}: {together.name}", chart=_chart(agreement, together, own))


def _chart(agreement: Agreement, together: Quantity, own: Sequence[Quantity]) -> go.Figure:
    places = np.arange(len(own))
    unit = "" if together.unit == "1" else f", {together.unit}"
    chart = go.Figure(layout=layout("run", f"{together.name}{unit}"))
    reach = BAND * together.std
    if np.isfinite(reach):
        chart.add_hrect(
            y0=together.value - reach, y1=together.value + reach, fillcolor=color("fitted"), opacity=0.15, line_width=0
        )
    seen = np.isfinite([each.std for each in own])
    for name, which, stroke in (
        ("fitted", ~agreement.heldout & seen, "fitted"),
        ("held out", agreement.heldout & seen, "held-out"),
    ):
        if which.any():
            _add(chart, name, places[which], [each for each, shown in zip(own, which, strict=True) if shown], stroke)
    names = agreement.runs if len(places) <= _MOST_NAMED else tuple(str(place + 1) for place in places)
    chart.update_xaxes(tickvals=places, ticktext=names, range=[-0.5, len(places) - 0.5], showgrid=False, zeroline=False)
    chart.update_layout(hovermode="closest")
    return chart


def _add(chart: go.Figure, name: str, places: Indices, own: Sequence[Quantity], stroke: str) -> None:
    chart.add_scatter(
        x=places,
        y=[each.value for each in own],
        error_y={"array": [BAND * each.std for each in own], "color": color(stroke), "thickness": 1.5},
        mode="markers",
        marker={"color": color(stroke), "size": 7},
        name=name,
        hovertemplate="%{y:.4~g} ± %{error_y.array:.4~g}",
    )


def _name(agreement: Agreement) -> str:
    return effect_name(agreement.placed.effect, agreement.placed.component)
