"""What a platform sent: every channel of a record that was measured, one chart each."""

from __future__ import annotations

import numpy as np

from testbed.records.record import Record
from testbed.report.frame.blocks import Figure
from testbed.report.frame.chart import Span, line_chart
from testbed.report.frame.series import Style, signal_lines
from testbed.report.wording import capitalized
from testbed.signals import SIGNALS

_LEFT_OUT = ("motor_thrust", "attitude", "acceleration")
"""Channels of which `applied_torque` and `body_rate` say the same."""
_SHOWN = tuple(signal.name for signal in SIGNALS.values() if signal.telemetry and signal.name not in _LEFT_OUT)


def telemetry_figures(record: Record) -> tuple[Figure, ...]:
    """Return one chart for each channel that the record holds; what lies outside its usable part is shaded."""
    return tuple(_figure(record, name) for name in _SHOWN if name in record.channels)


def _figure(record: Record, name: str) -> Figure:
    signal, values = SIGNALS[name], record.channels[name]
    style: Style = "points" if name == "body_rate" else "line"
    unusable = _unusable(record)
    return Figure(
        title=capitalized(signal.label),
        chart=line_chart(
            signal_lines(name, record.time, values, style=style),
            y_title=f"{signal.label.partition(',')[0]}, {signal.unit}",
            shaded=unusable,
        ),
        note="Shaded: not used." if unusable else "",
        shares_time=True,
    )


def _unusable(record: Record) -> tuple[Span, ...]:
    first, last = float(np.min(record.time)), float(np.max(record.time))
    start, end = record.details.usable_from, record.details.usable_to
    before = () if start is None or start <= first else (Span(start=first, end=start),)
    after = () if end is None or end >= last else (Span(start=end, end=last),)
    return before + after
