"""Figure 3 as a drawing: boxes of the estimates' errors for each inertia parameter and maneuver."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from matplotlib.ticker import MaxNLocator

from testbed.arrays import Array
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.palette import Color
from testbed.recording.palette import GRID_COLOR, TRUTH_COLOR
from testbed.recording.reproduction_content import ShownBox, ShownBoxes

ROOT = "figure_3"
_COLUMN = 150.0
_HALF_HEIGHT = 260.0
_WIDTH = _COLUMN * len(PARAMETER_NAMES)
_CENTERS = _COLUMN * (np.arange(len(PARAMETER_NAMES), dtype=np.float64) + 0.5)
_LABEL_DROP = 13.0
"""How far below its point a viewer writes a label, at the size that the view usually has."""

BOUNDS = ((-90.0, _WIDTH + 20.0), (-_HALF_HEIGHT - 70.0, _HALF_HEIGHT + 60.0))
"""What the view shows: x from, to; y from, to, downwards."""


def log_box_plot(stream: rr.RecordingStream, groups: Sequence[ShownBoxes]) -> None:
    """Draw the boxes of every maneuver side by side for each parameter, outliers as dots."""
    scale = _HALF_HEIGHT / _reach(groups)
    _log_axes(stream, scale)
    pitch = 0.86 * _COLUMN / len(groups)
    for place, group in enumerate(groups):
        offset = (place - (len(groups) - 1) / 2) * pitch
        centers = _CENTERS + offset
        _log_group(stream, f"maneuver_{place + 1}", group, centers, 0.36 * pitch, scale)
        _log_legend(stream, f"maneuver_{place + 1}", group, _WIDTH * (place + 0.5) / len(groups))


def _reach(groups: Sequence[ShownBoxes]) -> float:
    """Return the largest error that has to fit, kg·m²."""
    ends = [end for group in groups for box in group.boxes for end in (*box.whiskers, *box.outliers)]
    return 1.03 * float(np.abs(ends).max())


def _log_axes(stream: rr.RecordingStream, scale: float) -> None:
    reach = 1e3 * _HALF_HEIGHT / scale
    ticks = np.asarray(MaxNLocator(nbins=8).tick_values(-reach, reach))
    ticks = ticks[np.abs(ticks) <= reach]
    for name, values, color in (("grid", ticks[ticks != 0.0], GRID_COLOR), ("truth", np.zeros(1), TRUTH_COLOR)):
        strips = [[(0.0, -value / 1e3 * scale), (_WIDTH, -value / 1e3 * scale)] for value in values]
        _log_strips(stream, name, strips, color, 0.5, order=0.0)
    heights = -ticks / 1e3 * scale
    _log_labels(stream, "scale", np.full(len(ticks), -35.0), heights - _LABEL_DROP, [f"{tick:+.2g}" for tick in ticks])
    _log_labels(stream, "parameter", _CENTERS, np.full(len(_CENTERS), _HALF_HEIGHT + 30.0), PARAMETER_NAMES)
    title = "Figure 3: error of the estimate, 1e-3 kg·m², by the paper's estimator"
    _log_labels(stream, "title", np.array([_WIDTH / 2]), np.array([-_HALF_HEIGHT - 55.0]), [title])


def _log_group(
    stream: rr.RecordingStream, name: str, group: ShownBoxes, centers: Array, half_width: float, scale: float
) -> None:
    strips = [
        strip
        for center, box in zip(centers, group.boxes, strict=True)
        for strip in _box_strips(box, float(center), half_width, scale)
    ]
    _log_strips(stream, f"{name}/boxes", strips, group.color, 1.0, order=20.0)
    outliers = [
        (center, -value * scale) for center, box in zip(centers, group.boxes, strict=True) for value in box.outliers
    ]
    stream.log(
        f"{ROOT}/{name}/outliers", rr.Points2D(outliers, radii=2.0, colors=group.color, draw_order=10.0), static=True
    )


def _box_strips(box: ShownBox, center: float, half_width: float, scale: float) -> list[list[tuple[float, float]]]:
    """Return box, median, whiskers and their caps as lines."""
    left, right = center - half_width, center + half_width
    low, high, median = (-scale * value for value in (*box.quartiles, box.median))
    bottom, top = (-scale * value for value in box.whiskers)
    cap = half_width / 2
    return [
        [(left, low), (right, low), (right, high), (left, high), (left, low)],
        [(left, median), (right, median)],
        [(center, low), (center, bottom)],
        [(center, high), (center, top)],
        [(center - cap, bottom), (center + cap, bottom)],
        [(center - cap, top), (center + cap, top)],
    ]


def _log_legend(stream: rr.RecordingStream, name: str, group: ShownBoxes, x: float) -> None:
    place = np.array([x]), np.array([-_HALF_HEIGHT - 25.0])
    _log_labels(stream, f"{name}/legend", *place, [group.name], group.color)


def _log_strips(
    stream: rr.RecordingStream,
    name: str,
    strips: Sequence[Sequence[tuple[float, float]]],
    color: Color,
    radius: float,
    order: float,
) -> None:
    drawn = rr.LineStrips2D(strips, colors=color, radii=radius, draw_order=order)
    stream.log(f"{ROOT}/{name}", drawn, static=True)


def _log_labels(
    stream: rr.RecordingStream, name: str, x: Array, y: Array, labels: Sequence[str], color: Color = TRUTH_COLOR
) -> None:
    drawn = rr.Points2D(np.column_stack([x, y]), radii=0.0, colors=color, labels=labels, show_labels=True)
    stream.log(f"{ROOT}/{name}", drawn, static=True)
