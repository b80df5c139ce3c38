"""Two assumptions of the paper: drift is negligible over 5 s, and the residual reasonably white at γ = 0.8 s."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.report.frame.blocks import Block, Cell, Column, Figure, Paragraph, Section, Table
from testbed.report.frame.style import color, layout
from testbed.report.reproduction.rows import Row, parameter_columns, ratio_row
from testbed.report.wording import figures
from testbed.reproduction.claims import MOST_DRIFT_EFFECT, drift_effect
from testbed.reproduction.table2 import BIAS_INSTABILITY, RATE_RANDOM_WALK, ManeuverStatistics
from testbed.reproduction.whiteness import PAPER_TIME_CONSTANT, Whiteness


def assumptions_section(maneuvers: Sequence[ManeuverStatistics], whiteness: Whiteness) -> Section:
    """Return what a drifting gyro changes, and how white the residual is."""
    blocks: tuple[Block, ...] = (
        _drift_text(maneuvers),
        _drift_table(maneuvers),
        _whiteness_figure(whiteness),
        _whiteness_table(whiteness),
    )
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
            line={"color": color("estimator-2" if lag == 1 else "faint"), "width": 2 if lag == 1 else 1},
            showlegend=lag < 3,
            hoverinfo="skip" if lag > 2 else None,
        )
    chart.add_scatter(
        x=whiteness.time_constant,
        y=np.round(whiteness.predicted[:, 0], 4),
        mode="lines",
        name="lag 1, predicted",
        line={"color": color("estimator-2"), "width": 1, "dash": "dash"},
    )
    chart.update_xaxes(type="log", tickvals=whiteness.time_constant, hoverformat="")
    chart.add_hrect(
        y0=-whiteness.white_band, y1=whiteness.white_band, fillcolor=color("bound"), line_width=0, layer="below"
    )
    chart.add_vline(x=PAPER_TIME_CONSTANT, line={"color": color("limit"), "width": 1, "dash": "dash"})
    return Figure(
        title="The IV's residual against the prefilter",
        chart=chart,
        note=f"Over the axes and {whiteness.flights} flights of the D-opt maneuver. Grey band: 95 % of such means of a "
        f"white residual, ± {whiteness.white_band:.3f}. Dashed curve: what prefilter and fit make of a white gyro at "
        f"lag 1. Dashed line: the paper's γ = {PAPER_TIME_CONSTANT} s. Lags in samples of 1/16 s; pale: lags 2 to "
        f"{whiteness.autocorrelation.shape[1]}.",
        wide=True,
    )


def _whiteness_table(whiteness: Whiteness) -> Table:
    suppositions = (
        ("white", whiteness.white_chi_square),
        ("the residual of a fit to a white error", whiteness.fit_chi_square),
        ("what prefilter and fit make of a white gyro", whiteness.predicted_chi_square),
    )
    return Table(
        columns=(
            Column(title="Residual taken for"),
            *(Column(title=f"γ = {time}", unit="s") for time in whiteness.time_constant),
        ),
        rows=tuple(
            (
                Cell(text=name),
                *(
                    Cell(text=f"{one:.1f}", tone="warn" if one > whiteness.largest_chi_square else "plain")
                    for one in found
                ),
            )
            for name, found in suppositions
        ),
        note=f"Chi-square of {whiteness.autocorrelation.shape[1]} autocorrelations with their exact covariance. In "
        f"bold: beyond {whiteness.largest_chi_square:.0f}, which chance exceeds once in a thousand times. The "
        "prefilter passes noise less its low frequencies, the fit of six parameters takes out those of the motion: "
        "both make neighbours differ in sign, whatever the noise.",
    )
