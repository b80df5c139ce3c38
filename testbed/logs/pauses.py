"""Where a log lacks samples within its runs: pauses, which may be two flights, and losses of a moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbed.arrays import Series
from testbed.estimation.gaps import gaps
from testbed.records.record import Record
from testbed.records.selection import sampled

_PAUSE = 1.0
"""s without a sample of the gyro within a run from which on it is pointed at: a loss of telemetry for a moment lasts
less, and a proposed map cuts there."""
_PAUSE_STEPS = 20
"""Steps of the gyro that a pause has at least, for gyros with less than 20 samples a second."""
_REGULAR = 0.1
"""Share of a channel's intervals that may be gaps of a stream that comes at a rate; one with more has none, such as
commands that are sent when they change.

Source: chosen; a link that loses a tenth of its packets is still one that sends at a rate."""


def pauses(records: Sequence[Record]) -> Iterator[str]:
    """Yield where samples are missing in runs, in sentences; of a run whose gyro pauses nothing but that."""
    for record in records:
        pause = _pause(record)
        if pause:
            yield pause
            continue
        for channel in record.channels:
            time, _ = sampled(record, channel)
            if lost := _lost(time):
                yield f"{record.details.name}: {channel} {lost}"


def _pause(record: Record) -> str:
    """Return where the gyro pauses; empty where it does not."""
    time, _ = sampled(record, "body_rate")
    step = np.diff(time)
    if step.max() <= max(_PAUSE, _PAUSE_STEPS * float(np.median(step))):
        return ""
    return (
        f"{record.details.name}: the body rate pauses for {_longest(time)}; if these are two flights, cut there: "
        '[runs] kind = "gaps", longer_than_s = 1.0'
    )


def _lost(time: Series) -> str:
    """Return how many samples a channel lacks, and where the most; empty where it lacks none."""
    missing = gaps(time)
    if not missing.any() or missing.mean() > _REGULAR:
        return ""
    step = np.diff(time)
    lost = int(np.sum(np.round(step[missing] / np.median(step)) - 1.0))
    times = "once" if missing.sum() == 1 else f"{missing.sum()} times, at most"
    return f"lacks some {lost} of {len(time) + lost} samples: it has none {times} for {_longest(time)}"


def _longest(time: Series) -> str:
    step = np.diff(time)
    longest = int(np.argmax(step))
    return f"{step[longest]:.4g} s from {time[longest]:.4g} s on"
