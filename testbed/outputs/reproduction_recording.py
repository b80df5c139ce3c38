"""What the recording of a reproduction shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from testbed.outputs.reproduction_tables import tables_text
from testbed.palette import SHADES
from testbed.plant.scene import scene_of
from testbed.recording.palette import AXIS_COLORS, pale
from testbed.recording.reproduction_content import (
    ReproductionContent,
    ShownBox,
    ShownBoxes,
    ShownFlight,
    ShownPanel,
    ShownTab,
)
from testbed.recording.traces import Trace
from testbed.reproduction.box_plot import Box, boxes_of
from testbed.reproduction.claims import Claim
from testbed.reproduction.figures import Curves, Panel, PaperFigure, data_figure, maneuver_figures, validation_figure
from testbed.reproduction.reproduction import Reproduction
from testbed.reproduction.table2 import ManeuverStatistics
from testbed.signals import AXES


def reproduction_content(
    reproduction: Reproduction, claims: Sequence[Claim], provenance: Mapping[str, str]
) -> ReproductionContent:
    """Return figures 1, 2, 3, 5 and 6, the flight behind figure 5, and the tables."""
    campaign = reproduction.table3
    maneuvers = maneuver_figures(reproduction.table1, reproduction.table2, reproduction.acceleration_limit)
    flight = ShownTab(
        name="Figures 5 and 6",
        columns=(_panels((data_figure(campaign.figure5), validation_figure(campaign.figure6))),),
        scene=True,
    )
    return ReproductionContent(
        before=(ShownTab(name="Figures 1 and 2", columns=tuple(_panels((figure,)) for figure in maneuvers)),),
        boxes=tuple(map(_boxes, reproduction.table2)),
        after=(flight,),
        flight=ShownFlight(
            time=reproduction.longest_flight.time,
            channels=reproduction.longest_flight.channels,
            scene=scene_of(reproduction.zero_g_model),
        ),
        tables=tables_text(reproduction, claims),
        provenance="\n".join(f"- **{what}**: `{value}`" for what, value in provenance.items()),
        properties={"seed": reproduction.extent.seed, "runs": reproduction.extent.runs},
    )


def _panels(figures: Sequence[PaperFigure]) -> tuple[ShownPanel, ...]:
    return tuple(
        ShownPanel(
            origin=f"{figure.key}/{panel.key}",
            title=f"{figure.title}: {panel.title} [{panel.unit}]",
            traces=tuple(_traces(f"{figure.key}/{panel.key}", panel)),
        )
        for figure in figures
        for panel in figure.panels
    )


def _traces(origin: str, panel: Panel) -> Iterator[Trace]:
    for curves in panel.curves:
        yield _trace(f"{origin}/{curves.name or panel.key}", curves)
    if panel.limit is not None:
        time = panel.curves[0].time[[0, -1]]
        levels = np.tile(np.kron([1.0, -1.0], panel.limit), (2, 1))
        colors = tuple(map(pale, AXIS_COLORS * 2))
        yield Trace(
            path=f"{origin}/limit", time=time, values=levels, names=("limit",) * 6, colors=colors, style="limit"
        )


def _trace(path: str, curves: Curves) -> Trace:
    behind = curves.style == "reference"
    return Trace(
        path=path,
        time=curves.time,
        values=curves.values,
        names=(curves.name,) * 3 if behind else AXES,
        colors=tuple(map(pale, AXIS_COLORS)) if behind else AXIS_COLORS,
        style=curves.style,
    )


def _boxes(maneuver: ManeuverStatistics) -> ShownBoxes:
    return ShownBoxes(
        name=maneuver.title,
        color=SHADES[f"maneuver-{maneuver.name}"].dark_rgb,
        boxes=tuple(map(_box, boxes_of(maneuver.errors["iv"]))),
    )


def _box(box: Box) -> ShownBox:
    return ShownBox(
        median=box.median,
        quartiles=(box.lower_quartile, box.upper_quartile),
        whiskers=(box.lowest, box.highest),
        outliers=box.outliers,
    )
