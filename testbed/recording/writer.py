"""From a finished flight to a recording file, in columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr

from testbed.arrays import Array, Series
from testbed.files import whole_file
from testbed.recording.blueprint import blueprint
from testbed.recording.chart import log_estimates
from testbed.recording.content import RecordingContent, ShownEvent
from testbed.recording.platform import log_platform
from testbed.recording.saturation import STATES, log_saturation
from testbed.recording.stream import send
from testbed.recording.traces import Style, Trace, flight_traces
from testbed.scene import SceneBody

APPLICATION_ID = "testbed"
LINE_WIDTHS: Mapping[Style, float] = {"line": 1.6, "wide": 6.0, "reference": 2.6, "limit": 1.0}
MARKER_SIZES: Mapping[Style, float] = {"points": 2.5, "dots": 0.75}


def write_recording(
    path: Path,
    *,
    recording_id: str,
    time: Series,
    channels: Mapping[str, Array],
    scene: Sequence[SceneBody],
    content: RecordingContent,
) -> None:
    """Write a flight with its layout to an .rrd file, which appears whole or not at all.

    Args:
        path: of the file; one that is there is replaced.
        recording_id: from everything that decides the run: a viewer merges recordings of one id.
        time: strictly increasing, shape (N,), s.
        channels: by signal name (`testbed.signals.SIGNALS`), shape (N, width); NaN where not sampled.
        scene: bodies of the platform, parents before children.
        content: what is shown besides.
    """
    with recording_stream(path, recording_id) as stream:
        traces = flight_traces(time, channels, content)
        log_platform(stream, scene, time, channels)
        log_saturation(stream, time, channels)
        for trace in traces:
            log_trace(stream, trace)
        if content.estimates:
            log_estimates(stream, content)
        _log_text(stream, content)
        stream.send_property("run", rr.AnyValues(**dict[str, Any](content.properties)))
        stream.send_blueprint(blueprint(traces, _others(channels, content), _residual_units(content)))


@contextmanager
def recording_stream(path: Path, recording_id: str) -> Iterator[rr.RecordingStream]:
    """Open a stream into a file beside `path` that takes its place when all has been written.

    Args:
        path: of the .rrd file.
        recording_id: from everything that decides what is recorded.
    """
    stream = rr.RecordingStream(APPLICATION_ID, recording_id=recording_id, send_properties=False)
    stream.set_log_time_enabled(False)
    with whole_file(path) as part:
        stream.save(part)
        try:
            yield stream
            stream.flush()
        finally:
            stream.disconnect()


def log_trace(stream: rr.RecordingStream, trace: Trace) -> None:
    """Write the lines of one entity and how they look."""
    stream.log(trace.path, _styling(trace), static=True)
    send(stream, trace.path, trace.time, lambda rows: rr.Scalars.columns(scalars=trace.values[rows]))


def _styling(trace: Trace) -> rr.SeriesLines | rr.SeriesPoints:
    if trace.style in MARKER_SIZES:
        size = MARKER_SIZES[trace.style]
        return rr.SeriesPoints(names=trace.names, colors=trace.colors, markers="Circle", marker_sizes=size)
    # Extremes are kept where many samples share a pixel: the default mean would hide a vibration.
    return rr.SeriesLines(
        names=trace.names, colors=trace.colors, widths=LINE_WIDTHS[trace.style], aggregation_policy="MinMax"
    )


def _log_text(stream: rr.RecordingStream, content: RecordingContent) -> None:
    for path, markdown in (("result", content.result), ("provenance", content.provenance)):
        stream.log(path, rr.TextDocument(markdown, media_type="text/markdown"), static=True)
    if content.events:
        _log_events(stream, content.events)


def _log_events(stream: rr.RecordingStream, events: Sequence[ShownEvent]) -> None:
    texts = [event.text for event in events]
    send(
        stream, "events", np.array([event.time for event in events]), lambda rows: rr.TextLog.columns(text=texts[rows])
    )


def _others(channels: Mapping[str, Array], content: RecordingContent) -> set[str]:
    """Return the first part of every path that a view of the layout may show, beside those of the traces."""
    saturation = {"saturation"} if STATES.keys() & channels.keys() else set()
    return saturation | ({"estimates"} if content.estimates else set())


def _residual_units(content: RecordingContent) -> dict[str, str]:
    return {residual.name: residual.unit for residual in content.residuals}
