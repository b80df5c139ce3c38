"""Samples of one channel at their own times: from fields of a log to SI and body axes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isclose

import numpy as np
import scipy

from testbed.arrays import Array, Flags, Series
from testbed.errors import InputError
from testbed.logs.map import ABOUT_AXES, Channel, Clock, FlagRuns, axes_matrix
from testbed.logs.streams import Numbers, Stream, doubles
from testbed.logs.units import factor_to, is_unit_of
from testbed.rotation.quaternion import quaternion_product
from testbed.signals import AXES, QUATERNION, SIGNALS

MOST_DISORDER = 0.01
"""Share of a topic's samples that may stand behind a later one. Single messages overtake each other in a network; where
more do, the field is no clock, or the clock was set anew."""
_LAST_TICK = 2**63 - 1
"""ns; the year 2262 of clocks since 1970."""


@dataclass(frozen=True, kw_only=True)
class Ticks:
    """The times of a topic as its clock has them, not yet rounded to floating point.

    Attributes:
        values: integer nanoseconds, or seconds where the clock itself is in floating point; shape (N,).
        clock: what it is, for people: "timestamp in us".
    """

    values: Numbers
    clock: str

    @property
    def first(self) -> int | float:
        """Return the earliest: integer nanoseconds, or seconds; infinite of a topic without samples."""
        known = self.values[np.isfinite(self.values)]
        if not known.size:
            return inf
        return int(known.min()) if known.dtype.kind == "i" else float(known.min())

    def since(self, origin: int | float) -> Series:
        """Return the times in seconds since an origin, shape (N,).

        Args:
            origin: integer nanoseconds, or seconds in floating point.
        """
        if self.values.dtype.kind == "i":
            nanoseconds = origin if isinstance(origin, int) else round(origin * 1e9)
            return np.asarray((self.values - nanoseconds) / 1e9)
        return np.asarray(self.values - (origin / 1e9 if isinstance(origin, int) else origin))


@dataclass(frozen=True, kw_only=True)
class Samples:
    """A channel at its own times.

    Attributes:
        time: strictly increasing, shape (N,), s.
        values: SI, body axes, shape (N, width); NaN where a component was not sampled.
        converted: what was done to them, for people: "deg/s to rad/s, times 0.0174533".
        dropped: what was left out of them, in sentences.
    """

    time: Series
    values: Array
    converted: tuple[str, ...]
    dropped: tuple[str, ...]


def ticks_of(stream: Stream, source: Channel | FlagRuns, clock: Clock) -> Ticks:
    """Return the times of what a map names.

    Raises:
        InputError: there is no clock, its unit is not known, or no clock has such times.
    """
    name, unit = (source.time_field, source.time_unit) if source.time_field else (clock.field, clock.unit)
    if name is None:
        if stream.received is None:
            raise InputError("a table has no clock of its own: name its column of time, [clock] field and unit")
        return Ticks(values=_nanoseconds(stream.received, stream.received_unit), clock="time of the log")
    stated = stream.units.get(name, unit)
    if stated is None:
        raise InputError(f"the unit of the time in {name} is not known: give it, such as us, ms or s")
    return Ticks(values=_nanoseconds(stream.fields[name], stated), clock=f"{name} in {stated}")


def samples_of(
    name: str, channel: Channel, stream: Stream, time: Series, about: Sequence[str] | None = None
) -> Samples:
    """Return a channel in SI and body axes, its samples in the order of time.

    Args:
        name: of the channel.
        channel: what the map says of it.
        stream: its topic.
        time: of the topic's samples, shape (N,), s.
        about: body axes about which a rig turns, of which alone the channel may have fields; None for all.

    Raises:
        InputError: the times do not increase.
    """
    values = np.column_stack([doubles(stream.fields[field]) for field in channel.fields])
    infinite = np.isinf(values)
    values[infinite] = np.nan
    values, converted = _converted(name, channel, values)
    if about is not None and name in ABOUT_AXES and values.shape[1] < len(AXES):
        values, converted = _on_body_axes(name, values, about), (*converted, _said_about(name, about))
    time, values, dropped = _in_order(time + channel.offset_s, values, _filled(stream, channel))
    dropped = (*_contradicted(name, channel, stream), *dropped)
    if infinite.any():
        dropped = (f"{infinite.sum():,} infinite values taken as not sampled", *dropped)
    if channel.offset_s:
        converted = (*converted, f"times shifted by {channel.offset_s:+g} s")
    return Samples(time=time, values=values, converted=converted, dropped=tuple(f"{name}: {each}" for each in dropped))


def _contradicted(name: str, channel: Channel, stream: Stream) -> Iterator[str]:
    """Yield where the log states another unit of a channel's fields than the map does."""
    target = SIGNALS[name].unit
    for field in channel.fields:
        stated = stream.units.get(field)
        if stated is None or channel.unit is None or not is_unit_of(stated, target):
            continue
        if not isclose(factor_to(stated, target), factor_to(channel.unit, target)):
            yield f"{field} is in {stated} by the log, in {channel.unit} by the map, which is taken"


