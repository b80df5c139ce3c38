"""The recording of a diagnosis: a tab for each run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from testbed.recording.blueprint import plot_view, whole_layout
from testbed.recording.reproduction_content import ShownTab
from testbed.recording.writer import log_trace, recording_stream


@dataclass(frozen=True, kw_only=True)
class DiagnosisContent:
    """All that the recording of a diagnosis shows.

    Attributes:
        tabs: one for each run.
        provenance: markdown.
    """

    tabs: tuple[ShownTab, ...]
    provenance: str


def write_diagnosis_recording(path: Path, recording_id: str, content: DiagnosisContent) -> None:
    """Write the runs with their layout to an .rrd file, which appears whole or not at all.

    Args:
        path: of the file.
        recording_id: from everything that decides the diagnosis.
        content: what is shown.
    """
    with recording_stream(path, recording_id) as stream:
        for trace in (
            trace for tab in content.tabs for column in tab.columns for panel in column for trace in panel.traces
        ):
            log_trace(stream, trace)
        stream.log("provenance", rr.TextDocument(content.provenance, media_type="text/markdown"), static=True)
        stream.send_blueprint(whole_layout((*map(_tab, content.tabs), _provenance())))


def _tab(tab: ShownTab) -> rrb.Horizontal:
    columns = [
        rrb.Vertical(*(plot_view(f"/{panel.origin}", panel.title) for panel in column)) for column in tab.columns
    ]
    return rrb.Horizontal(*columns, name=tab.name)


def _provenance() -> rrb.Horizontal:
    return rrb.Horizontal(rrb.TextDocumentView(origin="/provenance", name="Provenance"), name="Provenance")
