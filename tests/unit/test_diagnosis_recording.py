"""What the recording of a diagnosis draws over each other can be told apart."""

from __future__ import annotations

import numpy as np

from testbed.diagnosis.findings import RunResiduals
from testbed.outputs.diagnosis_recording import diagnosis_content


def test_every_curve_of_a_panel_has_its_own_colour():
    zeros = np.zeros((5, 3))
    run = RunResiduals(
        name="run",
        held_out=True,
        time=np.arange(5.0),
        measured=zeros,
        nominal=zeros,
        extended=zeros,
        before=zeros,
        after=zeros,
    )
    (tab,) = diagnosis_content([run], {}).tabs
    assert tab.name == "run, held out"
    for panel in (panel for column in tab.columns for panel in column):
        colors = [trace.colors[0] for trace in panel.traces]
        assert len(set(colors)) == len(colors) == 3