def _nanoseconds(ticks: Numbers, unit: str) -> Numbers:
    """Return integer ticks as integer nanoseconds, others in seconds.

    Raises:
        InputError: the unit is none of time, or the ticks go beyond the year 2262.
    """
    seconds = factor_to(unit, "s")
    nanoseconds = round(seconds * 1e9)
    if ticks.dtype.kind in "iu" and nanoseconds >= 1 and abs(nanoseconds - seconds * 1e9) < 1e-6 * nanoseconds:
        largest = int(np.abs(doubles(ticks)).max()) if ticks.size else 0
        if largest > _LAST_TICK // nanoseconds:
            raise InputError(f"a time of {largest:.4g} {unit} is beyond the year 2262: the clock has another unit")
        return ticks.astype(np.int64) * nanoseconds
    values = doubles(ticks)
    return values if seconds == 1.0 else values * seconds


def _converted(name: str, channel: Channel, values: Array) -> tuple[Array, tuple[str, ...]]:
    """Return values in SI and body axes, and what was done to them."""
    done: list[str] = []
    unit = SIGNALS[name].unit
    if channel.unit is not None and (factor := factor_to(channel.unit, unit)) != 1.0:
        values = values * factor
        done.append(f"{channel.unit} to {unit or 'a pure number'}, times {factor:.9g}")
    if channel.scale is not None:
        values = values * np.array(channel.scale)
        done.append(f"scaled by {', '.join(f'{scale:g}' for scale in channel.scale)}")
    if channel.axes is not None:
        matrix = axes_matrix(channel.axes)
        attitude = SIGNALS[name].components == QUATERNION
        values = _turned_attitude(values, matrix) if attitude else _turned(values, matrix)
        done.append(f"body x, y, z from the sensor's {', '.join(channel.axes)}")
    if SIGNALS[name].components == QUATERNION:
        values, scaled = _of_unit_length(values)
        done += scaled
    return values, tuple(done)


_UNIT = 1e-3
"""By which a quaternion's length may differ from 1: rounding of three digits."""


def _of_unit_length(values: Array) -> tuple[Array, list[str]]:
    """Return quaternions of unit length, those of none as not sampled, and what was done to them."""
    with np.errstate(over="ignore"):
        length = np.linalg.norm(values, axis=1, keepdims=True)
    none, said = length[:, 0] == 0.0, list[str]()
    if none.any():
        values = np.where(none[:, None], np.nan, values)
        said.append(f"{none.sum():,} quaternions of length 0 taken as not sampled")
    known = length[np.isfinite(length) & (length > 0.0)]
    if np.abs(known - 1.0).max(initial=0.0) > _UNIT:
        values = values / np.where(length > 0.0, length, 1.0)
        said.append(f"quaternions of length {known.min():.4g} to {known.max():.4g} scaled to unit length")
    return values, said


def _on_body_axes(name: str, values: Array, about: Sequence[str]) -> Array:
    """Return what was logged about some body axes, shape (N, n), as vectors, shape (N, 3).

    What about the others the gyro read is not known, and what acted there turned nothing.
    """
    vectors = np.full((len(values), len(AXES)), np.nan if name == "body_rate" else 0.0)
    vectors[:, [AXES.index(axis) for axis in about]] = values
    return vectors


def _said_about(name: str, about: Sequence[str]) -> str:
    others = ", ".join(axis for axis in AXES if axis not in about)
    return f"about {', '.join(about)} only: {others} {'left empty' if name == 'body_rate' else 'at 0'}"


def _turned(values: Array, matrix: Array) -> Array:
    """Return vectors in body axes; a permutation with signs touches no bit of a number."""
    order = np.abs(matrix).argmax(axis=1)
    return np.asarray(values[:, order] * matrix[np.arange(3), order])


