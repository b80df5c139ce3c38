"""The box plot of a campaign: where the errors of every estimator lie, beside the bound."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import pyarrow as pa
import pyarrow.compute as pc

from testbed.arrays import Array, Theta
from testbed.campaign.statistics import CampaignStatistics, errors_of
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import inertia_unit
from testbed.report.frame.blocks import Figure
from testbed.report.frame.style import color, layout
from testbed.report.wording import BAND, ESTIMATOR_NAMES, estimator_name

_GROUP_WIDTH = 0.84
"""Of the space of one parameter."""
_PLACES = np.arange(len(PARAMETER_NAMES), dtype=np.float64)
_QUANTILES = (0.025, 0.25, 0.5, 0.75, 0.975)


def errors_figure(table: pa.Table, statistics: CampaignStatistics) -> Figure:
    """Return the box plot of all estimators' errors.

    Args:
        table: the runs.
        statistics: of them.
    """
    unit = inertia_unit(statistics.true_theta)
    chart = go.Figure(layout=layout("", f"estimate minus truth, {unit.text}"))
    if np.isfinite(statistics.bound_std).all():
        _add_bound(chart, unit.per_SI * statistics.bound_std)
    flown = table.filter(pc.equal(table["outcome"], "completed"))
    count = len(statistics.estimators)
    for place, name in enumerate(statistics.estimators):
        offset = 0.9 * _GROUP_WIDTH * ((place + 0.5) / count - 0.5)
        _add_boxes(chart, name, unit.per_SI * errors_of(flown, name), _PLACES + offset, 0.6 * _GROUP_WIDTH / count)
    chart.update_xaxes(tickvals=_PLACES, ticktext=PARAMETER_NAMES, showgrid=False, zeroline=False)
    chart.update_layout(hovermode="closest", boxmode="overlay", barmode="overlay")
    return Figure(
        title="Errors of the estimates",
        chart=chart,
        note="Boxes hold the middle half of the runs, whiskers the middle 95 %, the line is the median, the dot the "
        f"mean. Grey: ±{BAND} std of the Cramér-Rao bound; whiskers of an efficient estimator end with it.",
        wide=True,
    )


def _add_bound(chart: go.Figure, std: Theta) -> None:
    reach = BAND * std
    band = {"color": color("bound"), "line": {"width": 0}}
    place = {"x": _PLACES, "y": 2 * reach, "base": -reach, "width": _GROUP_WIDTH}
    chart.add_bar(**place, name="bound", marker=band, customdata=reach, hovertemplate="±%{customdata:.3~g}")


def _add_boxes(chart: go.Figure, name: str, errors: Array, places: Theta, width: float) -> None:
    stroke = color(f"estimator-{list(ESTIMATOR_NAMES).index(name) + 1}")
    lower, first, median, third, upper = np.quantile(errors, _QUANTILES, axis=0)
    box = {"q1": first, "median": median, "q3": third, "lowerfence": lower, "upperfence": upper}
    chart.add_box(
        x=places,
        **box,
        width=width,
        line={"color": stroke, "width": 1.5},
        whiskerwidth=0.6,
        name=estimator_name(name),
        legendgroup=name,
    )
    chart.add_scatter(
        x=places,
        y=errors.mean(axis=0),
        mode="markers",
        marker={"color": stroke, "size": 5},
        name=f"mean, {estimator_name(name)}",
        legendgroup=name,
        showlegend=False,
        hovertemplate="%{y:+.3~g}",
    )
