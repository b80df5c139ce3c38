"""How well records are cut, judged by the simulation's truth, and what a cut that comes too late does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbed.reproduction.zero_g_flights import CutFlight


@dataclass(frozen=True, kw_only=True)
class Cut:
    """One flight's cut beside the truth.

    Attributes:
        late: samples used after the contact began; negative: free samples given away.
        touched: whether the flight met the wall.
    """

    late: int
    touched: bool


@dataclass(frozen=True, kw_only=True)
class CutScore:
    """The cuts of many flights.

    Attributes:
        flights: how many.
        touched: those that met the wall.
        missed: cut more than one sample too late, or not at all.
        one_late: cut one sample too late.
        one_early: one free sample given away.
        false_alarms: more than one free sample given away.
    """

    flights: int
    touched: int
    missed: int
    one_late: int
    one_early: int
    false_alarms: int


def cut_of(flight: CutFlight) -> Cut:
    """Judge a flight's cut by the simulation's truth."""
    return Cut(late=len(flight.telemetry.gyro_time) - _free_samples(flight), touched=flight.onset is not None)


def cut_score(cuts: Sequence[Cut]) -> CutScore:
    """Count the cuts of many flights by what is wrong with them."""
    late = np.array([cut.late for cut in cuts])
    return CutScore(
        flights=len(cuts),
        touched=sum(cut.touched for cut in cuts),
        missed=int((late > 1).sum()),
        one_late=int((late == 1).sum()),
        one_early=int((late == -1).sum()),
        false_alarms=int((late < -1).sum()),
    )


def cut_late(flight: CutFlight, samples: int) -> CutFlight:
    """Return the flight as if its cut had come so many samples after the contact began."""
    used = _free_samples(flight) + samples
    whole = flight.whole
    return replace(flight, telemetry=replace(whole, gyro_time=whole.gyro_time[:used], body_rate=whole.body_rate[:used]))


def _free_samples(flight: CutFlight) -> int:
    """Return how many gyro samples the flight has before its momentum first changes."""
    time = flight.whole.gyro_time
    return len(time) if flight.onset is None else int(np.searchsorted(time, flight.onset))
