"""The maneuver: the reference body rate and gimbal angles."""

from __future__ import annotations

import numpy as np

from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.report.frame.blocks import Figure, Section
from testbed.report.frame.chart import line_chart
from testbed.report.frame.series import Line, signal_lines

_POINTS = 501
"""Samples of a maneuver's splines."""


def maneuver_section(maneuver: Maneuver, record: Record) -> Section:
    """Return the section of the reference body rate and the gimbal angles.

    Args:
        maneuver: the reference.
        record: of the flight, for the gimbal angles that it took.
    """
    time = np.linspace(0.0, maneuver.duration, _POINTS)
    rates = signal_lines("reference_body_rate", time, maneuver.reference(time).body_rate)
    rate_figure = Figure(
        title=f"Reference body rate, body axes: {maneuver.name}",
        chart=line_chart(rates, y_title="body rate, rad/s"),
        shares_time=True,
    )
    return Section(title="Maneuver", blocks=(rate_figure, *_gimbal_figures(maneuver, record)))


def _gimbal_figures(maneuver: Maneuver, record: Record) -> tuple[Figure, ...]:
    """Return the chart of the gimbal angles; none of a platform without gimbals."""
    if "true_gimbal_angle" not in record.channels:
        return ()
    flown = signal_lines("true_gimbal_angle", record.time, record.channels["true_gimbal_angle"])
    note = "" if maneuver.gimbal_angle is None else "Dashed: as designed. Solid: as flown."
    figure = Figure(
        title="Gimbal angles",
        chart=line_chart((*_designed(maneuver), *flown), y_title="gimbal angle, rad"),
        note=note,
        shares_time=True,
    )
    return (figure,)


def _designed(maneuver: Maneuver) -> tuple[Line, ...]:
    time = np.linspace(0.0, maneuver.duration, _POINTS)
    angle = maneuver.reference(time).gimbal_angle
    if angle is None:
        return ()
    return signal_lines("reference_gimbal_angle", time, angle, style="dashed", pale=True, listed=False)
