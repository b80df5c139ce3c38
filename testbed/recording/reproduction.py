"""The recording of a reproduction: the paper's figures as tabs of one layout."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from testbed.recording.axes import time_axes
from testbed.recording.blueprint import BACKGROUND, flight_view, plot_view, whole_layout
from testbed.recording.box_plot import BOUNDS, ROOT, log_box_plot
from testbed.recording.platform import log_platform
from testbed.recording.reproduction_content import ReproductionContent, ShownPanel, ShownTab, traces_of
from testbed.recording.writer import log_trace, recording_stream

_CABIN_DISTANCE = 3.0
"""Of the eye, so that the cabin is in view in which the platform drifts."""


def write_reproduction_recording(path: Path, recording_id: str, content: ReproductionContent) -> None:
    """Write the figures with their layout to an .rrd file, which appears whole or not at all.

    Args:
        path: of the file.
        recording_id: from everything that decides the reproduction.
        content: what is shown.
    """
    with recording_stream(path, recording_id) as stream:
        for tab in (*content.before, *content.after):
            for trace in traces_of(tab):
                log_trace(stream, trace)
        log_box_plot(stream, content.boxes)
        log_platform(stream, content.flight.scene, content.flight.time, content.flight.channels)
        for name, markdown in (("tables", content.tables), ("provenance", content.provenance)):
            stream.log(name, rr.TextDocument(markdown, media_type="text/markdown"), static=True)
        stream.send_property("reproduction", rr.AnyValues(**dict[str, Any](content.properties)))
        stream.send_blueprint(_layout(content))


def _layout(content: ReproductionContent) -> rrb.Blueprint:
    traces = {tab.name: traces_of(tab) for tab in (*content.before, *content.after)}
    axes = dict(zip(traces, time_axes(list(traces.values())), strict=True))
    before, after = ([_tab(tab, axes[tab.name]) for tab in tabs] for tabs in (content.before, content.after))
    tabs = (*before, _box_plot(), *after, _texts())
    return whole_layout(tabs, [trace for own in traces.values() for trace in own])


def _tab(tab: ShownTab, axis: rrb.TimeAxis) -> rrb.Horizontal:
    columns = [rrb.Vertical(*(_panel(panel, axis) for panel in column)) for column in tab.columns]
    scene = [flight_view(_CABIN_DISTANCE)] if tab.scene else []
    return rrb.Horizontal(*scene, *columns, name=tab.name)


def _panel(panel: ShownPanel, axis: rrb.TimeAxis) -> rrb.TimeSeriesView:
    return plot_view(f"/{panel.origin}", panel.title, panel.traces, axis)


def _box_plot() -> rrb.Horizontal:
    x_range, y_range = BOUNDS
    view = rrb.Spatial2DView(
        origin=f"/{ROOT}",
        name="Box plot of the estimates' errors",
        background=BACKGROUND,
        visual_bounds=rrb.VisualBounds2D(x_range=x_range, y_range=y_range),
    )
    return rrb.Horizontal(view, name="Figure 3")


def _texts() -> rrb.Horizontal:
    return rrb.Horizontal(
        rrb.TextDocumentView(origin="/tables", name="Tables"),
        rrb.TextDocumentView(origin="/provenance", name="Provenance"),
        column_shares=(3, 1),
        name="Tables",
    )
