"""Conservation of momentum: what a free flight must not change."""

from __future__ import annotations

import numpy as np

from testbed.assembly.platform import PlatformModel
from testbed.records.record import Record
from testbed.report.frame.blocks import Figure, Paragraph, Section
from testbed.report.frame.chart import line_chart
from testbed.report.frame.series import component_lines
from testbed.report.wording import figures
from testbed.signals import AXES
from testbed.simulation.summary import FlightSummary


def conservation_section(record: Record, summary: FlightSummary, truth: PlatformModel) -> Section:
    """Return the section of the total momentum's drift.

    Args:
        record: of the flight.
        summary: its figures.
        truth: the platform that flew, for the momentum of its rotors.
    """
    momentum_N = record.channels["true_total_momentum"]
    scale = float(np.abs(truth.cluster.rotor_momentum).sum() + truth.wheels.momentum_limit.sum())
    drift = np.asarray(momentum_N - momentum_N[0]) / scale
    text = Paragraph(
        text="Nothing outside turns a free platform: its total momentum H, in inertial axes, stays as it was at the "
        f"start. The largest drift is {figures(summary.momentum_drift, 2)} of the rotors' momenta, Σ|h| = "
        f"{figures(1e3 * scale, 4)} mN·m·s; it is what integration and rounding cost."
    )
    figure = Figure(
        title="Drift of the total momentum, inertial axes",
        chart=line_chart(component_lines(AXES, record.time, drift), y_title="(H(t) - H(0)) / Σ|h|"),
        wide=True,
        shares_time=True,
    )
    return Section(title="Conservation of momentum", blocks=(text, figure))
