"""How much of each limit a flight used."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.report.frame.blocks import Cell, Column, Table, Tone
from testbed.report.wording import capitalized, figures
from testbed.simulation.summary import FlightLimits, FlightSummary

LIMIT_NAMES = {
    "gimbal_rate": "gimbal rate",
    "gimbal_torque": "gimbal motor torque",
    "cluster_momentum": "cluster momentum",
    "cluster_torque": "cluster torque",
    "wheel_torque": "wheel motor torque",
    "wheel_speed": "wheel speed",
}
"""Limits by the name that a flight's summary gives them."""

_UNITS = {
    "gimbal_rate": "rad/s",
    "gimbal_torque": "N·m",
    "cluster_momentum": "N·m·s",
    "cluster_torque": "N·m",
    "wheel_torque": "N·m",
    "wheel_speed": "rad/s",
}


def limits_table(summary: FlightSummary, limits: FlightLimits) -> Table:
    """Return the table of limits and the largest share of each that the flight used."""
    rows = tuple(
        (
            Cell(text=capitalized(LIMIT_NAMES[name])),
            Cell(text=f"{_allowed(getattr(limits, name))} {_UNITS[name]}"),
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