def _turned_attitude(values: Array, matrix: Array) -> Array:
    """Return quat_NB of quat_NS, where the matrix takes S to B; NaN stays NaN."""
    quat_SB = scipy.spatial.transform.Rotation.from_matrix(matrix.T).as_quat(scalar_first=True)
    known = np.isfinite(values).all(axis=1) & (np.abs(values).max(axis=1, initial=0.0) > 0.0)
    turned = np.full_like(values, np.nan)
    turned[known] = quaternion_product(values[known], np.broadcast_to(quat_SB, values[known].shape))
    return turned


_EVEN = 0.1
"""Share of the usual interval by which none may differ: rows between belong to channels that come more often.

Source: that of held torques (`testbed.estimation.held`): clocks are read late by a tenth of a period."""


def _is_even(time: Series) -> bool:
    """Return whether a channel's samples lack nothing: they follow each other at one interval."""
    between = np.diff(time)
    return bool(len(between) and np.all(np.abs(between - np.median(between)) <= _EVEN * np.median(between)))


def _filled(stream: Stream, channel: Channel) -> Flags:
    """Return which rows of a topic hold a value of another channel, shape (N,): of a field that is empty at times."""
    others = [np.isfinite(doubles(field)) for name, field in stream.fields.items() if name not in channel.fields]
    partly = [each for each in others if not each.all()]
    rows = len(stream.fields[channel.fields[0]])
    return np.any(partly, axis=0) if partly else np.zeros(rows, dtype=bool)


_APART = 0.5
"""Share of the rows that hold another channel's values below which those with this one's as well are coincidences: rows
are those of one channel or another. Source: chosen, far from the none of them that such logs have, and from the all of
those with a row for each time."""


def _in_order(time: Series, values: Array, others: Flags) -> tuple[Series, Array, tuple[str, ...]]:
    """Return the samples whose time is later than all before them, and what was left out.

    Args:
        time: shape (N,), s.
        values: shape (N, C).
        others: rows that hold values of another channel, shape (N,).

    Raises:
        InputError: too many are not.
    """
    dropped = []
    known = np.isfinite(time) & ~np.isnan(values).all(axis=1)
    lost = ~known
    if np.count_nonzero(known & others) < _APART * np.count_nonzero(others):
        lost &= ~(others & np.isfinite(time))
    if lost.any() and not (np.isfinite(time).all() and _is_even(time[known])):
        dropped.append(f"{lost.sum():,} samples without time or value left out")
    time, values = time[known], values[known]
    empty = np.isnan(values)
    partial = empty[:, ~empty.all(axis=0)].any(axis=1)
    if partial.any():
        dropped.append(f"{partial.sum():,} samples lack some of their values: kept, with cells that are empty")
    repeated = _repeated(time, values)
    if repeated.any():
        dropped.append(f"{repeated.sum():,} samples that repeat the one before them left out")
    time, values = time[~repeated], values[~repeated]
    late = time <= np.maximum.accumulate(np.concatenate([[-inf], time[:-1]])) if time.size else np.zeros(0, dtype=bool)
    if late.sum() > MOST_DISORDER * time.size:
        place = int(np.argmax(late))
        fault = "repeats" if time[place] == time[place - 1] else "goes back from"
        raise InputError(
            f"its time does not increase at {late.sum():,} of {time.size:,} samples: at sample {place + 1} it {fault} "
            f"{time[place - 1]:.9g} s; take another clock, or cut the log where the clock was set"
        )
    if late.any():
        dropped.append(f"{late.sum():,} samples that are not later than the one before them left out")
    return time[~late], values[~late], tuple(dropped)


def _repeated(time: Series, values: Array) -> Flags:
    """Return which samples are the one before once more, shape (N,): time and values."""
    same = np.zeros(time.size, dtype=bool)
    if time.size:
        alike = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
        same[1:] = (time[1:] == time[:-1]) & alike.all(axis=1)
    return same


def origin_of(ticks: Mapping[str, Ticks], clock: Clock) -> int | float:
    """Return where time begins: integer nanoseconds, or seconds in floating point."""
    if clock.origin == "clock" or not ticks:
        return 0
    firsts = [each.first for each in ticks.values()]
    whole = [first for first in firsts if isinstance(first, int)]
    if len(whole) == len(firsts):
        return min(whole)
    return min(first / 1e9 if isinstance(first, int) else first for first in firsts)
