"""How well records are cut, judged by the simulation's truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Series
from testbed.estimation.contact import Contact

SHORTEST = 2.0
"""s; a flight with less before its first contact is not used. Source: paper section 5.2."""


@dataclass(frozen=True, kw_only=True)
class Cut:
    """One flight's cut beside the truth.

    Attributes:
        usable: time from the release to the last sample before the contact found, s.
        late: samples left after the contact began; negative: free samples given away.
        touched: whether the flight met the wall.
    """

    usable: float
    late: int
    touched: bool


@dataclass(frozen=True, kw_only=True)
class CutScore:
    """The cuts of many flights.

    Attributes:
        flights: how many.
        touched: those that met the wall.
        too_short: those that were not used.
        missed: cut more than one sample too late, or not at all.
        one_late: cut one sample too late.
        one_early: one free sample given away.
        false_alarms: more than one free sample given away.
    """

    flights: int
    touched: int
    too_short: int
    missed: int
    one_late: int
    one_early: int
    false_alarms: int


def cut_of(gyro_time: Series, contact: Contact | None, onset: float | None) -> Cut:
    """Judge a cut.

    Args:
        gyro_time: of the whole record, shape (N,), s.
        contact: as found in it; None where none was.
        onset: when the true momentum first changed, s; None where it never did.
    """
    last = gyro_time[-1] if contact is None else contact.last_free
    used = int(np.searchsorted(gyro_time, last, side="right"))
    free = len(gyro_time) if onset is None else int(np.searchsorted(gyro_time, onset))
    return Cut(usable=float(last - gyro_time[0]), late=used - free, touched=onset is not None)


def cut_score(cuts: Sequence[Cut]) -> CutScore:
    """Count the cuts of many flights by what is wrong with them."""
    late = np.array([cut.late for cut in cuts])
    return CutScore(
        flights=len(cuts),
        touched=sum(cut.touched for cut in cuts),
        too_short=sum(cut.usable < SHORTEST for cut in cuts),
        missed=int((late > 1).sum()),
        one_late=int((late == 1).sum()),
        one_early=int((late == -1).sum()),
        false_alarms=int((late < -1).sum()),
    )
