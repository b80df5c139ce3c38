"""Maneuvers that are not designed: the paper's basic profile, and profiles from tables."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv
from scipy.interpolate import BSpline, make_interp_spline

from testbed.arrays import Array, Series
from testbed.errors import InputError
from testbed.files import read_bytes, readable
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.splines import DEGREE, clamped_spline
from testbed.quantities import LONGEST
from testbed.signals import MOST_UNITS, SIGNALS

_BODY_RATE, _GIMBAL_ANGLE = SIGNALS["body_rate"].columns, SIGNALS["gimbal_angle"].sized(MOST_UNITS).columns
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


def read_profile(path: Path, units: int) -> Maneuver:
    """Return the maneuver of a CSV table: time_s, the body rate, and optionally the gimbal angles.

    A cubic spline goes through the rows; its time starts at the first.

    Args:
        path: columns are named as in a record.
        units: how many gimbals the platform has; the table has the angles of all of them or of none.

    Raises:
        InputError: the file cannot be used; the message names file, column or row, and remedy.
    """
    columns = _columns(path, units)
    _refuse(path, _problems(columns))
    time = columns[_TIME] - columns[_TIME][0]
    gimbals = _gimbal_columns(columns, units)
    return Maneuver(
        name=readable(path.stem),
        duration=float(time[-1]),
        body_rate=_spline(time, columns, _BODY_RATE),
        gimbal_angle=_spline(time, columns, gimbals) if gimbals else None,
    )


def _columns(path: Path, units: int) -> dict[str, Array]:
    """Read the columns that a profile knows, as numbers; others are passed over."""
    content = read_bytes(path, "the maneuver's table, relative to the scenario's folder", _LARGEST_TABLE)
    known = (_TIME, *_BODY_RATE, *_GIMBAL_ANGLE)
    numbers = csv.ConvertOptions(column_types=dict.fromkeys(known, pa.float64()))
    try:
        table = csv.read_csv(pa.BufferReader(content), convert_options=numbers)
        names = table.column_names
    except (OSError, pa.ArrowInvalid, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a table of numbers: {error}") from error
    _refuse(path, _name_problems(names, units))
    return {name: table[name].to_numpy() for name in known if name in names}


def _gimbal_columns(names: Collection[str], units: int) -> tuple[str, ...]:
    """Return the columns of all gimbals, if a table has the angle of any."""
    return _GIMBAL_ANGLE[:units] if set(_GIMBAL_ANGLE) & set(names) else ()


def _name_problems(names: list[str], units: int) -> Iterator[str]:
    wanted = (_TIME, *_BODY_RATE, *_gimbal_columns(names, units))
    missing = [name for name in wanted if name not in names]
    if missing:
        yield f"has no column {', '.join(missing)}; its columns are {', '.join(names)}"
    too_many = [name for name in _GIMBAL_ANGLE[units:] if name in names]
    if too_many:
        yield f"has column {', '.join(too_many)}, but the platform has {units} units; leave it out"
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


def _spline(time: Series, columns: Mapping[str, Array], names: tuple[str, ...]) -> BSpline:
    return make_interp_spline(time, np.stack([columns[name] for name in names], axis=1), k=DEGREE)
