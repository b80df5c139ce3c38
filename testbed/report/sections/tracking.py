"""The tracking: true body rate beside the reference and the gyro's samples."""

from __future__ import annotations

import numpy as np

from testbed.records.record import Record
from testbed.report.frame.blocks import Cell, Column, Figure, Section, Table
from testbed.report.frame.chart import line_chart
from testbed.report.frame.series import Line, component_lines
from testbed.report.wording import figures
from testbed.signals import AXES
from testbed.simulation.summary import FlightSummary

_RATES = ("body_rate", "true_body_rate", "reference_body_rate")


def tracking_section(record: Record, summary: FlightSummary) -> Section:
    """Return the section of the body rate: true, reference and measured, and the tracking error."""
    axes = tuple(_axis_figure(record, axis) for axis in range(3))
    return Section(title="Tracking", blocks=(_table(summary), *axes, _error_figure(record)))


def _table(summary: FlightSummary) -> Table:
    columns = (Column(title="True rate minus reference"), *(Column(title=axis, unit="rad/s") for axis in AXES))
    rows = (("Root mean square", summary.tracking_rms), ("Largest magnitude", summary.tracking_max))
    return Table(
        columns=columns,
        rows=tuple((Cell(text=title), *(Cell(text=figures(value)) for value in values)) for title, values in rows),
    )


def _axis_figure(record: Record, axis: int) -> Figure:
    time = record.time
    measured, true, reference = (record.channels[name][:, axis] for name in _RATES)
    lines = (
        Line(name="measured", x=time, y=measured, color="measured", style="points"),
        Line(name="true", x=time, y=true, color="true"),
        Line(name="reference", x=time, y=reference, color="reference", style="dashed"),
    )
    return Figure(
        title=f"Body rate about {AXES[axis]}", chart=line_chart(lines, y_title="body rate, rad/s"), shares_time=True
    )


def _error_figure(record: Record) -> Figure:
    error = np.asarray(record.channels["true_body_rate"] - record.channels["reference_body_rate"])
    return Figure(
        title="Tracking error: true rate minus reference, body axes",
        chart=line_chart(component_lines(AXES, record.time, error), y_title="error, rad/s"),
        shares_time=True,
    )
