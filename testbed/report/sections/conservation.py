"""Conservation of momentum: what a free flight must not change."""

from __future__ import annotations

import numpy as np

from testbed.assembly.platform import PlatformModel
from testbed.dynamics.environment import Pivoted
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
    scale = truth.held_capacity
    drift = np.asarray(momentum_N - momentum_N[0]) / scale
    said, title = _words(truth)
    text = Paragraph(
        text=f"{said} The largest drift is {figures(summary.momentum_drift, 2)} of the rotors' momenta, Σ|h| = "
        f"{figures(1e3 * scale, 4)} mN·m·s; it is what integration and rounding cost."
    )
    figure = Figure(
        title=title,
        chart=line_chart(component_lines(AXES, record.time, drift), y_title="(H(t) - H(0)) / Σ|h|"),
        wide=True,
        shares_time=True,
    )
    return Section(title="Conservation of momentum", blocks=(text, figure))


def _words(truth: PlatformModel) -> tuple[str, str]:
    """Return what is conserved of a platform, and what the chart of its total momentum shows."""
    if truth.environment is None:
        said = (
            "Nothing outside turns a free platform: its total momentum H, in inertial axes, stays as it was at the "
            "start."
        )
        return said, "Drift of the total momentum, inertial axes"
    about = "about the pivot, " if isinstance(truth.environment, Pivoted) else ""
    said = (
        f"What acts from outside changes the total momentum H, {about}in inertial axes, as the chart shows. The drift "
        "is that of H without the impulse of the environment along the flight."
    )
    return said, "Change of the total momentum, inertial axes"
