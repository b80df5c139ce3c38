"""The flights of the zero-g campaign, each cut where its own record shows the first contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbed.assembly.contact import cut_at_contact
from testbed.assembly.estimation import telemetry_of
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.campaign.flights import DispersedFlight, fly_seeds
from testbed.campaign.plan import run_seed
from testbed.estimation.contact import Contact
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.records.selection import telemetry_only
from testbed.scenario.scenario import Scenario

SHORTEST = 2.0
"""s; a flight with less before its first contact is not used. Source: paper section 5.2."""
ROUNDS = 6
"""How often a campaign may fly again for the flights that were too short, before it makes do with those it has."""
SIDE_BY_SIDE = 25
"""Flights flown at once; what a flight gives does not depend on it."""
_JUMP = 1e-7
"""N·m·s; a change of the true momentum beyond it is a contact: 3e-3 of what the gyro's noise makes of one sample."""


@dataclass(frozen=True, kw_only=True)
class CutFlight:
    """A flight that has landed.

    Attributes:
        seed: of its noise and of its release.
        record: what it sent, usable to the first contact found in it.
        whole: what the estimators would be given without the cut.
        telemetry: what they are given.
        contact: as found in the record; None where none was.
        onset: when the true momentum first changed, s, from the simulation; for judging the cut only.
    """

    seed: int
    record: Record
    whole: Telemetry
    telemetry: Telemetry
    contact: Contact | None
    onset: float | None

    @property
    def usable(self) -> float:
        """Time from the release to the last sample used, s."""
        return float(self.telemetry.gyro_time[-1] - self.telemetry.gyro_time[0])


def fly_campaigns(
    scenario: Scenario, maneuver: Maneuver, campaign_seeds: Sequence[int], flights: int
) -> list[list[CutFlight]]:
    """Return the first usable flights of every campaign; what a seed gives depends on it alone, bit for bit.

    A campaign flies again for those that met the wall too soon.

    Args:
        scenario: with a cabin and dispersions.
        maneuver: what every flight tries to fly.
        campaign_seeds: one per campaign.
        flights: that each campaign uses.
    """
    used: list[list[CutFlight]] = [[] for _ in campaign_seeds]
    flown = [0] * len(used)
    for _ in range(ROUNDS):
        wanted = [
            (index, flown[index] + extra) for index, found in enumerate(used) for extra in range(flights - len(found))
        ]
        landed = cut_flights(scenario, maneuver, [run_seed(campaign_seeds[index], run) for index, run in wanted])
        for (index, _), flight in zip(wanted, landed, strict=True):
            flown[index] += 1
            if flight is not None and flight.usable >= SHORTEST:
                used[index].append(flight)
    return used


def cut_flights(scenario: Scenario, maneuver: Maneuver, seeds: Sequence[int]) -> list[CutFlight | None]:
    """Fly once per seed and cut every record; None for a flight that diverged."""
    nominal = nominal_platform(scenario)
    blocks = [seeds[first : first + SIDE_BY_SIDE] for first in range(0, len(seeds), SIDE_BY_SIDE)]
    return [_cut(flight, nominal) for block in blocks for flight in fly_seeds(scenario, maneuver, block)]


def _cut(flight: DispersedFlight, nominal: PlatformModel) -> CutFlight | None:
    if flight.flown is None or flight.message:
        return None
    flown = flight.flown.record
    record = replace(
        telemetry_only(flown), details=replace(flown.details, usable_to=None)
    )  # the truth's cut is not ours
    cut, contact = cut_at_contact(record, flight.scenario, nominal)
    whole = telemetry_of(record, flight.scenario, nominal)
    return CutFlight(
        seed=flight.seed,
        record=cut,
        whole=whole,
        telemetry=whole if contact is None else telemetry_of(cut, flight.scenario, nominal),
        contact=contact,
        onset=_onset(flown),
    )


def _onset(record: Record) -> float | None:
    """Return the first time at which the true momentum is no longer that of the release, s."""
    momentum_N = record.channels["true_total_momentum"]
    changed = np.flatnonzero(np.linalg.norm(momentum_N - momentum_N[0], axis=1) > _JUMP)
    return float(record.time[changed[0]]) if changed.size else None
