"""Two assumptions of the paper: that drift is negligible over 5 s, and that the residual is white at γ = 0.8 s."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.report.frame.blocks import Block, Figure, Paragraph, Section, Table
from testbed.report.frame.style import color, layout
from testbed.report.reproduction.rows import Row, parameter_columns, ratio_row
from testbed.report.wording import figures
from testbed.reproduction.claims import MOST_DRIFT_EFFECT, PAPER_TIME_CONSTANT, drift_effect
from testbed.reproduction.table2 import BIAS_INSTABILITY, RATE_RANDOM_WALK, ManeuverStatistics
from testbed.reproduction.whiteness import Whiteness


def assumptions_section(maneuvers: Sequence[ManeuverStatistics], whiteness: Whiteness) -> Section:
    """Return what a drifting gyro changes, and how white the residual is."""
    blocks: tuple[Block, ...] = (_drift_text(maneuvers), _drift_table(maneuvers), _whiteness_figure(whiteness))
    return Section(title="Drift and whiteness", blocks=blocks)


def _drift_text(maneuvers: Sequence[ManeuverStatistics]) -> Paragraph:
    return Paragraph(
        text=f"The paper calls drift negligible over 5 s. The first {maneuvers[0].drift.runs} flights again, same "
        f"seeds, with a gyro whose bias wanders by {figures(BIAS_INSTABILITY)} rad/s and walks at "
        f"{figures(RATE_RANDOM_WALK)} rad/s/√s:"
    )


def _drift_table(maneuvers: Sequence[ManeuverStatistics]) -> Table:
    return Table(
        columns=parameter_columns("With drift, instrumental variable", unit=""),
        rows=tuple(row for maneuver in maneuvers for row in _drift_rows(maneuver)),
        note="The first row of each maneuver: its standard deviations with drift over those without; in bold, off by "
        f"more than {MOST_DRIFT_EFFECT:.0%}. The second: by how much the mean moves, in standard deviations.",
    )


def _drift_rows(maneuver: ManeuverStatistics) -> Iterator[Row]:
    steady, drift = (campaign.estimators["iv"] for campaign in (maneuver.steady, maneuver.drift))
    ratio = 1.0 + drift_effect(maneuver)
    yield ratio_row(maneuver.title, ratio, low=1 - MOST_DRIFT_EFFECT, high=1 + MOST_DRIFT_EFFECT, tone="plain")
    yield ratio_row("shift of the mean", (drift.mean_error - steady.mean_error) / steady.std)


def _whiteness_figure(whiteness: Whiteness) -> Figure:
    chart = go.Figure(layout=layout("prefilter time constant γ, s", "autocorrelation of the residual"))
    for lag, values in enumerate(whiteness.autocorrelation.T, start=1):
        chart.add_scatter(
            x=whiteness.time_constant,
            y=np.round(values, 4),
            mode="lines+markers",
            name=f"lag {lag}",
            opacity=1.0 if lag == 1 else 0.4,
            line={"color": color("axis-x" if lag == 1 else "faint"), "width": 2 if lag == 1 else 1},
            showlegend=lag < 3,
            hoverinfo="skip" if lag > 2 else None,
        )
    chart.update_xaxes(type="log", tickvals=whiteness.time_constant, hoverformat="")
    chart.add_hrect(
        y0=-whiteness.white_band, y1=whiteness.white_band, fillcolor=color("bound"), line_width=0, layer="below"
    )
    chart.add_vline(x=PAPER_TIME_CONSTANT, line={"color": color("limit"), "width": 1, "dash": "dash"})
    return Figure(
        title="The IV's residual against the prefilter",
        chart=chart,
        note=f"Mean over the axes and over {whiteness.flights} flights of the D-opt maneuver. Grey band: 95 % of one "
        f"white flight's values. Dashed: the paper's γ = {PAPER_TIME_CONSTANT} s. Lags in samples of 1/16 s; pale: "
        f"lags 2 to {whiteness.autocorrelation.shape[1]}.",
        wide=True,
    )
