"""The flights of the zero-g campaign, each cut where its own record shows the first contact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from testbed.assembly.contact import cut_at_contact
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.campaign.flights import DispersedFlight, fly_seeds
from testbed.campaign.plan import run_seed
from testbed.estimation.contact import Contact
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.records.selection import sampled, telemetry_only
from testbed.reproduction.zero_g_cuts import SHORTEST, Cut, cut_of
from testbed.scenario.scenario import Scenario

ROUNDS = 6
"""How often a campaign may fly again for the flights that were too short, before it makes do with those it has."""
SIDE_BY_SIDE = 25
"""Flights flown at once; what a flight gives does not depend on it."""
_JUMP = 1e-7
"""N·m·s; a change of the true momentum beyond it is a contact: 3e-3 of what the gyro's noise makes of one sample."""


@dataclass(frozen=True, kw_only=True)
class CutFlight:
    """A flight that is used, up to the first contact that its record shows.

    Attributes:
        seed: of its noise and of its release.
        record: what it sent, with the usable time in its details.
        telemetry: what the estimators are given of it.
        contact: as found in the record; None where none was.
        onset: when the true momentum first changed, s, from the simulation; for judging the cut only.
    """

    seed: int
    record: Record
    telemetry: Telemetry
    contact: Contact | None
    onset: float | None

    @property
    def usable(self) -> float:
        """Time from the release to the last sample used, s."""
        return float(self.telemetry.gyro_time[-1] - self.telemetry.gyro_time[0])


@dataclass(frozen=True, kw_only=True)
class FlownCampaign:
    """The flights of one campaign.

    Attributes:
        flights: those used, in the order flown.
        cuts: of all that were flown, those too short to be used as well.
    """

    flights: list[CutFlight] = field(default_factory=list)
    cuts: list[Cut] = field(default_factory=list)


def fly_campaigns(
    scenario: Scenario, maneuver: Maneuver, campaign_seeds: Sequence[int], flights: int
) -> list[FlownCampaign]:
    """Return the first usable flights of every campaign; what a seed gives depends on it alone, bit for bit.

    A campaign flies again for those that met the wall too soon.

    Args:
        scenario: with a cabin and dispersions.
        maneuver: what every flight tries to fly.
        campaign_seeds: one per campaign.
        flights: that each campaign uses.
    """
    nominal = nominal_platform(scenario)
    campaigns = [FlownCampaign() for _ in campaign_seeds]
    flown = [0] * len(campaigns)
    for _ in range(ROUNDS):
        wanted = [index for index, found in enumerate(campaigns) for _ in range(flights - len(found.flights))]
        seeds = [run_seed(campaign_seeds[index], run) for index, run in _runs(wanted, flown)]
        for index, flight in zip(wanted, _flights(scenario, maneuver, seeds), strict=True):
            flown[index] += 1
            _land(campaigns[index], flight, nominal)
    return campaigns


def _runs(wanted: Sequence[int], flown: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Give every flight wanted of a campaign the next number of a run in it."""
    following = list(flown)
    for index in wanted:
        yield index, following[index]
        following[index] += 1


def _flights(scenario: Scenario, maneuver: Maneuver, seeds: Sequence[int]) -> Iterator[DispersedFlight]:
    for first in range(0, len(seeds), SIDE_BY_SIDE):
        yield from fly_seeds(scenario, maneuver, seeds[first : first + SIDE_BY_SIDE])


def _land(campaign: FlownCampaign, flight: DispersedFlight, nominal: PlatformModel) -> None:
    """Cut a flight, judge the cut, and keep the flight if it is long enough; one that diverged is left out."""
    if flight.flown is None or flight.message:
        return
    flown = flight.flown.record
    details = replace(flown.details, usable_to=None)  # the simulation's own cut is not ours to know
    record, contact = cut_at_contact(replace(telemetry_only(flown), details=details), flight.scenario, nominal)
    onset = _onset(flown)
    cut = cut_of(sampled(record, "body_rate")[0], contact, onset)
    campaign.cuts.append(cut)
    if cut.usable >= SHORTEST:
        telemetry = telemetry_of(record, flight.scenario, nominal)
        campaign.flights.append(
            CutFlight(seed=flight.seed, record=record, telemetry=telemetry, contact=contact, onset=onset)
        )


def _onset(record: Record) -> float | None:
    """Return the first time at which the true momentum is no longer that of the release, s."""
    momentum_N = record.channels["true_total_momentum"]
    changed = np.flatnonzero(np.linalg.norm(momentum_N - momentum_N[0], axis=1) > _JUMP)
    return float(record.time[changed[0]]) if changed.size else None
