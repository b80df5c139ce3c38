"""Figures 1, 2, 5 and 6 as plain arrays, for the page and for the recording alike; figure 3 is the box plot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from testbed.arrays import Series, Vector3, Vectors3
from testbed.maneuver.maneuver import Maneuver
from testbed.reproduction.table1 import Table1
from testbed.reproduction.table2 import ManeuverStatistics
from testbed.reproduction.zero_g_figures import Figure5, Figure6

_SAMPLES_PER_SECOND = 100.0


@dataclass(frozen=True, kw_only=True)
class Curves:
    """Three lines, one for each body axis.

    Attributes:
        name: what they are; empty where a panel has no others.
        time: shape (N,), s.
        values: shape (N, 3).
        style: how they are drawn.
    """

    name: str
    time: Series
    values: Vectors3
    style: Literal["line", "reference", "points"] = "line"


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One plot.

    Attributes:
        key: name for paths.
        title: what is drawn, body axes.
        unit: of it.
        curves: in the order in which they are drawn.
        limit: per body axis, in both directions, shape (3,); None where there is none.
    """

    key: str
    title: str
    unit: str
    curves: tuple[Curves, ...]
    limit: Vector3 | None = None


@dataclass(frozen=True, kw_only=True)
class PaperFigure:
    """A figure of the paper, or one that belongs beside it.

    Attributes:
        key: name for paths.
        title: with the paper's number.
        panels: from top to bottom.
    """

    key: str
    title: str
    panels: tuple[Panel, ...]


def maneuver_figures(
    table1: Table1, maneuvers: Sequence[ManeuverStatistics], acceleration_limit: Vector3
) -> tuple[PaperFigure, ...]:
    """Return figures 1 and 2, and this project's maneuver beside them.

    Args:
        table1: with the designs made as the paper did.
        maneuvers: of Table 2, with this project's.
        acceleration_limit: that the cluster's torque allows, rad/s². Source: paper eqs. (25), (31).
    """
    own = {each.name: (each.title, each.maneuver) for each in maneuvers if each.paper_std is None}
    shown = (
        ("figure_1", "Figure 1: initial reference profile", table1.maneuvers["given", "basic"]),
        ("figure_2", "Figure 2: D-opt maneuver, designed as the paper did", table1.maneuvers["paper", "D"]),
        *((name, f"This project's maneuver, {title}", maneuver) for name, (title, maneuver) in own.items()),
    )
    return tuple(
        PaperFigure(key=key, title=title, panels=_maneuver_panels(maneuver, acceleration_limit))
        for key, title, maneuver in shown
    )


def _maneuver_panels(maneuver: Maneuver, acceleration_limit: Vector3) -> tuple[Panel, ...]:
    time = np.linspace(0.0, maneuver.duration, round(maneuver.duration * _SAMPLES_PER_SECOND) + 1)
    reference = maneuver.reference(time)
    return (
        Panel(
            key="body_rate",
            title="body rate",
            unit="rad/s",
            curves=(Curves(name="", time=time, values=reference.body_rate),),
        ),
        Panel(
            key="body_acceleration",
            title="body acceleration",
            unit="rad/s²",
            curves=(Curves(name="", time=time, values=reference.body_acceleration),),
            limit=acceleration_limit,
        ),
    )


def data_figure(data: Figure5) -> PaperFigure:
    """Return figure 5: what the longest zero-g flight sent."""
    rate = Curves(name="", time=data.time, values=data.body_rate)
    momentum = Curves(name="", time=data.time, values=data.cluster_momentum_B)
    return PaperFigure(
        key="figure_5",
        title="Figure 5: input and output of the longest zero-g flight, 16 Hz",
        panels=(
            Panel(key="body_rate", title="body rate, measured", unit="rad/s", curves=(rate,)),
            Panel(key="cluster_momentum", title="cluster momentum, measured", unit="N·m·s", curves=(momentum,)),
        ),
    )


def validation_figure(data: Figure6) -> PaperFigure:
    """Return figure 6: the total torque of a flight that was not used, measured and as the estimate explains it."""
    estimated = Curves(name="estimated", time=data.time, values=data.estimated_B, style="reference")
    measured = Curves(name="measured", time=data.time, values=data.measured_B)
    return PaperFigure(
        key="figure_6",
        title="Figure 6: total torque of a flight that was not used, behind the prefilter",
        panels=(Panel(key="total_torque", title="total torque M - ω × h", unit="N·m", curves=(estimated, measured)),),
    )
