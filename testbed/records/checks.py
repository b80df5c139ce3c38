"""What makes a table unusable as a record: each check returns messages that name column, row and remedy.

Rows are counted from 1, the header not included.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from testbed.arrays import Array, Flags, Series
from testbed.errors import InputError
from testbed.records.foreign_units import foreign_column_problem, si_column
from testbed.signals import KINDS, SIGNALS, TURNED_BY, Signal, present_signals

MINIMUM_SAMPLES = 10
"""Gyro samples that a run needs: with 3 equations each, three times as many as its 9 unknowns (6 inertia, 3 rates)."""

LARGEST_BODY_RATE = 1e4
"""Largest body rate, rad/s, that is read: three times what the widest gyros show in deg/s. Whether it is in rad/s is
asked where there is a platform to compare with (`diagnosis/gate.py`)."""
SLOWEST_PERIOD = 10.0
"""s; the slowest sampling that is taken for seconds: 80 Hz in milliseconds is 12.5 a row."""
LARGEST_ACTUATION = 1e9
"""Largest value, SI, that is believed of an actuator; its square and its integrals are still far from overflow."""
LONGEST_RUN = 2e4
"""s; a prediction takes 64 points a second, and a longer run would fill the memory."""

_UNIT = 0.05
"""By which the length of a quaternion may differ from 1: by rounding, or as a mean of some samples."""

_ACTUATION = (*TURNED_BY, "rotor_speed")
_LISTED = 10


def refuse(path: Path, problems: Sequence[str]) -> None:
    """Raise what is wrong with a file, if anything is.

    Raises:
        InputError: there are problems; the message names the file and lists them.
    """
    if problems:
        raise InputError(listing(path, problems))


def listing(path: Path, problems: Sequence[str]) -> str:
    """Return a file's problems as one message: on one line if it is a single one, else one line each."""
    if len(problems) == 1:
        return f"{path}: {problems[0]}"
    more = [f"... and {len(problems) - _LISTED} more"] if len(problems) > _LISTED else []
    return "\n  ".join([f"{path}:", *problems[:_LISTED], *more])


def column_problems(columns: Sequence[str]) -> list[str]:
    """Check the header alone: blanks, units, repeated, missing and half-present columns."""
    blank = [column for column in columns if column != column.strip()]
    if blank:
        return [f"column names begin or end with a blank, such as {blank[0]!r}: take the blanks out of the header"]
    present = {si_column(column) for column in columns}
    if not any(present_signals(present)):
        return [
            f"none of its columns is a channel of a record: {', '.join(columns)}; if it is the log of another program, "
            "testbed import makes a record of it, and testbed import LOG --guess proposes how"
        ]
    return [
        *(problem for column in columns if (problem := foreign_column_problem(column))),
        *(f"column {column} appears {count} times" for column, count in Counter(columns).items() if count > 1),
        *([] if "time_s" in present else [f"column time_s is missing; the columns are {', '.join(columns)}"]),
        *(problem for signal in present_signals(present) if (problem := _half_present(signal, present))),
        *_uneven(present),
        *_missing_channels(present),
    ]


def value_problems(time: Series, channels: Mapping[str, Array]) -> list[str]:
    """Check the numbers: the time base, then each channel."""
    problems = [*_time_problems(time), *_sampling_problems(time)]
    for name, values in channels.items():
        empty_allowed = name == "body_rate" and bool(live_columns(values).any())  # a rig turns about some axes only
        for column, series in zip(SIGNALS[name].sized(values.shape[1]).columns, values.T, strict=True):
            problems += [
                *_series_problems(column, series, needed=name == "body_rate", empty_allowed=empty_allowed),
                *(_size_problems(column, series) if name in _ACTUATION else ()),
            ]
    return [
        *problems,
        *_body_rate_problems(channels["body_rate"]),
        *_attitude_problems(channels.get("attitude", np.zeros((0, 4)))),
    ]


def _attitude_problems(quaternions: Array) -> Iterator[str]:
    """Find quaternions that are none of an attitude; zeros and empty cells stand for no sample."""
    with np.errstate(over="ignore"):
        length = np.linalg.norm(quaternions, axis=1)
    wrong = np.flatnonzero(np.isfinite(quaternions).all(axis=1) & (length > 0.0) & (np.abs(length - 1.0) > _UNIT))
    if len(wrong):
        row = int(wrong[0])
        yield (
            f"attitude has quaternions that are not of unit length: {length[row]:.4g} in row {row + 1}; give them with "
            "the scalar first, divided by their length"
        )


def too_few_samples(body_rate: Array) -> str | None:
    """Return what to say where fewer rows than `MINIMUM_SAMPLES` hold a gyro sample; None where there are enough."""
    count = int(sampled_rows(body_rate).sum())
    if count >= MINIMUM_SAMPLES:
        return None
    return f"body_rate has {count} samples, at least {MINIMUM_SAMPLES} are needed: take a longer part of the run"


def live_columns(values: Array) -> Flags:
    """Return which columns of a channel, shape (N, W), hold any value, shape (W,)."""
    return np.asarray(~np.isnan(values).all(axis=0))


