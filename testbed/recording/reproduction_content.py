"""What the recording of a reproduction shows: figures of lines, the box plot, the platform in flight, text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from testbed.arrays import Array, Series
from testbed.palette import Color
from testbed.recording.traces import Trace
from testbed.scene import SceneBody


@dataclass(frozen=True, kw_only=True)
class ShownPanel:
    """One plot of a figure.

    Attributes:
        origin: path that all its traces begin with, such as `figure_1/body_rate`.
        title: with the unit.
        traces: its lines.
    """

    origin: str
    title: str
    traces: tuple[Trace, ...]


@dataclass(frozen=True, kw_only=True)
class ShownTab:
    """Plots that are looked at together.

    Attributes:
        name: of the tab.
        columns: of plots, from left to right.
        scene: whether the platform in flight stands to the left of them.
    """

    name: str
    columns: tuple[tuple[ShownPanel, ...], ...]
    scene: bool = False


def traces_of(tab: ShownTab) -> tuple[Trace, ...]:
    """Return all lines of a tab."""
    return tuple(trace for column in tab.columns for panel in column for trace in panel.traces)


@dataclass(frozen=True, kw_only=True)
class ShownBox:
    """A box of a box plot; all numbers in kg·m².

    Attributes:
        median: of the errors.
        quartiles: lower and upper.
        whiskers: lowest and highest value that is no outlier.
        outliers: shape (K,).
    """

    median: float
    quartiles: tuple[float, float]
    whiskers: tuple[float, float]
    outliers: Series


@dataclass(frozen=True, kw_only=True)
class ShownBoxes:
    """The boxes of one maneuver.

    Attributes:
        name: in the legend.
        color: of all its boxes.
        boxes: one per inertia parameter.
    """

    name: str
    color: Color
    boxes: tuple[ShownBox, ...]


@dataclass(frozen=True, kw_only=True)
class ShownFlight:
    """A flight in three dimensions.

    Attributes:
        time: shape (N,), s.
        channels: by signal name, shape (N, width).
        scene: bodies of the platform, parents before children.
    """

    time: Series
    channels: Mapping[str, Array]
    scene: Sequence[SceneBody]


@dataclass(frozen=True, kw_only=True)
class ReproductionContent:
    """All that the recording of a reproduction shows.

    Attributes:
        before: tabs before the box plot.
        boxes: of figure 3.
        after: tabs after it.
        flight: shown in tabs with a scene.
        tables: the paper's tables beside this testbed's, markdown.
        provenance: markdown.
        properties: what a catalog lists.
    """

    before: tuple[ShownTab, ...]
    boxes: tuple[ShownBoxes, ...]
    after: tuple[ShownTab, ...]
    flight: ShownFlight
    tables: str
    provenance: str
    properties: Mapping[str, str | float | int]
