"""Figure 3: the box plot of the estimates' errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import MILLI
from testbed.report.frame.blocks import Figure
from testbed.report.frame.style import color, layout
from testbed.reproduction.table2 import ManeuverStatistics

ESTIMATOR = "iv"
"""The paper's."""
_PLACES = np.arange(len(PARAMETER_NAMES), dtype=np.int8)
_QUARTILE = 0.6745
"""Standard deviations from the mean of a normal distribution to its quartiles."""


def box_plot_figure(maneuvers: Sequence[ManeuverStatistics]) -> Figure:
    """Return the box plot of the paper's estimator, and what its Table 2 says of the paper's own."""
    chart = go.Figure(layout=layout("", f"estimate - truth, {MILLI.text}"))
    for maneuver in maneuvers:
        _add_boxes(chart, maneuver)
    chart.update_layout(boxmode="group", boxgap=0.25, boxgroupgap=0.15, hovermode="closest")
    chart.update_xaxes(tickvals=_PLACES, ticktext=PARAMETER_NAMES, showgrid=False, zeroline=False)
    return Figure(
        title="Figure 3: errors of the estimates, by the paper's estimator",
        chart=chart,
        note="Boxes from the lower to the upper quartile with the median, whiskers to the last value within 1.5 boxes, "
        "dots beyond. Pale, without whiskers: what the averages and standard deviations of the paper's Table 2 give "
        "for normal errors, as the paper prints no quartiles.",
        wide=True,
    )


def _add_boxes(chart: go.Figure, maneuver: ManeuverStatistics) -> None:
    stroke = color(f"maneuver-{maneuver.name}")
    if maneuver.paper_std is not None and maneuver.paper_mean is not None:
        _add_paper(chart, maneuver, maneuver.paper_mean - maneuver.true_theta, maneuver.paper_std, stroke)
    errors = maneuver.errors[ESTIMATOR]
    chart.add_box(
        x=np.tile(_PLACES, len(errors)),
        y=(1e3 * errors).astype(np.float32).ravel(),
        boxpoints="outliers",
        marker={"size": 3, "color": stroke},
        line={"color": stroke, "width": 1.5},
        name=maneuver.title,
        offsetgroup=maneuver.name,
        hoveron="boxes",
    )


def _add_paper(chart: go.Figure, maneuver: ManeuverStatistics, mean_error: Theta, std: Theta, stroke: str) -> None:
    middle, half = 1e3 * mean_error, 1e3 * _QUARTILE * std
    chart.add_box(
        x=_PLACES,
        median=middle,
        q1=middle - half,
        q3=middle + half,
        lowerfence=middle - half,
        upperfence=middle + half,
        line={"color": stroke, "width": 1.0},
        opacity=0.45,
        name=f"{maneuver.title}, paper",
        offsetgroup=f"{maneuver.name} paper",
        hoveron="boxes",
    )
