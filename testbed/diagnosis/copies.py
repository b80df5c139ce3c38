"""Copies of a flight among records: they tell nothing new, and what is found in one would be verified on the other.

Of two flights the gyro's noise differs, whatever the maneuver. So a copy is found by its samples, also where it was
rounded, cut, or given another clock.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from hashlib import sha256

import numpy as np

from testbed.arrays import Array
from testbed.errors import InputError
from testbed.records.record import Record
from testbed.records.selection import sampled

_WINDOW = 24
"""Samples that are looked for in another flight.

Source: chosen: 72 numbers, which no other flight has alike by chance, in a quarter of a second at 100 Hz."""
_PLACES = (0.1, 0.5, 0.9)
"""Where in a flight they are taken, as shares of it.

Source: chosen: any piece of two fifths of a flight holds one of them."""
_LEAST = 0.2
"""Share of the shorter record that has to be the same: at rest a coarse gyro reads the same in any flight.

Source: chosen."""
_SAME = 0.1
"""Share of the noise by which samples of a copy differ at most: of different flights they differ by √2.

Source: chosen; rounding to a third of the noise makes a tenth of it."""
_ORDER = 3
"""Differences of this order show the noise and hardly the motion; of white noise they have 20 times its variance."""
_GAIN = 20.0
"""Variance of those differences of white noise over its own: 1² + 3² + 3² + 1². Source: formula."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Flights:
    """Flights so far."""

    _by_samples: dict[bytes, str] = field(default_factory=dict)
    _rates: dict[str, Array] = field(default_factory=dict)

    def add(self, record: Record) -> None:
        """Add a flight.

        Args:
            record: with a gyro.

        Raises:
            InputError: it is a copy of one that is there, or of a part of it.
        """
        name, rate = record.details.name, sampled(record, "body_rate")[1]
        other = self._by_samples.setdefault(_digest(record), name)
        if other == name:
            other = next((each for each, its in self._rates.items() if each != name and is_copy(rate, its)), name)
        if other != name:
            raise InputError(f"{name}: holds the samples of {other}: a copy is no further flight")
        self._rates[name] = rate


def is_copy(one: Array, other: Array) -> bool:
    """Return whether the gyro's samples of one record, or many of them in a row, are those of another.

    Args:
        one: of a record, shape (N, 3), rad/s; axes that were not read are NaN.
        other: of another one, shape (M, 3).
    """
    read = np.isfinite(one).all(axis=0) & np.isfinite(other).all(axis=0)
    one, other = one[:, read], other[:, read]
    return _holds_part_of(one, other) or _holds_part_of(other, one)


def _holds_part_of(whole: Array, part: Array) -> bool:
    if min(len(whole), len(part)) < _WINDOW or not whole.shape[1]:
        return False
    places = {int(share * (len(part) - _WINDOW)) for share in _PLACES}
    return any(_same_around(whole, part, place) for place in places)


def _same_around(whole: Array, part: Array, place: int) -> bool:
    """Return whether samples from a place on are found, and all around them are the same, by less than their noise."""
    window = part[place : place + _WINDOW]
    square = np.convolve((whole**2).sum(axis=1), np.ones(_WINDOW), "valid") + (window**2).sum()
    product = sum(np.correlate(axis, its, "valid") for axis, its in zip(whole.T, window.T, strict=True))
    start = int(np.argmin(square - 2.0 * product)) - place
    first, last = max(start, 0), min(start + len(part), len(whole))
    if last - first < _LEAST * min(len(whole), len(part)):
        return False
    both = part[first - start : last - start]
    noise = np.mean(np.diff(both, _ORDER, axis=0) ** 2) / _GAIN
    return bool(np.mean((whole[first:last] - both) ** 2) < _SAME**2 * noise)


def _digest(record: Record) -> bytes:
    samples = sha256()
    for name in sorted(record.channels):
        samples.update(name.encode() + record.channels[name].tobytes())
    return samples.digest()
