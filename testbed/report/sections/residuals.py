"""The residuals: what each estimator could not explain, and whether it looks like noise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Series, Vectors3
from testbed.estimation.estimate import Estimate
from testbed.palette import AXIS_SHADES
from testbed.report.frame.blocks import Block, Figure, Paragraph
from testbed.report.frame.chart import Level, line_chart
from testbed.report.frame.series import component_lines
from testbed.report.frame.style import color, layout
from testbed.report.wording import BAND, capitalized, estimator_name
from testbed.signals import AXES

MOST_LAGS = 20


def residual_blocks(estimates: Mapping[str, Estimate]) -> tuple[Block, ...]:
    """Return for each estimator the residual over time and its autocorrelation."""
    meaning = Paragraph(
        text="What an estimator could not explain: measured minus predicted. Noise alone leaves the ±2 σ lines once in "
        "twenty samples, and is not correlated from one sample to the next. A bias that the scenario "
        "states to wander stays in the residual, and is taken off before the autocorrelation."
    )
    return meaning, *(figure for name, estimate in estimates.items() for figure in _figures(name, estimate))


def autocorrelation(values: Series, lags: int) -> Series:
    """Return r(k) = Σ e(t) e(t+k) / Σ e(t)² for k = 1 to lags, the mean taken off; shape (lags,).

    Args:
        values: evenly sampled, shape (N,).
        lags: fewer than N.
    """
    centred = values - values.mean()
    power = float(centred @ centred) or 1.0  # a residual of zeros is correlated with nothing
    return np.array([float(centred[:-lag] @ centred[lag:]) / power for lag in range(1, lags + 1)])


def _figures(name: str, estimate: Estimate) -> Iterator[Figure]:
    title = capitalized(estimator_name(name))
    sigma = estimate.residual_sigma
    yield Figure(
        title=f"{title}: residual, body axes",
        chart=line_chart(
            component_lines(AXES, estimate.residual_time, estimate.residual),
            y_title=f"residual, {estimate.residual_unit}",
            levels=[Level(name="±2 σ", values=(2.0 * sigma, -2.0 * sigma))],
        ),
        shares_time=True,
    )
    yield Figure(title=f"{title}: autocorrelation", chart=_correlation_chart(estimate.white_residual))


def _correlation_chart(residual: Vectors3) -> go.Figure:
    count = len(residual)
    lags = min(MOST_LAGS, count - 1)
    chart = go.Figure(layout=layout("lag, samples", "autocorrelation"))
    for axis, values, stroke in zip(AXES, residual.T, AXIS_SHADES, strict=True):
        bars = {"color": color(stroke), "line": {"width": 0}}
        chart.add_bar(x=np.arange(1, lags + 1), y=autocorrelation(values, lags), name=axis, marker=bars)
    for sign in (-1, 1):
        chart.add_scatter(
            x=[0.5, lags + 0.5],
            y=[sign * BAND / np.sqrt(count)] * 2,
            mode="lines",
            line={"color": color("limit"), "width": 1.2, "dash": "dash"},
            name="95 % of white noise",
            legendgroup="band",
            showlegend=sign > 0,
            hoverinfo="skip",
        )
    return chart.update_layout(barmode="group", bargap=0.3)
