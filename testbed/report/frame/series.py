"""Lines of a time chart, as plain arrays: which colour, which style, and no more samples than a screen resolves."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array, Series
from testbed.palette import component_shades
from testbed.signals import SIGNALS

MOST_SAMPLES = 1000
"""Samples kept of one line: two for each pixel of a chart. All of a long flight's would swell the file past 6 MB."""

Style: TypeAlias = Literal["line", "wide", "dashed", "points"]


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a chart.

    Attributes:
        name: in the legend.
        x: shape (N,).
        y: shape (N,); NaN where there is no sample.
        color: name in `testbed.palette`, or another custom property of the style sheet.
        style: how it is drawn.
        pale: whether it stays behind the others.
        listed: whether the legend lists it; lines of one name are switched on and off together.
    """

    name: str
    x: Series
    y: Series
    color: str
    style: Style = "line"
    pale: bool = False
    listed: bool = True


def signal_lines(
    name: str, time: Series, values: Array, *, style: Style = "line", pale: bool = False, listed: bool = True
) -> tuple[Line, ...]:
    """Return one line for each component of a signal.

    Args:
        name: of the signal, in `testbed.signals.SIGNALS`.
        time: shape (N,), s.
        values: shape (N, width).
        style: how they are drawn.
        pale: whether they stay behind others.
        listed: whether the legend lists them.
    """
    signal = SIGNALS[name].sized(values.shape[1])
    names = signal.components or (signal.label,)
    return component_lines(names, time, values, style=style, pale=pale, listed=listed)


def component_lines(
    names: tuple[str, ...],
    time: Series,
    values: Array,
    *,
    style: Style = "line",
    pale: bool = False,
    listed: bool = True,
) -> tuple[Line, ...]:
    """Return one line for each column, coloured as body axes, CMG units or a single number; arguments as above."""
    return tuple(
        Line(name=name, x=time, y=column, color=color, style=style, pale=pale, listed=listed)
        for name, column, color in zip(names, values.T, component_shades(names), strict=True)
    )


def thinned(x: Series, y: Series) -> tuple[Series, Series]:
    """Return a line's samples without NaN; of very many, the extremes of short stretches, so that no peak is lost.

    Args:
        x: shape (N,).
        y: shape (N,).
    """
    known = np.isfinite(y)
    x, y = x[known], y[known]
    if len(x) <= MOST_SAMPLES:
        return x, y
    edges = np.linspace(0, len(x), MOST_SAMPLES // 2 + 1).astype(int)
    kept = [
        first + extreme
        for first, last in pairwise(edges)
        for extreme in (int(np.argmin(y[first:last])), int(np.argmax(y[first:last])))
    ]
    index = np.unique([0, *kept, len(x) - 1])
    return x[index], y[index]
