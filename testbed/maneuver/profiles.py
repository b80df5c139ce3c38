"""Maneuvers that are not designed: the paper's basic profile, and profiles from tables."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from itertools import chain
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv
from scipy.interpolate import BSpline, make_interp_spline

from testbed.arrays import Array, Series, Units
from testbed.errors import InputError
from testbed.files import read_bytes, readable
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.splines import DEGREE, clamped_spline
from testbed.quantities import LONGEST
from testbed.signals import MOST_UNITS, SIGNALS

_BODY_RATE = SIGNALS["body_rate"].columns
_GIMBAL_ANGLE, _WHEEL_SPEED = (SIGNALS[name].sized(MOST_UNITS).columns for name in ("gimbal_angle", "wheel_speed"))
_TIME = "time_s"
_FEWEST_ROWS = DEGREE + 1
_LARGEST_TABLE = 20_000_000
"""Bytes; a minute at 1 kHz of body rates and gimbal angles takes 12 MB."""
_LARGEST_ANGLE = 1e3
"""rad; gimbals may turn over and over, 160 times here."""
_PLAUSIBLE_RATE = 20.0
"""rad/s; no maneuver of a spacecraft comes near it, and degrees per second do."""
_BASIC_POINTS = np.array(
    [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0529, 0.0372, 0.0918],
        [0.0207, 0.0994, 0.0467],
        [-0.0611, 0.1593, -0.1146],
        [0.0144, 0.1616, -0.2197],
        [0.1938, 0.1753, -0.1638],
        [0.1815, 0.1321, -0.0621],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
    ]
)
"""rad/s. The paper shows its basic profile only as a plot; these points were fitted to the basic rows of its Tables 1
and 2 by `python tools/fit_basic_profile.py`, which explains how."""


def basic_profile(*, duration: float = 5.0, scale: float = 1.0) -> Maneuver:
    """Return the paper's basic profile: all axes excited, differently, from rest to rest, peak 0.2 rad/s times scale.

    Args:
        duration: s; the paper's is 5.
        scale: factor on the body rate; 1.5 is the paper's scaled profile.

    Source: paper section 5.1, Fig. 1 and Table 1.
    """
    return Maneuver(name="basic", duration=duration, body_rate=clamped_spline(duration, scale * _BASIC_POINTS))


def read_profile(path: Path, units: int, wheel_inertia: Units) -> Maneuver:
    """Return the maneuver of a CSV table: time_s, the body rate, and optionally gimbal angles and wheel speeds.

    A cubic spline goes through the rows; its time starts at the first.

    Args:
        path: columns are named as in a record.
        units: how many gimbals the platform has; the table has the angles of all of them or of none.
        wheel_inertia: of its W wheels about their axes, shape (W,), kg·m²; the table has the speeds of all of them or
            of none.

    Raises:
        InputError: the file cannot be used; the message names file, column or row, and remedy.
    """
    counts = {_GIMBAL_ANGLE: units, _WHEEL_SPEED: len(wheel_inertia)}
    columns = _columns(path, counts)
    _refuse(path, _problems(columns))
    time = columns[_TIME] - columns[_TIME][0]
    gimbals, turning = (_columns_of_all(columns, names, count) for names, count in counts.items())
    return Maneuver(
        name=readable(path.stem),
        duration=float(time[-1]),
        body_rate=_spline(time, columns, _BODY_RATE),
        gimbal_angle=_spline(time, columns, gimbals) if gimbals else None,
        wheel_momentum=_spline(time, columns, turning, wheel_inertia) if turning else None,
    )


def _columns(path: Path, counts: Mapping[tuple[str, ...], int]) -> dict[str, Array]:
    """Read the columns that a profile knows, as numbers; others are passed over."""
    content = read_bytes(path, "the maneuver's table, relative to the scenario's folder", _LARGEST_TABLE)
    known = (_TIME, *_BODY_RATE, *_GIMBAL_ANGLE, *_WHEEL_SPEED)
    numbers = csv.ConvertOptions(column_types=dict.fromkeys(known, pa.float64()))
    try:
        table = csv.read_csv(pa.BufferReader(content), convert_options=numbers)
        names = table.column_names
    except (OSError, pa.ArrowInvalid, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a table of numbers: {error}") from error
    _refuse(path, _name_problems(names, counts))
    return {name: table[name].to_numpy() for name in known if name in names}


def _columns_of_all(names: Collection[str], columns: tuple[str, ...], count: int) -> tuple[str, ...]:
    """Return the columns of all gimbals or wheels, if a table has that of any."""
    return columns[:count] if set(columns) & set(names) else ()


def _name_problems(names: list[str], counts: Mapping[tuple[str, ...], int]) -> Iterator[str]:
    of_actuators = [_columns_of_all(names, columns, count) for columns, count in counts.items()]
    wanted = (_TIME, *_BODY_RATE, *chain.from_iterable(of_actuators))
    missing = [name for name in wanted if name not in names]
    if missing:
        yield f"has no column {', '.join(missing)}; its columns are {', '.join(names)}"
    for (columns, count), kind in zip(counts.items(), ("units", "wheels"), strict=True):
        too_many = [name for name in columns[count:] if name in names]
        if too_many:
            yield f"has column {', '.join(too_many)}, but the platform has {count} {kind}; leave it out"
    repeated = sorted({name for name in wanted if names.count(name) > 1})
    if repeated:
        yield f"has column {', '.join(repeated)} more than once; keep one of each"


def _problems(columns: Mapping[str, Array]) -> Iterator[str]:
    rows = len(columns[_TIME])
    if rows < _FEWEST_ROWS:
        yield f"has {rows} rows; a cubic spline needs at least {_FEWEST_ROWS}"
    for name, values in columns.items():
        gaps = np.flatnonzero(~np.isfinite(values))
        if gaps.size:
            yield f"{name} is not a finite number in row {gaps[0] + 1}; fill it in or leave the row out"
    fastest = max(float(np.abs(columns[name]).max(initial=0.0)) for name in _BODY_RATE)
    if fastest > _PLAUSIBLE_RATE:
        yield f"has body rates of up to {fastest:.3g} rad/s; if these are deg/s, divide them by 57.29578"
    widest = max(
        (float(np.abs(columns[name]).max(initial=0.0)) for name in _GIMBAL_ANGLE if name in columns), default=0.0
    )
    if widest > _LARGEST_ANGLE:
        yield f"has gimbal angles of up to {widest:.3g} rad; if these are deg, divide them by 57.29578"
    longest = float(np.ptp(columns[_TIME])) if rows else 0.0
    if longest > LONGEST:
        yield f"lasts {longest:.4g} s, at most {LONGEST:g} s are flown; if {_TIME} is in ms, divide it by 1000"
    backward = np.flatnonzero(np.diff(columns[_TIME]) <= 0.0)
    if backward.size:
        yield f"{_TIME} does not increase from row {backward[0] + 1} to row {backward[0] + 2}; sort the rows by time"


def _refuse(path: Path, problems: Iterator[str]) -> None:
    lines = [f"{path}: {problem}" for problem in problems]
    if lines:
        raise InputError("\n".join(lines))


def _spline(time: Series, columns: Mapping[str, Array], names: tuple[str, ...], scale: Array | float = 1.0) -> BSpline:
    return make_interp_spline(time, scale * np.stack([columns[name] for name in names], axis=1), k=DEGREE)
