"""Many dispersed flights of one scenario, flown side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from testbed.assembly.dispersion import dispersed
from testbed.assembly.platform import PlatformModel, true_platform
from testbed.campaign.plan import Platforms, platforms_of
from testbed.errors import InputError
from testbed.experiment.flying import FlownRun, Sortie, fly_sorties
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class DispersedFlight:
    """One flight of a campaign.

    Attributes:
        seed: of its noise and its dispersions.
        scenario: as the seed dispersed it.
        truth: what flew; None where the dispersed numbers belong to no body.
        flown: record and figures; None where there was no platform to fly.
        message: why the flight failed; empty for a completed one.
    """

    seed: int
    scenario: Scenario
    truth: PlatformModel | None
    flown: FlownRun | None
    message: str


def fly_seeds(
    scenario: Scenario,
    maneuver: Maneuver,
    seeds: Sequence[int],
    threads: int = 1,
    platforms: Platforms | None = None,
) -> list[DispersedFlight]:
    """Fly a maneuver once per seed, side by side; a flight that fails does not stop the others.

    What a seed gives depends on the scenario and the seed alone, bit for bit.

    Args:
        scenario: with or without [dispersion].
        maneuver: the reference of all flights.
        seeds: one per flight.
        threads: that step the platforms.
        platforms: of the scenario; compiled where None.
    """
    nominal, truth = platforms_of(scenario) if platforms is None else platforms
    ready = [_prepared(dispersed(scenario, seed), truth, seed) for seed in seeds]
    sorties = [entry for entry in ready if isinstance(entry, Sortie)]
    flown = iter(fly_sorties(scenario, sorties, nominal, maneuver, threads, many=True) if sorties else [])
    return [_finished(entry, next(flown)) if isinstance(entry, Sortie) else entry for entry in ready]


def _prepared(drawn: Scenario, truth: PlatformModel | None, seed: int) -> Sortie | DispersedFlight:
    """Prepare a flight, or say why it cannot be flown."""
    try:
        return Sortie(scenario=drawn, truth=true_platform(drawn) if truth is None else truth, seed=seed)
    except InputError as error:
        return DispersedFlight(seed=seed, scenario=drawn, truth=None, flown=None, message=str(error))


def _finished(sortie: Sortie, flown: FlownRun) -> DispersedFlight:
    return DispersedFlight(
        seed=sortie.seed, scenario=sortie.scenario, truth=sortie.truth, flown=flown, message=flown.divergence
    )
