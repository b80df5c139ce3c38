"""A size and a direction as one vector: linear from nothing on, where a size and two angles would not be."""

from __future__ import annotations

from math import inf

import numpy as np

from testbed.arrays import Array
from testbed.effects.contract import Parameter
from testbed.prediction.algebra import dot
from testbed.prediction.grid import Grid

SPECK = 1e-9
"""Share of the typical size at which a search starts: no motion shows it, but it has a direction."""
_SLOWEST = 0.02
"""Hz, that hardware shows. Source: chosen, well below the 0.05 Hz and more of large solar arrays."""
MOST_DAMPED = 0.5
"""Damping ratio; beyond it a mode does not swing, and passes for drag."""
_RATIO = 1.2
"""Between frequencies that are looked at: halfway between two, at least 60 % of the χ² of a mode damped by 0.1 remain
(5 % with the seven frequencies before); with 1.4 a lightly damped appendage of eight detectable sizes was taken for
slosh."""


_SWINGS = 18.0
"""In the longest run, from which on a mode may be slower than what is scanned in any case: panels of large spacecraft
swing in 10 s and more, and records of minutes show it. Source: chosen, so that nothing changes up to a minute."""
_SEARCHED = 12.0
"""Swings in the longest run down to which a search may come. Source: chosen, two steps slower than what is looked at,
and 0.2 Hz in a minute, where searches have always ended."""


def slowest_mode(longest: float) -> float:
    """Return the frequency to which searches go in runs of which the longest lasts so many seconds, Hz."""
    return _SEARCHED / longest if longest > 0.0 else inf


def mode_parameters(frequency: float, bounds: tuple[float, float], damping_ratio: float) -> tuple[Parameter, ...]:
    """Return the parameters of a damped mode, which are scanned.

    Args:
        frequency: a typical one, Hz.
        bounds: of the frequency, Hz.
        damping_ratio: a typical one.
    """
    return (
        Parameter(
            name="frequency_hz",
            unit="Hz",
            typical=frequency,
            lower=bounds[0],
            upper=bounds[1],
            absent=frequency,
            scanned=True,
            plausible=(_SLOWEST, bounds[1]),
        ),
        Parameter(
            name="damping_ratio",
            unit="1",
            typical=damping_ratio,
            lower=0.0,
            upper=MOST_DAMPED,
            absent=damping_ratio,
            scanned=True,
            plausible=(0.0, MOST_DAMPED),
        ),
    )


def size_and_direction(vector: Array) -> tuple[Array, Array]:
    """Return |v|, shape (..., 1), and the unit vector, shape (..., 3), analytic in v; both zero where v is.

    Args:
        vector: v, shape (..., 3).
    """
    square = dot(vector, vector)
    none = square.real == 0.0
    size = np.sqrt(np.where(none, 1.0, square))
    return np.where(none, 0.0, size), np.asarray(vector / size)


def size_std(direction: Array, std: Array) -> float:
    """Return the standard error of |v| by those of its components, shape (3,); infinite of those that no sample shows.

    Across its direction it is as large with any of them.
    """
    along = np.where(direction == 0.0, 0.0, std)
    return float(np.linalg.norm(direction * along))


def scanned(grid: Grid, lowest: float, highest: float, damping_ratio: float, typical: float) -> Array:
    """Return starts (frequency, damping ratio, v) from frequency to frequency, a speck along each axis, shape (S, 5).

    A mode that does not turn over once in the longest run passes for drag or for a tether, and is not looked for; nor
    one faster than the gyro samples, of which nothing but its inertia shows. In long runs slower ones are looked for.

    Args:
        grid: the runs.
        lowest: frequency, Hz.
        highest: Hz.
        damping_ratio: at which all of them are looked at; it sets how far from its frequency a mode still shows.
        typical: size of v.
    """
    longest = float(np.ptp(grid.time, axis=1).max())
    lowest = max(min(lowest, _SWINGS / longest), 1.0 / longest)
    highest = min(highest, 1.0 / float(grid.gyro_interval.min()))
    if lowest > highest:
        return np.zeros((0, 5))
    count = 1 + round(np.log(highest / lowest) / np.log(_RATIO))
    specks = SPECK * typical * np.eye(3)
    frequencies = np.geomspace(lowest, highest, count)
    return np.array([[frequency, damping_ratio, *speck] for frequency in frequencies for speck in specks])


def beyond_speck(start: Array, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return bounds within which v does not turn round against its speck: that would be a negative mass or inertia.

    Args:
        start: (frequency, damping ratio, v), shape (5,).
        bounds: of all parameters, each of shape (5,).
    """
    lower, upper = bounds
    speck = np.concatenate([[False, False], start[2:] != 0.0])
    return np.where(speck, np.maximum(lower, 0.0), lower), upper
