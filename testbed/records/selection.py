"""Parts of a record: the usable time, the rows of one channel, the telemetry alone."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from testbed.arrays import Array, Flags, Series
from testbed.errors import InputError
from testbed.records.checks import sampled_rows, too_few_samples, too_long
from testbed.records.record import Record, RunDetails
from testbed.signals import SIGNALS


def usable(record: Record) -> Record:
    """Return the part of a run between usable_from and usable_to, both included.

    Raises:
        InputError: too few gyro samples are left, or a run that is too long.
    """
    details = record.details
    start, end = _usable_span(details)
    part = _rows_of(record, (record.time >= start) & (record.time <= end))
    if problem := too_few_samples(part.channels["body_rate"]) or too_long(part.time):
        raise InputError(f"{details.name}: {_limits(details)}{problem}")
    return part


def in_parts(record: Record, most: int) -> list[Record]:
    """Return a record in consecutive parts of equal length, as few as have at most so many gyro samples each.

    Args:
        record: its usable time counts.
        most: gyro samples of a part.
    """
    start, end = _usable_span(record.details)
    time = record.time[sampled_rows(record.channels["body_rate"])]
    time = time[(time >= start) & (time <= end)]
    count = -(-len(time) // most)
    if count <= 1:
        return [record]
    return [
        part_of(record, number, float(part[0]), float(part[-1]))
        for number, part in enumerate(np.array_split(time, count), start=1)
    ]


def part_of(record: Record, number: int, first: float, last: float) -> Record:
    """Return a numbered part of a record, usable from one time to another, s."""
    name = f"{record.details.name} part {number}"
    return replace(record, details=replace(record.details, name=name, usable_from=first, usable_to=last))


def sampled(record: Record, name: str) -> tuple[Series, Array]:
    """Return the times at which a channel was sampled, shape (N,), s, and its values there, shape (N, width).

    A column that is empty throughout, of an axis that a rig does not turn about, stays empty (NaN).

    Raises:
        InputError: the record does not hold the channel; the message lists those that it does.
    """
    if name not in record.channels:
        held = ", ".join(record.channels)
        raise InputError(f"{record.details.name}: channel {name} is needed; the record holds {held}")
    values = record.channels[name]
    rows = sampled_rows(values)
    return record.time[rows], values[rows]


def telemetry_only(record: Record) -> Record:
    """Return the record without anything that a flown platform could not have sent.

    Columns that the signal table does not know go too: nothing vouches for them.
    """
    telemetry = {name: values for name, values in record.channels.items() if SIGNALS[name].telemetry}
    return replace(record, channels=telemetry, extra_columns={})


def _usable_span(details: RunDetails) -> tuple[float, float]:
    """Return the first and the last usable time, s; infinite where the run states none."""
    start = -inf if details.usable_from is None else details.usable_from
    return start, inf if details.usable_to is None else details.usable_to


def _limits(details: RunDetails) -> str:
    """Say which limits the run states, such as `from usable_from_s = 1 s to usable_to_s = 3 s, `; nothing if none."""
    start = [] if details.usable_from is None else [f"from usable_from_s = {details.usable_from:g} s"]
    end = [] if details.usable_to is None else [f"to usable_to_s = {details.usable_to:g} s"]
    return " ".join([*start, *end]) + ", " if start or end else ""


def _rows_of(record: Record, rows: Flags) -> Record:
    return replace(
        record,
        time=record.time[rows],
        channels={name: values[rows] for name, values in record.channels.items()},
        extra_columns={name: values[rows] for name, values in record.extra_columns.items()},
    )
