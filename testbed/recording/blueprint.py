"""The layout that travels in the recording: tabs for the flight, the actuators, the estimates, the provenance."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import rerun.blueprint as rrb

from testbed.recording.chart import BOUNDS
from testbed.recording.stream import TIMELINE

BACKGROUND = (18, 21, 28)
TITLES = {
    "body_rate": "Body rate, B [rad/s]",
    "tracking_error": "Tracking error: true - reference, B [rad/s]",
    "cluster_momentum": "Cluster momentum h, B, and its limits [N·m·s]",
    "envelope_fraction": "Share of the momentum envelope in use",
    "cluster_torque": "Cluster torque -dh/dt, B, and its limits [N·m]",
    "gimbal_angle": "Gimbal angle [rad]",
    "gimbal_rate": "Gimbal rate and its limit [rad/s]",
    "gimbal_torque": "Gimbal motor torque and its limit [N·m]",
    "rotor_speed": "Rotor speed and its limit [rad/s]",
    "singularity_measure": "Singularity measure, 1 at the best",
    "applied_torque": "Applied torque, B [N·m]",
}
"""Plots, by the first part of their entities' paths."""

_EYE = (0.36, -0.13, 0.19)
"""m, from the origin of N."""
_EVENT_COLUMNS = rrb.archetypes.TextLogColumns(timeline_columns=[TIMELINE], text_log_columns=["Body"])


def blueprint(roots: Collection[str], residual_units: dict[str, str]) -> rrb.Blueprint:
    """Return the layout.

    Args:
        roots: first parts of the paths of what the recording holds; what it does not hold gets no view.
        residual_units: unit of each estimator's residual.
    """
    return whole_layout((_flight(roots), _actuators(roots), _estimates(roots, residual_units), _provenance()))


def whole_layout(tabs: Sequence[rrb.Container]) -> rrb.Blueprint:
    """Return a layout of tabs over the flight's time, the viewer's own panels out of the way."""
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=0),
        rrb.TimePanel(timeline=TIMELINE, play_state="paused", state="collapsed"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
        auto_layout=False,
    )


def _flight(roots: Collection[str]) -> rrb.Horizontal:
    plots = _plots(roots, ("body_rate", "tracking_error", "cluster_momentum", "envelope_fraction", "applied_torque"))
    return rrb.Horizontal(scene_view(), rrb.Vertical(*plots), column_shares=(5, 4), name="Flight")


def _actuators(roots: Collection[str]) -> rrb.Horizontal:
    left = _plots(roots, ("gimbal_angle", "gimbal_rate", "gimbal_torque"))
    right: list[rrb.View] = _plots(roots, ("rotor_speed", "cluster_torque", "singularity_measure"))
    shares = [2] * len(right)
    if "saturation" in roots:
        right.append(rrb.StateTimelineView(origin="/saturation", name="Limit that each unit is at"))
        shares.append(3)
    return rrb.Horizontal(rrb.Vertical(*left), rrb.Vertical(*right, row_shares=shares), name="Actuators")


def _estimates(roots: Collection[str], residual_units: dict[str, str]) -> rrb.Horizontal:
    residuals = [
        plot_view(f"/residual/{name}", f"Residual, {name}: measured - predicted, B [{unit}]")
        for name, unit in residual_units.items()
    ]
    table = rrb.TextDocumentView(origin="/result", name="Result")
    chart = [_chart()] if "estimates" in roots else []
    right = [rrb.Vertical(*residuals)] if residuals else []
    return rrb.Horizontal(rrb.Vertical(*chart, table, row_shares=(3, 2)[-len(chart) - 1 :]), *right, name="Estimates")


def _provenance() -> rrb.Horizontal:
    return rrb.Horizontal(
        rrb.TextDocumentView(origin="/provenance", name="Provenance"),
        rrb.TextLogView(origin="/events", name="Events", columns=_EVENT_COLUMNS),
        column_shares=(2, 1),
        name="Provenance",
    )


def scene_view(distance: float = 1.0) -> rrb.Spatial3DView:
    """Return the view of the platform in flight.

    Args:
        distance: of the eye; at 1 a platform that stays in place fills the view.
    """
    eye = tuple(distance * coordinate for coordinate in _EYE)
    return rrb.Spatial3DView(
        origin="/",
        contents=["/platform/**", "/total_momentum/**", "/world/**"],
        name="Platform, N; arrows: body rate ω, cluster momentum h, total momentum H",
        background=BACKGROUND,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=eye, look_target=(0.0, 0.0, 0.0), eye_up=(0.0, 0.0, 1.0)),
    )


def _chart() -> rrb.Spatial2DView:
    x_range, y_range = BOUNDS
    return rrb.Spatial2DView(
        origin="/estimates",
        name="Estimates beside the Cramér-Rao bound (grey band)",
        background=BACKGROUND,
        visual_bounds=rrb.VisualBounds2D(x_range=x_range, y_range=y_range),
    )


def _plots(roots: Collection[str], names: Sequence[str]) -> list[rrb.View]:
    return [plot_view(f"/{name}", TITLES[name]) for name in names if name in roots]


def plot_view(origin: str, title: str) -> rrb.TimeSeriesView:
    """Return a plot over time of everything below a path."""
    return rrb.TimeSeriesView(
        origin=origin,
        name=title,
        axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
    )
