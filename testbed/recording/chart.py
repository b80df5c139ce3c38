"""The estimates as a drawing: error bars of every estimator beside the bound, around the truth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from matplotlib.ticker import MaxNLocator

from testbed.arrays import Array, Series, Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import InertiaUnit, inertia_unit
from testbed.palette import Color
from testbed.recording.content import RecordingContent, ShownEstimate
from testbed.recording.palette import BOUND_COLOR, ESTIMATOR_COLORS, GRID_COLOR, NOMINAL_COLOR, TRUTH_COLOR

ROOT = "estimates"
COLUMN_WIDTH = 130.0
HALF_HEIGHT = 260.0
BAND = 1.96
"""Standard deviations on either side that hold 95 % of a normal distribution."""

_WIDTH = COLUMN_WIDTH * len(PARAMETER_NAMES)
_FILL_SPACING = 3.0
_LABEL_DROP = 13.0
"""How far below its point a viewer writes a label, at the size that the view usually has."""
_CENTERS = COLUMN_WIDTH * (np.arange(len(PARAMETER_NAMES), dtype=np.float64) + 0.5)

BOUNDS = ((-90.0, _WIDTH + 20.0), (-HALF_HEIGHT - 70.0, HALF_HEIGHT + 60.0))
"""What the view shows: x from, to; y from, to, downwards."""


def log_estimates(stream: rr.RecordingStream, content: RecordingContent) -> None:
    """Draw θ̂ - θ for each parameter and estimator, with ±1.96 σ, over the band of the Cramér-Rao bound.

    Without a truth the zero line is the nominal θ.
    """
    zero = content.nominal_theta if content.true_theta is None else content.true_theta
    scale = HALF_HEIGHT / _largest_offset(content, zero)
    zero_name = "truth" if content.true_theta is not None else "nominal"
    _log_axes(stream, scale, inertia_unit(content.nominal_theta), zero_name)
    if content.bound_std is not None:
        _log_bound(stream, BAND * content.bound_std * scale)
    if content.true_theta is not None:
        _log_nominal(stream, (content.nominal_theta - zero) * scale)
    for index, estimate in enumerate(content.estimates):
        _log_estimate(stream, estimate, zero, scale, index, len(content.estimates))


def _largest_offset(content: RecordingContent, zero: Theta) -> float:
    """Return the largest distance from the zero line that has to fit, kg·m²."""
    reaches = [np.abs(shown.theta - zero) + BAND * shown.std for shown in content.estimates]
    reaches += [] if content.bound_std is None else [BAND * content.bound_std]
    return 1.05 * float(np.max(reaches))


def _log_axes(stream: rr.RecordingStream, scale: float, unit: InertiaUnit, zero_name: str) -> None:
    reach = unit.per_SI * HALF_HEIGHT / scale
    ticks = np.asarray(MaxNLocator(nbins=8).tick_values(-reach, reach))
    ticks = ticks[np.abs(ticks) <= reach]
    heights = -ticks / unit.per_SI * scale
    _log_lines(stream, "grid", [[(0.0, y), (_WIDTH, y)] for y in heights], GRID_COLOR, 0.5, order=0.0)
    zero_color = TRUTH_COLOR if zero_name == "truth" else NOMINAL_COLOR
    _log_lines(stream, zero_name, [[(0.0, 0.0), (_WIDTH, 0.0)]], zero_color, 1.0, order=10.0)
    _log_labels(
        stream,
        "scale",
        np.full(len(ticks), -35.0),
        heights - _LABEL_DROP,
        [f"{tick:+.2g}" for tick in ticks],
        GRID_COLOR,
    )
    title = f"estimate - {zero_name} in {unit.text}, bars ±{BAND} σ"
    _log_labels(stream, "title", np.array([_WIDTH / 2]), np.array([-HALF_HEIGHT - 50.0]), [title], TRUTH_COLOR)
    _log_labels(stream, "parameter", _CENTERS, np.full(6, HALF_HEIGHT + 30.0), PARAMETER_NAMES, TRUTH_COLOR)


def _log_bound(stream: rr.RecordingStream, reach: Series) -> None:
    """Fill each band with thin lines: one thick line would have round ends, far beyond the bound."""
    x = np.arange(-0.42 * COLUMN_WIDTH, 0.42 * COLUMN_WIDTH, _FILL_SPACING)
    bars = [[(c + d, -y), (c + d, y)] for c, y in zip(_CENTERS, reach, strict=True) for d in x]
    _log_lines(stream, "bound", bars, BOUND_COLOR, 0.6 * _FILL_SPACING, order=-10.0)


def _log_nominal(stream: rr.RecordingStream, offset: Series) -> None:
    """Draw the nominal θ where it lies within the scale that the estimates need."""
    half = 0.42 * COLUMN_WIDTH
    marks = [[(x - half, -y), (x + half, -y)] for x, y in zip(_CENTERS, offset, strict=True) if abs(y) <= HALF_HEIGHT]
    if marks:
        _log_lines(stream, "nominal", marks, NOMINAL_COLOR, 1.5, order=15.0)
        place = np.array([0.92 * _WIDTH]), np.array([-HALF_HEIGHT - 50.0])
        _log_labels(stream, "nominal_name", *place, ["nominal"], NOMINAL_COLOR)


def _log_estimate(
    stream: rr.RecordingStream, estimate: ShownEstimate, zero: Theta, scale: float, index: int, count: int
) -> None:
    color = ESTIMATOR_COLORS[index % len(ESTIMATOR_COLORS)]
    x = _CENTERS + COLUMN_WIDTH * 0.8 * ((index + 0.5) / count - 0.5)
    y = -(estimate.theta - zero) * scale
    reach = BAND * estimate.std * scale
    bars = [[(a, b - r), (a, b + r)] for a, b, r in zip(x, y, reach, strict=True)]
    _log_lines(stream, f"{estimate.name}/band", bars, color, 2.0, order=20.0)
    stream.log(
        f"{ROOT}/{estimate.name}/value",
        rr.Points2D(np.column_stack([x, y]), radii=6.0, colors=color, draw_order=40.0),
        static=True,
    )
    legend = np.array([_WIDTH * (index + 0.5) / count]), np.array([-HALF_HEIGHT - 22.0])
    _log_labels(stream, f"{estimate.name}/legend", *legend, [estimate.name], color)


def _log_lines(
    stream: rr.RecordingStream,
    name: str,
    strips: Sequence[Sequence[tuple[float, float]]],
    color: Color,
    radius: float,
    order: float,
) -> None:
    drawn = rr.LineStrips2D(strips, colors=color, radii=radius, draw_order=order)
    stream.log(f"{ROOT}/{name}", drawn, static=True)


def _log_labels(stream: rr.RecordingStream, name: str, x: Array, y: Array, labels: Sequence[str], color: Color) -> None:
    drawn = rr.Points2D(np.column_stack([x, y]), radii=0.0, colors=color, labels=labels, show_labels=True)
    stream.log(f"{ROOT}/{name}", drawn, static=True)
