"""The layout that travels in the recording: tabs for the flight, the actuators, the estimates, the provenance."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import rerun.blueprint as rrb

from testbed.recording.axes import LINKED, SharedTime, value_axis
from testbed.recording.chart import BOUNDS
from testbed.recording.stream import TIMELINE
from testbed.recording.traces import Trace
from testbed.signals import KINDS, SIGNALS

BACKGROUND = (18, 21, 28)


def _title(name: str) -> str:
    """Return the title of a plot of actuators; all that is not an angle has a limit."""
    signal = SIGNALS.get(name) or SIGNALS[f"true_{name}"]
    quantity = signal.label.partition(", ")[0]
    limited = "" if signal.unit == "rad" else " and its limit"
    return f"{quantity[0].upper()}{quantity[1:]}{limited} [{signal.unit}]"


TITLES = {
    "body_rate": "Body rate, B [rad/s]",
    "tracking_error": "Tracking error: true - reference, B [rad/s]",
    "cluster_momentum": "Cluster momentum h, B, and its limits [N·m·s]",
    "envelope_fraction": "Share of the momentum envelope in use",
    "cluster_torque": "Cluster torque -dh/dt, B, and its limits [N·m]",
    **{name: _title(name) for kind in KINDS.values() for name in kind.plots},
    "singularity_measure": "Singularity measure, 1 at the best",
    "applied_torque": "Applied torque, B [N·m]",
}
"""Plots, by the first part of their entities' paths."""

_EYE = (0.36, -0.13, 0.19)
"""m, from the origin of N."""
_EVENT_COLUMNS = rrb.archetypes.TextLogColumns(timeline_columns=[TIMELINE], text_log_columns=["Body"])


def blueprint(traces: Sequence[Trace], others: Collection[str], residual_units: dict[str, str]) -> rrb.Blueprint:
    """Return the layout.

    Args:
        traces: all that the recording holds; what it does not hold gets no view.
        others: first parts of the paths of what it holds besides.
        residual_units: unit of each estimator's residual.
    """
    tabs = (
        _flight(traces),
        _actuators(traces, others),
        _estimates(others),
        *_residuals(traces, residual_units),
        _provenance(),
    )
    return whole_layout(tabs, traces)


def whole_layout(tabs: Sequence[rrb.Container], traces: Sequence[Trace]) -> rrb.Blueprint:
    """Return a layout of tabs over the time of all traces, the viewer's own panels out of the way."""
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=0),
        SharedTime(TIMELINE, [trace.time for trace in traces]),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
        auto_layout=False,
    )


def _flight(traces: Sequence[Trace]) -> rrb.Horizontal:
    plots = _plots(traces, ("body_rate", "tracking_error", "cluster_momentum", "applied_torque"))
    return rrb.Horizontal(flight_view(), rrb.Vertical(*plots), column_shares=(5, 4), name="Flight")


def _actuators(traces: Sequence[Trace], others: Collection[str]) -> rrb.Horizontal:
    """Return three plots in a column at most: lower ones would have no room for the numbers of their axes."""
    left = _plots(traces, ("gimbal_angle", "gimbal_rate", "gimbal_torque"))
    middle = _plots(traces, ("rotor_speed", "cluster_torque", "envelope_fraction"))
    others_too = [name for kind, each in KINDS.items() if kind != "unit" for name in each.plots]
    right: list[rrb.View] = _plots(traces, (*others_too, "singularity_measure"))
    if "saturation" in others:
        right.append(
            rrb.StateTimelineView(origin="/saturation", name="Limit that each actuator is at", time_view=LINKED)
        )
    columns = [rrb.Vertical(*views) for views in (left, middle, right) if views]
    return rrb.Horizontal(*columns, name="Actuators")


def _estimates(others: Collection[str]) -> rrb.Horizontal:
    table = rrb.TextDocumentView(origin="/result", name="Result")
    return rrb.Horizontal(*([_chart()] if "estimates" in others else []), table, name="Estimates")


def _residuals(traces: Sequence[Trace], units: dict[str, str]) -> Iterator[rrb.Grid]:
    """Yield the tab of the residuals, where there are any."""
    views = [
        plot_view(f"/residual/{name}", f"Residual, {name}: measured - predicted, B [{unit}]", traces)
        for name, unit in units.items()
    ]
    if views:
        yield rrb.Grid(*views, grid_columns=2 if len(views) > 1 else 1, name="Residuals")


def _provenance() -> rrb.Horizontal:
    return rrb.Horizontal(
        rrb.TextDocumentView(origin="/provenance", name="Provenance"),
        rrb.TextLogView(origin="/events", name="Events", columns=_EVENT_COLUMNS),
        column_shares=(2, 1),
        name="Provenance",
    )


def flight_view(distance: float = 1.0) -> rrb.Spatial3DView:
    """Return the view of the platform in flight.

    Args:
        distance: of the eye; at 1 a platform that stays in place fills the view.
    """
    name = "Platform, N; arrows: body rate ω, cluster momentum h, total momentum H"
    eye = tuple(distance * coordinate for coordinate in _EYE)
    return scene_view("/", name, eye, ("/platform/**", "/total_momentum/**", "/world/**"))


def scene_view(
    origin: str, name: str, eye: tuple[float, ...], contents: Sequence[str] = ("$origin/**",)
) -> rrb.Spatial3DView:
    """Return a view of platforms in three dimensions.

    Args:
        origin: path of the frame N that the view is in.
        name: of the view.
        eye: where the viewer looks from at the origin, m.
        contents: paths of what is shown.
    """
    return rrb.Spatial3DView(
        origin=origin,
        contents=list(contents),
        name=name,
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


def _plots(traces: Sequence[Trace], names: Sequence[str]) -> list[rrb.View]:
    held = {trace.path.partition("/")[0] for trace in traces}
    return [plot_view(f"/{name}", TITLES[name], traces) for name in names if name in held]


def plot_view(origin: str, title: str, traces: Sequence[Trace], time_axis: rrb.TimeAxis = LINKED) -> rrb.TimeSeriesView:
    """Return a plot over time of everything below a path.

    Args:
        origin: the path.
        title: with the unit.
        traces: of the recording; those below the path make the vertical axis.
        time_axis: the horizontal one.
    """
    own = [trace for trace in traces if f"/{trace.path}/".startswith(f"{origin}/")]
    return rrb.TimeSeriesView(
        origin=origin,
        name=title,
        axis_x=time_axis,
        axis_y=value_axis(own),
        plot_legend=rrb.PlotLegend(
            rrb.Corner2D.RightTop, visible=len({name for trace in own for name in trace.names}) > 1
        ),
    )
