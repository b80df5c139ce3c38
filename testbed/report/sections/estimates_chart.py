"""The chart of the estimates: for each parameter the distance from the truth, with bands, beside the bound."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Series, Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.report.frame.style import color, layout
from testbed.report.sections.inertias import AnyEstimate, Inertias
from testbed.report.wording import BAND, ESTIMATOR_NAMES, INERTIA_UNIT, estimator_name

_BAND_WIDTH = 0.84
"""Of the space of one parameter."""
_SYMBOLS = ("circle", "square", "diamond", "triangle-up")
_PLACES = np.arange(len(PARAMETER_NAMES), dtype=np.float64)


def estimates_chart(inertias: Inertias) -> go.Figure:
    """Return the chart; its zero line is the truth, or the nominal θ where nobody knows it."""
    chart = go.Figure(layout=layout("", f"difference, {INERTIA_UNIT}"))
    if inertias.bound_std is not None:
        _add_bound(chart, inertias.bound_std, inertias.bound_center - inertias.origin)
    count = len(inertias.by_name)
    for place, (name, estimate) in enumerate(inertias.by_name.items()):
        offset = 0.8 * _BAND_WIDTH * ((place + 0.5) / count - 0.5)
        _add_estimate(chart, name, estimate, inertias.origin, _PLACES + offset)
    if inertias.truth is not None:
        _add_nominal(chart, inertias.nominal - inertias.truth)
    chart.update_xaxes(tickvals=_PLACES, ticktext=PARAMETER_NAMES, showgrid=False, zeroline=False)
    return chart.update_layout(hovermode="closest")


def _add_bound(chart: go.Figure, std: Theta, center: Theta) -> None:
    reach = 1e3 * BAND * std
    place = {"x": _PLACES, "y": 2 * reach, "base": 1e3 * center - reach, "width": _BAND_WIDTH}
    band = {"color": color("bound"), "line": {"width": 0}}
    chart.add_bar(**place, name="bound", marker=band, customdata=reach, hovertemplate="±%{customdata:.3~g}")


def _add_estimate(chart: go.Figure, name: str, estimate: AnyEstimate, origin: Theta, places: Series) -> None:
    order = list(ESTIMATOR_NAMES).index(name)
    stroke = color(f"estimator-{order + 1}")
    chart.add_scatter(
        x=places,
        y=1e3 * (estimate.theta - origin),
        error_y={"array": 1e3 * BAND * estimate.std, "color": stroke, "thickness": 2, "width": 4},
        mode="markers",
        marker={"color": stroke, "size": 8, "symbol": _SYMBOLS[order]},
        name=estimator_name(name),
        hovertemplate="%{y:+.3~g} ± %{error_y.array:.3~g}",
    )


def _add_nominal(chart: go.Figure, offset: Theta) -> None:
    """Add the nominal model, hidden at first: it may lie so far off that the bands would shrink to nothing."""
    mark = {"symbol": "line-ew", "size": 30, "line": {"color": color("nominal"), "width": 2}}
    chart.add_scatter(
        x=_PLACES,
        y=1e3 * offset,
        mode="markers",
        marker=mark,
        name="nominal",
        visible="legendonly",
        hovertemplate="%{y:+.3~g}",
    )
