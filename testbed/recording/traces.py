"""Which lines each plot shows, as plain arrays: signals, their limits, and what follows from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array, Series
from testbed.palette import Color
from testbed.recording.content import RecordingContent, ShownLimits, ShownResidual
from testbed.recording.palette import AXIS_COLORS, LIMIT_COLOR, colors_of, pale
from testbed.signals import AXES, KINDS, SIGNALS, Signal

Channels: TypeAlias = Mapping[str, Array]
Style: TypeAlias = Literal["line", "wide", "points", "dots", "reference", "limit"]


def _of_actuators(name: str) -> Iterator[tuple[str, ...]]:
    """Yield the signals of a plot of actuators: true or else measured or commanded, and the reference."""
    yield f"true_{name}", name if name in SIGNALS else f"{name}_command"
    if f"reference_{name}" in SIGNALS:
        yield (f"reference_{name}",)


PLOTS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "body_rate": (("true_body_rate",), ("reference_body_rate",), ("body_rate",)),
    "cluster_momentum": (("true_cluster_momentum", "cluster_momentum"),),
    "cluster_torque": (("true_cluster_torque",),),
    **{name: tuple(_of_actuators(name)) for kind in KINDS.values() for name in kind.plots},
    "singularity_measure": (("singularity_measure",),),
    "applied_torque": (("applied_torque",),),
}
"""Signals of each plot; of several in one bracket the first that the flight has."""


@dataclass(frozen=True, kw_only=True)
class Trace:
    """The lines of one entity in a plot.

    Attributes:
        path: of the entity; its first part is the plot's.
        time: shape (N,), s.
        values: shape (N, width).
        names: of the lines, in the legend.
        colors: of the lines.
        style: how they are drawn.
    """

    path: str
    time: Series
    values: Array
    names: tuple[str, ...]
    colors: tuple[Color, ...]
    style: Style


def flight_traces(time: Series, channels: Channels, content: RecordingContent) -> tuple[Trace, ...]:
    """Return every trace of a flight; a plot for which the flight has no signal gets none.

    Args:
        time: shape (N,), s.
        channels: by signal name, shape (N, width).
        content: limits, residuals and the envelope's use.
    """
    signals = [_signal_trace(plot, name, time, channels) for plot, name in _shown_signals(channels)]
    plots = {trace.path.partition("/")[0] for trace in signals}
    return (
        *signals,
        *_tracking_error(time, channels),
        *_envelope_fraction(time, content),
        *(trace for trace in _limits(time, content.limits) if trace.path.partition("/")[0] in plots),
        *map(_residual, content.residuals),
    )


def _shown_signals(channels: Channels) -> Iterator[tuple[str, str]]:
    for plot, choices in PLOTS.items():
        for choice in choices:
            present = [name for name in choice if name in channels]
            if present:
                yield plot, present[0]


def _signal_trace(plot: str, name: str, time: Series, channels: Channels) -> Trace:
    signal, style = SIGNALS[name].sized(channels[name].shape[1]), _style(name)
    colors = colors_of(signal.components or ("",))
    sampled = ~np.isnan(channels[name]).all(axis=1)
    return Trace(
        path=f"{plot}/{name}",
        time=time[sampled],
        values=channels[name][sampled],
        names=_line_names(signal, style),
        colors=tuple(map(pale, colors)) if style == "reference" else colors,
        style=style,
    )


def _line_names(signal: Signal, style: Style) -> tuple[str, ...]:
    """Return what the legend calls the lines; lines of one name share an entry and are switched on and off together."""
    head, _, qualifier = signal.label.partition(", ")
    if style != "line":
        return (qualifier,) * signal.width
    if signal.per:
        return tuple(f"{KINDS[signal.per].prefix}{unit}" for unit in signal.components)
    return signal.components or (head,)


def _style(name: str) -> Style:
    if name.startswith("reference_"):
        return "reference"
    return "points" if name == "body_rate" else "line"


def _tracking_error(time: Series, channels: Channels) -> Iterator[Trace]:
    if {"true_body_rate", "reference_body_rate"} <= channels.keys():
        yield Trace(
            path="tracking_error/true_minus_reference",
            time=time,
            values=channels["true_body_rate"] - channels["reference_body_rate"],
            names=AXES,
            colors=AXIS_COLORS,
            style="line",
        )


def _envelope_fraction(time: Series, content: RecordingContent) -> Iterator[Trace]:
    if content.envelope_fraction is not None:
        yield Trace(
            path="envelope_fraction/used",
            time=time,
            values=content.envelope_fraction[:, None],
            names=("used",),
            colors=colors_of(("used",)),
            style="line",
        )
        yield _limit("envelope_fraction", time, np.array([1.0]), (LIMIT_COLOR,))


def _limits(time: Series, limits: ShownLimits) -> Iterator[Trace]:
    axis_colors = tuple(map(pale, AXIS_COLORS * 2))
    for plot, levels in limits.items():
        by_axis = len(levels) == len(axis_colors)
        yield _limit(plot, time, levels, axis_colors if by_axis else (LIMIT_COLOR,) * len(levels))


def _limit(plot: str, time: Series, levels: Array, colors: tuple[Color, ...]) -> Trace:
    """Return horizontal lines from the first to the last sample."""
    return Trace(
        path=f"{plot}/limit",
        time=time[[0, -1]],
        values=np.tile(levels, (2, 1)),
        names=("limit",) * len(levels),
        colors=colors,
        style="limit",
    )


def _residual(residual: ShownResidual) -> Trace:
    return Trace(
        path=f"residual/{residual.name}",
        time=residual.time,
        values=residual.values,
        names=AXES,
        colors=AXIS_COLORS,
        style="line",
    )
