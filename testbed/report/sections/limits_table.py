"""How much of each limit a flight used."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.report.frame.blocks import Cell, Column, Table, Tone
from testbed.report.wording import capitalized, figures
from testbed.signals import LIMITS, SIGNALS
from testbed.simulation.summary import FlightLimits, FlightSummary


def limits_table(summary: FlightSummary, limits: FlightLimits) -> Table:
    """Return the table of limits and the largest share of each that the flight used."""
    rows = tuple(
        (
            Cell(text=capitalized(LIMITS[name])),
            Cell(text=f"{_allowed(limits[name])} {SIGNALS[f'true_{name}'].unit}"),
            Cell(text=f"{100.0 * share:.1f}", tone=_tone(share)),
        )
        for name, share in summary.limit_use.items()
    )
    columns = (Column(title="Limit"), Column(title="allowed"), Column(title="largest use", unit="%"))
    return Table(columns=columns, rows=rows, note=_note(summary))


def _allowed(limit: float | Array) -> str:
    return ", ".join(figures(value) for value in np.atleast_1d(limit))


def _tone(share: float) -> Tone:
    return "warn" if share > 1.0 else "plain"


def _note(summary: FlightSummary) -> str:
    if summary.min_singularity_measure is None:
        return f"Time in which a wheel was at its torque limit: {summary.saturated:.4g} s."
    return (
        f"Time in which a gimbal was at its rate or torque limit: {summary.saturated:.4g} s. "
        f"Smallest singularity measure: {figures(summary.min_singularity_measure)}."
    )