def sampled_rows(values: Array) -> Flags:
    """Return in which rows a channel was sampled, shape (N,): all its columns that hold any value have one there.

    Args:
        values: shape (N, W); an axis that a rig does not turn about may be empty throughout.
    """
    live = live_columns(values)
    return np.asarray(np.isfinite(values[:, live]).all(axis=1) & live.any())


def too_long(time: Series) -> str | None:
    """Return what to say of a run whose prediction would fill the memory; None of any other."""
    duration = float(np.ptp(time)) if len(time) else 0.0
    if duration <= LONGEST_RUN:
        return None
    pause = int(np.argmax(np.diff(time)))
    longest = float(time[pause + 1] - time[pause])
    if longest > 0.5 * duration:
        return (
            f"pauses for {longest:.4g} s from {time[pause]:.4g} s on, and at most {LONGEST_RUN:g} s can be used as one "
            "run: make a run of each part, or set usable_from_s and usable_to_s in its .toml"
        )
    return (
        f"lasts {duration:.4g} s, at most {LONGEST_RUN:g} s can be used: set usable_from_s and usable_to_s in its .toml"
    )


def _half_present(signal: Signal, present: set[str]) -> str | None:
    missing = [column for column in signal.columns if column not in present]
    if not missing or len(missing) == signal.width:
        return None
    empty = " (empty where a rig does not turn about them)" if signal.name == "body_rate" else ""
    return f"channel {signal.name} is incomplete: add {', '.join(missing)}{empty}, or take its other columns out"


def _uneven(present: set[str]) -> Iterator[str]:
    """Find channels of actuators of one kind that differ in how many of them they have."""
    sent = [signal for signal in present_signals(present) if signal.telemetry]
    for kind in KINDS:
        widths = {signal.name: signal.width for signal in sent if signal.per == kind}
        if len(set(widths.values())) > 1:
            said = ", ".join(f"{name} {width}" for name, width in widths.items())
            yield f"channels differ in the number of {kind}s: {said}; give each {kind} a column in every channel"


def _missing_channels(present: set[str]) -> Iterator[str]:
    if present.isdisjoint(SIGNALS["body_rate"].columns):
        yield f"channel body_rate is missing: add {', '.join(SIGNALS['body_rate'].columns)}"
    if all(present.isdisjoint(SIGNALS[name].columns) for name in TURNED_BY):
        yield f"no channel says what turned the platform: add one of {', '.join(TURNED_BY)}"


def _time_problems(time: Series) -> Iterator[str]:
    if not np.isfinite(time).all():
        yield f"time_s in {_rows(~np.isfinite(time))} is not a finite number: fill in the time, or take the row out"
    step = np.diff(time)
    if (step <= 0.0).any():
        row = int(np.argmax(step <= 0.0)) + 1
        fault = "repeats" if step[row - 1] == 0.0 else "goes back from"
        yield f"time_s in row {row + 1} {fault} {time[row - 1]:.10g} s: sort the rows by time and keep one of each"


def _sampling_problems(time: Series) -> Iterator[str]:
    """Find a time base that is not in seconds: no telemetry of a maneuver is that slow."""
    if len(time) > 1 and (period := float(np.median(np.diff(time)))) > SLOWEST_PERIOD:
        yield (
            f"time_s grows by {period:.4g} a row, not as seconds do: divide it by 1e3 (ms), 1e6 (us) or 1e9 (ns); of "
            "an imported log, correct unit in [clock] of the map"
        )


def _series_problems(column: str, series: Series, *, needed: bool, empty_allowed: bool) -> Iterator[str]:
    if series.size and np.isnan(series).all() and not empty_allowed:
        remedy = "fill it, no run is of use without it" if needed else "fill it, or take the channel out"
        yield f"column {column} has no value in any row: {remedy}"
    if np.isinf(series).any():
        yield f"column {column} is infinite in {_rows(np.isinf(series))}: leave empty what was not sampled"


def _size_problems(column: str, series: Series) -> Iterator[str]:
    beyond = np.isfinite(series) & (np.abs(series) > LARGEST_ACTUATION)
    if beyond.any():
        peak = np.abs(series[beyond]).max()
        yield f"column {column} reaches {peak:.3g} in {_rows(beyond)}: bring it to SI, or leave faulty values empty"


def _body_rate_problems(body_rate: Array) -> Iterator[str]:
    if problem := too_few_samples(body_rate):
        yield problem
    for column, rate in zip(SIGNALS["body_rate"].columns, body_rate.T, strict=True):
        fast = np.isfinite(rate) & (np.abs(rate) > LARGEST_BODY_RATE)
        if fast.any():
            peak = np.abs(rate[fast]).max()
            yield (
                f"column {column} reaches {peak:.4g} rad/s in {_rows(fast)}: bring it to rad/s, or leave faulty values "
                "empty"
            )


def _rows(flags: Flags) -> str:
    count = int(flags.sum())
    return f"row {int(np.argmax(flags)) + 1}" + (f" and {count - 1} more" if count > 1 else "")
