"""Where the units of the usual arrays of control moment gyros stand, and how their axes point.

Every array has gimbal axes g, spin axes s0 at gimbal angle zero, and places, in body axes; body z is the array's axis.
At gimbal angle zero no array holds momentum.

Source: Wie, Space Vehicle Dynamics and Control, ch. 7; Kurokawa, "A geometric study of single gimbal control moment
gyros", MEL report 175 (1998).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array, Axes

ArrayKind: TypeAlias = Literal["pyramid", "roof", "box", "line"]
BOX_SKEW = pi / 4.0
"""rad; the roof whose two gimbal axes are normal to each other is called a box."""
_ROWS = 2
_FAN = pi / 4.0
"""rad, of the spin axes of a row; with four units all torques about x and across it are then equally strong."""


@dataclass(frozen=True, kw_only=True)
class UnitPlaces:
    """Axes and places of units.

    Attributes:
        gimbal_axis_B: g, shape (M, 3), unit vectors, body axes.
        spin_axis_B: s0 at gimbal angle zero, shape (M, 3), body axes.
        direction_B: from the platform's centre to each unit, shape (M, 3), in units of the mounting radius.
    """

    gimbal_axis_B: Axes
    spin_axis_B: Axes
    direction_B: Axes


def azimuths(units: int) -> Array:
    """Return the azimuth of each unit of a pyramid, shape (M,), degrees: exact where 360 / M is."""
    return np.asarray(360.0 / units * np.arange(units), dtype=np.float64)


def unit_places(kind: ArrayKind, units: int, skew: float) -> UnitPlaces:
    """Return the units of an array.

    Args:
        kind: pyramid: gimbal axes on a cone about z, spin axes along its base; roof: two rows of parallel gimbal axes,
            tilted to either side of z; box: a roof whose axes are normal to each other; line: all axes along z.
        units: M; even for the arrays of two rows.
        skew: angle between body z and every gimbal axis, rad; of a pyramid or a roof.
    """
    return _ARRAYS[kind](units, skew)


def _pyramid(units: int, skew: float) -> UnitPlaces:
    azimuth = np.radians(azimuths(units))
    outward = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(units)], axis=1)
    upward = np.array([0.0, 0.0, 1.0])
    return UnitPlaces(
        gimbal_axis_B=sin(skew) * outward + cos(skew) * upward,
        spin_axis_B=np.cross(upward, outward),
        direction_B=outward,
    )


def _roof(units: int, skew: float) -> UnitPlaces:
    """Two rows along x, at y > 0 and y < 0.

    Spin axes fan out by 45 degrees to either side of x in the one row and of -x in the other: so the rows cancel, and
    torque can be given about every axis. Were each row to cancel by itself, the array would be singular.
    """
    row, place = np.divmod(np.arange(units), units // 2)
    side, none = 1.0 - 2.0 * row, np.zeros(units)
    gimbal = np.stack([none, side * sin(skew), np.full(units, cos(skew))], axis=1)
    ahead = side[:, None] * np.array([1.0, 0.0, 0.0])
    across = np.cross(gimbal, ahead)
    fan = np.linspace(-_FAN, _FAN, units // 2)[place, None] if units > _ROWS else none[:, None]
    along = fan[:, 0] / _FAN
    return UnitPlaces(
        gimbal_axis_B=gimbal,
        spin_axis_B=np.cos(fan) * ahead + np.sin(fan) * across,
        direction_B=np.stack([0.8 * along, 0.6 * side, none], axis=1),  # the corners lie at the mounting radius
    )


def _box(units: int, _: float) -> UnitPlaces:
    return _roof(units, BOX_SKEW)


def _line(units: int, _: float) -> UnitPlaces:
    """All along x, with parallel gimbal axes and spin axes all around them: no torque about z."""
    none, turned = np.zeros(units), np.radians(azimuths(units))
    return UnitPlaces(
        gimbal_axis_B=np.tile([0.0, 0.0, 1.0], (units, 1)),
        spin_axis_B=np.stack([np.cos(turned), np.sin(turned), none], axis=1),
        direction_B=np.stack([np.linspace(-1.0, 1.0, units), none, none], axis=1),
    )


_ARRAYS: Mapping[ArrayKind, Callable[[int, float], UnitPlaces]] = {
    "pyramid": _pyramid,
    "roof": _roof,
    "box": _box,
    "line": _line,
}
