"""How the flights of a campaign went: tracking, saturation, singularity, conservation."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from testbed.arrays import Series
from testbed.report.frame.blocks import Cell, Column, Section, Table
from testbed.report.wording import figures

_ROWS = (
    *((f"tracking_rms_{axis}_rad_s", f"Tracking error about {axis}, rms", "rad/s") for axis in "xyz"),
    ("saturated_s", "Time with a gimbal at its limit", "s"),
    ("min_singularity_measure", "Smallest singularity measure", "1 at the best"),
    ("momentum_drift_relative", "Drift of the total momentum", "of the rotors'"),
    ("first_contact_s", "First contact with the cabin", "s"),
)


def flights_section(table: pa.Table) -> Section:
    """Return the section of the completed flights' figures.

    Args:
        table: the runs.
    """
    flown = table.filter(pc.equal(table["outcome"], "completed"))
    rows = [_row(title, unit, _known(flown, name)) for name, title, unit in _ROWS if len(_known(flown, name))]
    columns = (
        Column(title="Completed flights"),
        Column(title="unit"),
        Column(title="smallest"),
        Column(title="median"),
        Column(title="largest"),
        Column(title="flights"),
    )
    return Section(title="Flights", blocks=(Table(columns=columns, rows=tuple(rows)),))


def _known(flown: pa.Table, name: str) -> Series:
    return np.asarray(flown[name].drop_null().to_numpy(), dtype=np.float64)


def _row(title: str, unit: str, values: Series) -> tuple[Cell, ...]:
    shown = (figures(float(value)) for value in (values.min(), np.median(values), values.max()))
    return Cell(text=title), Cell(text=unit), *(Cell(text=text) for text in shown), Cell(text=str(len(values)))
