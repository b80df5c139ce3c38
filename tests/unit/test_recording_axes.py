"""A plot of a recording can be read: numbers beside its axis, its legend beside its curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rerun.chunk import RrdReader

from support.flights import content, flown
from testbed.plant.scene import scene_of
from testbed.recording.axes import LINKED, numbered_range, time_axes, value_axis
from testbed.recording.traces import Trace
from testbed.recording.writer import write_recording

WRITTEN = 20.0
"""Points that the viewer wants between two numbers (egui_plot's least label spacing)."""
SHARED = "/view/5c0dca6a-e63f-9cf7-f657-2602590474cc/TimeAxis"
HEIGHT = 280.0
"""Points of one of three plots in a column of a window of 1080."""


def numbers_in(low: float, high: float) -> int:
    """Return how many multiples of the smallest power of ten that is written lie within a range."""
    step = 10.0 ** np.ceil(np.log10(WRITTEN * (high - low) / HEIGHT))
    return int(np.floor(high / step + 1e-9) - np.ceil(low / step - 1e-9)) + 1


@given(st.floats(-1.0, 1.0), st.floats(1e-3, 1.0), st.integers(-6, 3))
def test_an_axis_has_two_numbers_and_all_of_its_curve(low, span, power):
    low, high = low * 10.0**power, (low + span) * 10.0**power
    first, last = numbered_range(low, high)
    assert first < low < high < last
    assert numbers_in(first, last) >= 2
    assert last - first <= 3.5 * (high - low)


@pytest.mark.parametrize("reach", [0.08, 0.09, 0.099])
def test_what_showed_a_lonely_zero_shows_a_number_on_one_side(reach):
    assert numbers_in(-reach, reach) == 1
    assert numbers_in(*numbered_range(-reach, reach)) >= 2


def test_runs_of_unlike_length_have_a_time_axis_each_and_others_share_one():
    def tab(seconds):
        return [replace(trace([0.0, 1.0]), time=np.array([0.0, seconds]))]

    assert time_axes([tab(4.0), tab(3.0)]) == (LINKED, LINKED)
    shown = time_axes([tab(4.0), tab(2.0)])
    assert LINKED not in shown
    assert [axis.view_range.as_arrow_array().to_pylist()[0]["end"] for axis in shown] == [4_880_000_000, 2_440_000_000]


def trace(values) -> Trace:
    column = np.array(values, dtype=float)[:, None]
    return Trace(
        path="a/b", time=np.arange(float(len(column))), values=column, names=("b",), colors=((1, 2, 3),), style="line"
    )


def test_a_constant_leaves_the_axis_to_the_viewer():
    assert value_axis([trace([1.0, 1.0])]) is None
    assert value_axis([trace([np.nan, np.inf])]) is None
    assert value_axis([trace([1.0, 1.0]), trace([2.0, np.nan])]) is not None


def test_linked_plots_begin_with_the_flight_and_room_for_the_legend(tmp_path):
    flight = flown(41)
    path = tmp_path / "recording.rrd"
    write_recording(
        path,
        recording_id="axes",
        time=flight.time,
        channels=flight.channels,
        scene=scene_of(flight.model),
        content=content(41),
    )
    reader = RrdReader(path)
    (layout,) = reader.blueprints()
    (axis,) = (chunk for chunk in reader.stream(store=layout).to_chunks() if chunk.entity_path == SHARED)
    ((shown,),) = axis.to_record_batch().column("TimeAxis:view_range").to_pylist()
    end = flight.time[-1]
    assert [shown[edge] for edge in ("start", "end")] == [0, round(1.22 * end * 1e9)]
