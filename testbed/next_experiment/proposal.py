"""What a diagnosis proposes to fly next, and how well that distinguishes the competing models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Flags
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.environment import Pivoted
from testbed.next_experiment.actuator_space import actuator_space
from testbed.next_experiment.body_rate_space import body_rate_space
from testbed.next_experiment.competing_hypotheses import hypothesis_pairs_of
from testbed.next_experiment.criterion import Choice, DiscriminationCriterion, criterion_of
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.search import chosen_flight
from testbed.next_experiment.space import FlightSpace
from testbed.scenario.scenario import Scenario

MOST_FLIGHTS = 5
"""Of one path that are proposed: the five situations of docs/separation.md take one to five; distances grow with the
root of their number, so that ten would reach only 1.4 times as far."""


@dataclass(frozen=True, kw_only=True)
class Separation:
    """Two models that the present data cannot distinguish; of both directions, the one with the smaller distance.

    Attributes:
        keys: effect and component that each has and the other has not, or `inertia`.
        now: their distance in the present data, sigma.
        after: with the proposed flight flown once and added, sigma.
        wanted: at which they are distinguished in 95 of 100 cases, sigma.
        separable: whether any flight of this platform brings them apart.
    """

    keys: tuple[str, str]
    now: float
    after: float
    wanted: float
    separable: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Proposal:
    """What to fly next.

    Attributes:
        flight: None where none would tell.
        times: how often it has to be flown to reach what is wanted of every separable pair, at most `MOST_FLIGHTS`.
        enough: whether that reaches it.
        separations: of every pair of indistinguishable models, the closest first.
    """

    flight: NextFlight | None
    times: int
    enough: bool
    separations: tuple[Separation, ...]


def proposal_of(
    diagnosis: Diagnosis, scenario: Scenario, progress: Callable[[str], None] = lambda _: None
) -> Proposal | None:
    """Return what to fly next; None where nothing is ambiguous.

    Args:
        diagnosis: complete, of records of gimbals, wheels or of what they add up to.
        scenario: the nominal one; its duration and its limits hold for the next flight.
        progress: called with what is being done.
    """
    hypotheses = hypothesis_pairs_of(diagnosis)
    if hypotheses is None:
        return None
    criterion = criterion_of(hypotheses, diagnosis.runs, flight_space(scenario))
    choice = chosen_flight(criterion, progress)
    if choice is None or not choice.separable.any():
        after = criterion.now if choice is None else choice.distances
        separations = _separations(criterion, after, np.zeros(len(after), dtype=bool))
        return Proposal(flight=None, times=0, enough=False, separations=separations)
    times, enough = _times(criterion, choice)
    separations = _separations(criterion, choice.distances, choice.separable)
    return Proposal(flight=choice.flight, times=times, enough=enough, separations=separations)


def flight_space(scenario: Scenario) -> FlightSpace:
    """Return the flights of a platform: on a pivot of the body rate, elsewhere of gimbals and wheels."""
    nominal = nominal_platform(scenario)
    if isinstance(nominal.environment, Pivoted):
        return body_rate_space(scenario, nominal)
    return actuator_space(scenario, nominal)


def _times(criterion: DiscriminationCriterion, choice: Choice) -> tuple[int, bool]:
    """Return how often to fly, and whether that is enough."""
    for times in range(1, MOST_FLIGHTS + 1):
        distances = criterion.distances([choice.flight], times)[0]
        if (distances >= criterion.wanted)[choice.separable].all():
            return times, True
    return MOST_FLIGHTS, False


def _separations(criterion: DiscriminationCriterion, after: Array, separable: Flags) -> tuple[Separation, ...]:
    """Return every two models once."""
    found: dict[frozenset[str], Separation] = {}
    margins = after / criterion.wanted
    for index in np.argsort(margins):
        pair = criterion.hypotheses.pairs[index]
        keys = criterion.hypotheses.keys(pair)
        separation = Separation(
            keys=keys,
            now=float(criterion.now[index]),
            after=float(after[index]),
            wanted=pair.wanted,
            separable=bool(separable[index]),
        )
        found.setdefault(frozenset(keys), separation)
    return tuple(found.values())
