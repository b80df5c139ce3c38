"""The next flight: the one from which the most is expected in the mean over an inertia 20 % off and failures of units.

The mean counts, as failures are rare; the least is stated with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.maneuver.maneuver import Maneuver
from testbed.next_experiment.actuator_space import ActuatorSpace
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.sampling import largest_flight, sampled_flights
from testbed.sequential.expected_gain import Goal
from testbed.sequential.forecasts import Forecasts
from testbed.sequential.robust import Case, RobustSpace

_SLACK = 1e-3
"""Share by which a scenario's own path is made smaller before it is compared with the limits, at which its design ends
to the accuracy of the optimiser."""
FINALISTS = 8
"""Flights, the best ones where all is as believed, that are compared in every case as well."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chosen:
    """The next flight.

    Attributes:
        flight: to fly.
        gain: what is expected of it where all is as believed: growth of the logarithm of the odds, or fall of that of
            the worst ratio of a standard deviation to the wanted one.
        worst: the least that is expected in any case.
        worst_case: which one that is, in words.
    """

    flight: NextFlight
    gain: float
    worst: float
    worst_case: str


def flights_to_choose_among(space: RobustSpace, own: Maneuver) -> list[NextFlight]:
    """Return drawn flights, and the scenario's own path and its mirror image from every release.

    Each is as large as all limits let it be.

    Args:
        space: platform and limits.
        own: maneuver of the scenario, as designed for its criterion; only paths of gimbals are tried from releases.
    """
    flights = sampled_flights(space)
    points = None if own.gimbal_angle is None else own.gimbal_angle.c
    if isinstance(space.nominal, ActuatorSpace) and points is not None and points.shape[1] == len(space.nominal.scale):
        path = (1.0 - _SLACK) * (points[2:-1] - points[0]) / space.nominal.scale
        both = product(space.releases(), (path, -path))
        flights += [flight for release, each in both for flight in largest_flight(space, release, each)]
    return flights


def chosen_flight(
    goal: Goal,
    runs: Runs,
    forecasts: Forecasts,
    flights: Sequence[NextFlight],
    progress: Callable[[str], None] = lambda _: None,
    refinement: Callable[[NextFlight], NextFlight] | None = None,
) -> Chosen | None:
    """Return the flight with the largest gain in the mean over all cases; None where there are none.

    The best of the given ones is refined, and the refined one taken where it is better in that mean.

    Args:
        goal: what it is chosen for.
        runs: the flights so far, whose channels and noise it will have.
        forecasts: of the campaign.
        flights: to choose among.
        progress: called with what is being done.
        refinement: makes a flight better; None where there is none for this goal.
    """
    if not flights:
        return None
    progress("what each flight would show")
    expected = _gains(goal, runs, forecasts, flights, Case())
    finalists = [flights[index] for index in np.argsort(-expected, kind="stable")[:FINALISTS]]
    progress("what the best flights would show in the worst cases")
    by_case = _gains_by_case(goal, runs, forecasts, finalists)
    most = int(by_case.mean(axis=0).argmax())
    if refinement is not None:
        finalists.append(refinement(finalists[most]))
        by_case = np.hstack([by_case, _gains_by_case(goal, runs, forecasts, finalists[-1:])])
        most = int(by_case.mean(axis=0).argmax())
    return Chosen(
        flight=finalists[most],
        gain=float(by_case[0, most]),
        worst=float(by_case[:, most].min()),
        worst_case=forecasts.space.cases[int(by_case[:, most].argmin())].text,
    )


def _gains_by_case(goal: Goal, runs: Runs, forecasts: Forecasts, flights: Sequence[NextFlight]) -> Array:
    """Return what is expected of flights in every case, shape (cases, F)."""
    return np.stack([_gains(goal, runs, forecasts, flights, case) for case in forecasts.space.cases])


def _gains(goal: Goal, runs: Runs, forecasts: Forecasts, flights: Sequence[NextFlight], case: Case) -> Array:
    """Return what is expected of flights in a case, shape (F,)."""
    return goal.gains(forecasts.information(goal.model, runs, flights, case))


def most_gained(goal: Goal, runs: Runs, forecasts: Forecasts, flights: Sequence[NextFlight]) -> float:
    """Return the largest gain of any flight where all is as believed; zero where there are none."""
    return float(_gains(goal, runs, forecasts, flights, Case()).max(initial=0.0)) if flights else 0.0
