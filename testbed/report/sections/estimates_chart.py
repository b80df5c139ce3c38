"""The chart of the estimates: for each parameter the distance from the truth, with bands, beside the bound."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Series, Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import inertia_unit
from testbed.report.frame.style import color, layout
from testbed.report.sections.inertias import Inertias
from testbed.report.wording import BAND, ESTIMATOR_NAMES, estimator_name

_BAND_WIDTH = 0.84
"""Of the space of one parameter."""
_SYMBOLS = ("circle", "square", "diamond", "triangle-up")
_PLACES = np.arange(len(PARAMETER_NAMES), dtype=np.float64)


def estimates_chart(inertias: Inertias) -> go.Figure:
    """Return the chart; its zero line is the truth, or the nominal θ where nobody knows it."""
    unit = inertia_unit(inertias.nominal)
    chart, scale = go.Figure(layout=layout("", f"difference, {unit.text}")), unit.per_SI
    if inertias.bound_std is not None:
        _add_bound(chart, scale * inertias.bound_std, scale * (inertias.bound_center - inertias.origin))
    count = len(inertias.by_name)
    for place, (name, estimate) in enumerate(inertias.by_name.items()):
        offset = 0.8 * _BAND_WIDTH * ((place + 0.5) / count - 0.5)
        difference = scale * (estimate.theta - inertias.origin)
        _add_estimate(chart, name, difference, scale * estimate.std, _PLACES + offset)
    if inertias.truth is not None:
        _add_nominal(chart, scale * (inertias.nominal - inertias.truth))
    chart.update_xaxes(tickvals=_PLACES, ticktext=PARAMETER_NAMES, showgrid=False, zeroline=False)
    return chart.update_layout(hovermode="closest")


def _add_bound(chart: go.Figure, std: Theta, center: Theta) -> None:
    reach = BAND * std
    place = {"x": _PLACES, "y": 2 * reach, "base": center - reach, "width": _BAND_WIDTH}
    band = {"color": color("bound"), "line": {"width": 0}}
    chart.add_bar(**place, name="bound", marker=band, customdata=reach, hovertemplate="±%{customdata:.3~g}")


def _add_estimate(chart: go.Figure, name: str, difference: Theta, std: Theta, places: Series) -> None:
    order = list(ESTIMATOR_NAMES).index(name)
    stroke = color(f"estimator-{order + 1}")
    chart.add_scatter(
        x=places,
        y=difference,
        error_y={"array": BAND * std, "color": stroke, "thickness": 2, "width": 4},
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
        y=offset,
        mode="markers",
        marker=mark,
        name="nominal",
        visible="legendonly",
        hovertemplate="%{y:+.3~g}",
    )
