"""The recording of a diagnosis: a tab for each run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from testbed.arrays import Array, Series
from testbed.palette import Color
from testbed.recording.axes import time_axes
from testbed.recording.blueprint import plot_view, scene_view, whole_layout
from testbed.recording.platform import log_platform
from testbed.recording.reproduction_content import ShownTab, traces_of
from testbed.recording.writer import log_trace, recording_stream
from testbed.scene import SceneBody

_EYE = (0.58, 0.0, 0.24)
"""m, from the platform in the middle: those beside it, along y, are in view as large."""
_ABOVE = 0.17
"""m over the middle of a platform, where its name stands: outside of the cube however it turns."""


@dataclass(frozen=True, kw_only=True)
class ShownMotion:
    """A platform that turns as was measured, or as is predicted.

    Attributes:
        name: written above it.
        color: of the name.
        scene: bodies, parents before children.
        time: shape (N,), s.
        channels: by signal name, shape (N, width); `true_position` sets it beside the others.
    """

    name: str
    color: Color
    scene: Sequence[SceneBody]
    time: Series
    channels: Mapping[str, Array]


@dataclass(frozen=True, kw_only=True)
class ShownRun:
    """One run.

    Attributes:
        root: first part of the paths of all that is its own.
        tab: its plots; the first column stands below the motions.
        motions: side by side.
    """

    root: str
    tab: ShownTab
    motions: tuple[ShownMotion, ...]


@dataclass(frozen=True, kw_only=True)
class DiagnosisContent:
    """All that the recording of a diagnosis shows.

    Attributes:
        runs: a tab each.
        verdict: with what was added, markdown.
        provenance: markdown.
    """

    runs: tuple[ShownRun, ...]
    verdict: str
    provenance: str


def write_diagnosis_recording(path: Path, recording_id: str, content: DiagnosisContent) -> None:
    """Write the runs with their layout to an .rrd file, which appears whole or not at all.

    Args:
        path: of the file.
        recording_id: from everything that decides the diagnosis.
        content: what is shown.
    """
    by_run = [traces_of(run.tab) for run in content.runs]
    traces = [trace for own in by_run for trace in own]
    tabs = (_tab(run, axis) for run, axis in zip(content.runs, time_axes(by_run), strict=True))
    with recording_stream(path, recording_id) as stream:
        for trace in traces:
            log_trace(stream, trace)
        for run in content.runs:
            for motion in run.motions:
                _log_motion(stream, f"{run.root}/motion/{motion.name}", motion)
        for name, markdown in (("verdict", content.verdict), ("provenance", content.provenance)):
            stream.log(name, rr.TextDocument(markdown, media_type="text/markdown"), static=True)
        stream.send_blueprint(whole_layout((*tabs, _provenance()), traces))


def _log_motion(stream: rr.RecordingStream, path: str, motion: ShownMotion) -> None:
    log_platform(stream, motion.scene, motion.time, motion.channels, under=f"{path}/")
    place = motion.channels["true_position"][0] + (0.0, 0.0, _ABOVE)
    name = rr.Points3D([place], radii=0.0, colors=motion.color, labels=[motion.name], show_labels=True)
    stream.log(f"{path}/name", name, static=True)


def _tab(run: ShownRun, axis: rrb.TimeAxis) -> rrb.Horizontal:
    plots = [
        [plot_view(f"/{panel.origin}", panel.title, panel.traces, axis) for panel in column]
        for column in run.tab.columns
    ]
    scene = scene_view(f"/{run.root}/motion", "Platform, N: measured and predicted", _EYE)
    verdict = rrb.TextDocumentView(origin="/verdict", name="Verdict")
    left = rrb.Vertical(scene, *plots[0], verdict, row_shares=(4, *(2 for _ in plots[0]), 3))
    return rrb.Horizontal(left, *(rrb.Vertical(*column) for column in plots[1:]), name=run.tab.name)


def _provenance() -> rrb.Horizontal:
    return rrb.Horizontal(rrb.TextDocumentView(origin="/provenance", name="Provenance"), name="Provenance")
