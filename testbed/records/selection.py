"""Parts of a record: the usable time, the rows of one channel, the telemetry alone."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from testbed.arrays import Array, Flags, Series
from testbed.errors import InputError
from testbed.records.checks import too_few_samples
from testbed.records.record import Record
from testbed.signals import SIGNALS


def usable(record: Record) -> Record:
    """Return the part of a run between usable_from and usable_to, both included.

    Raises:
        InputError: too few gyro samples are left.
    """
    details = record.details
    start = -inf if details.usable_from is None else details.usable_from
    end = inf if details.usable_to is None else details.usable_to
    part = _rows_of(record, (record.time >= start) & (record.time <= end))
    if problem := too_few_samples(part.channels["body_rate"]):
        bounded = details.usable_from is not None or details.usable_to is not None
        where = f"between usable_from = {start:g} s and usable_to = {end:g} s, " if bounded else ""
        raise InputError(f"{details.name}: {where}{problem}")
    return part


def sampled(record: Record, name: str) -> tuple[Series, Array]:
    """Return the times at which a channel was sampled, shape (N,), s, and its values there, shape (N, width).

    Raises:
        InputError: the record does not hold the channel; the message lists those that it does.
    """
    if name not in record.channels:
        held = ", ".join(record.channels)
        raise InputError(f"{record.details.name}: channel {name} is needed; the record holds {held}")
    values = record.channels[name]
    rows = np.isfinite(values).all(axis=1)
    return record.time[rows], values[rows]


def telemetry_only(record: Record) -> Record:
    """Return the record without anything that a flown platform could not have sent.

    Columns that the signal table does not know go too: nothing vouches for them.
    """
    telemetry = {name: values for name, values in record.channels.items() if SIGNALS[name].telemetry}
    return replace(record, channels=telemetry, extra_columns={})


def _rows_of(record: Record, rows: Flags) -> Record:
    return replace(
        record,
        time=record.time[rows],
        channels={name: values[rows] for name, values in record.channels.items()},
        extra_columns={name: values[rows] for name, values in record.extra_columns.items()},
    )
