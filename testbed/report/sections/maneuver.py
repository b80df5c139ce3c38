"""The maneuver: the reference body rate, gimbal angles and wheel speeds."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.arrays import Array, Series
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.report.frame.blocks import Figure, Section
from testbed.report.frame.chart import line_chart
from testbed.report.frame.series import Line, signal_lines

_POINTS = 501
"""Samples of a maneuver's splines."""


def maneuver_section(maneuver: Maneuver, record: Record) -> Section:
    """Return the section of the reference body rate, the gimbal angles and the wheel speeds.

    Args:
        maneuver: the reference.
        record: of the flight, for what gimbals and wheels did.
    """
    time = np.linspace(0.0, maneuver.duration, _POINTS)
    rates = signal_lines("reference_body_rate", time, maneuver.reference(time).body_rate)
    rate_figure = Figure(
        title=f"Reference body rate, body axes: {maneuver.name}",
        chart=line_chart(rates, y_title="body rate, rad/s"),
        shares_time=True,
    )
    return Section(title="Maneuver", blocks=(rate_figure, *_actuator_figures(maneuver, record)))


def _actuator_figures(maneuver: Maneuver, record: Record) -> Iterator[Figure]:
    """Yield the chart of the gimbal angles, and that of wheels whose speeds the maneuver prescribes."""
    channels, time = record.channels, np.linspace(0.0, maneuver.duration, _POINTS)
    if "true_gimbal_angle" in channels:
        angle = maneuver.reference(time).gimbal_angle
        designed = () if angle is None else _pale("reference_gimbal_angle", time, angle)
        flown = signal_lines("true_gimbal_angle", record.time, channels["true_gimbal_angle"])
        yield _figure("Gimbal angles", "gimbal angle, rad", designed, flown)
    if "reference_wheel_speed" in channels:
        designed = _pale("reference_wheel_speed", record.time, channels["reference_wheel_speed"])
        flown = signal_lines("true_wheel_speed", record.time, channels["true_wheel_speed"])
        yield _figure("Wheel speeds", "wheel speed, rad/s", designed, flown)


def _figure(title: str, y_title: str, designed: tuple[Line, ...], flown: tuple[Line, ...]) -> Figure:
    return Figure(
        title=title,
        chart=line_chart((*designed, *flown), y_title=y_title),
        note="Dashed: as designed. Solid: as flown." if designed else "",
        shares_time=True,
    )


def _pale(signal: str, time: Series, values: Array) -> tuple[Line, ...]:
    return signal_lines(signal, time, values, style="dashed", pale=True, listed=False)
