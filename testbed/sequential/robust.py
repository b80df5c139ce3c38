"""The next flight: the one from which the most is expected in the mean over an inertia 20 % off and failures of units.

Limits hold in every case: a flight is drawn and scaled down until it keeps those of all of them. With a failed unit the
flight is flown as it was planned, less that unit: its rotor holds no momentum and its gimbal stays at zero, while the
others follow their own paths. A failure is what reserves are for, so that there the limits themselves hold.

The mean counts, as failures are rare; the least is stated with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import final

import numpy as np

from testbed.arrays import Array, Flags
from testbed.assembly.platform import PlatformModel
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, parameters_of_runs
from testbed.maneuver.maneuver import Maneuver
from testbed.next_experiment.actuator_space import ActuatorSpace
from testbed.next_experiment.flight import NextFlight, Release
from testbed.next_experiment.forecast import blank_runs, forecast_columns
from testbed.next_experiment.proposal import flight_space
from testbed.next_experiment.sampling import largest_flight, sampled_flights
from testbed.next_experiment.space import FlightSpace
from testbed.scenario.scenario import Scenario
from testbed.sequential.expected_gain import Goal, information_of

INERTIA_FACTORS = (1.0, 0.8, 1.2)
"""Times the estimated inertia. Source: the 20 % by which a campaign is to be robust."""
FAILED_ENVELOPE = 1.0
"""Share of the momentum envelope that a flight may use with a failed unit: all of it."""
FAILED_MEASURE = 0.5
"""Share of the smallest singularity measure of a design that remains with a failed unit. Source: chosen; without a
unit the measure of six at zero falls from 0.5 to 0.42, that along the design of zero_g.toml to 0.19 to 0.31."""
_SLACK = 1e-3
"""Share by which a scenario's own path is made smaller before it is compared with the limits, at which its design ends
to the accuracy of the optimiser."""
FINALISTS = 8
"""Flights, the best ones where all is as believed, that are compared in every case as well."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """What may be otherwise than believed.

    Attributes:
        inertia_factor: times the inertia.
        failed: index of the unit without momentum; None where all work.
    """

    inertia_factor: float = 1.0
    failed: int | None = None

    @property
    def text(self) -> str:
        """In words."""
        if self.failed is not None:
            return f"unit {self.failed + 1} failed"
        return "as believed" if self.inertia_factor == 1.0 else f"inertia times {self.inertia_factor:g}"

    def platform(self, nominal: PlatformModel) -> PlatformModel:
        """Return the platform in this case."""
        cluster = nominal.cluster
        if self.failed is not None:
            works = np.arange(len(cluster.rotor_momentum)) != self.failed
            cluster = replace(cluster, rotor_momentum=cluster.rotor_momentum * works)
        return replace(nominal, inertia=self.inertia_factor * nominal.inertia, cluster=cluster)

    def points(self, points: Array) -> Array:
        """Return control points of gimbals and wheels, shape (..., n, M + W), the failed unit's gimbal at zero."""
        if self.failed is None:
            return points
        points = points.copy()
        points[..., self.failed] = 0.0
        return points

    def released(self, release: Release) -> Release:
        """Return a release likewise."""
        return release._replace(motion=self.points(release.motion[None])[0])

    def runs(self, runs: Runs) -> Runs:
        """Return runs whose units are as here, like which flights are forecast."""
        first = runs.grid.runs[0]
        if self.failed is None or first.gimbals is None:
            return runs
        works = np.arange(len(first.gimbals.cluster.rotor_momentum)) != self.failed
        cluster = replace(first.gimbals.cluster, rotor_momentum=first.gimbals.cluster.rotor_momentum * works)
        gimbals = replace(first.gimbals, cluster=cluster)
        grid = replace(runs.grid, runs=(replace(first, gimbals=gimbals), *runs.grid.runs[1:]))
        return replace(runs, grid=grid)

    def model(self, model: Fit) -> Fit:
        """Return a model whose inertia is as here."""
        return replace(model, values=replace(model.values, theta=self.inertia_factor * model.values.theta))


def cases_of(space: FlightSpace) -> tuple[Case, ...]:
    """Return all cases: those of the inertia, and the failure of each unit that works, where paths are of gimbals."""
    inertias = tuple(Case(inertia_factor=factor) for factor in INERTIA_FACTORS)
    if not isinstance(space, ActuatorSpace):
        return inertias
    works = np.flatnonzero(space.platform.cluster.rotor_momentum)
    return (*inertias, *(Case(failed=int(unit)) for unit in works if len(works) > len(np.eye(3))))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RobustSpace:
    """Flights that keep the limits in every case.

    Attributes:
        nominal: the flights of the platform as believed.
        cases: in which limits hold.
    """

    nominal: FlightSpace
    cases: tuple[Case, ...]

    @property
    def platform(self) -> PlatformModel:
        """As believed."""
        return self.nominal.platform

    @property
    def free(self) -> Flags:
        """As believed."""
        return self.nominal.free

    def releases(self) -> Iterator[Release]:
        """Yield how the platform can be let go."""
        return self.nominal.releases()

    def paths(self, rng: np.random.Generator) -> list[Array]:
        """Return random moves."""
        return self.nominal.paths(rng)

    def points(self, release: Release, moves: Array) -> Array:
        """Return the control points of moves."""
        return self.nominal.points(release, moves)

    def moves(self, flight: NextFlight) -> Array:
        """Return the moves of a flight."""
        return self.nominal.moves(flight)

    def shares(self, release: Release, points: Array) -> Array:
        """Return shares of limits in all cases, side by side."""
        parts = [
            self.of(case).shares(case.released(release), case.points(points))
            if case.failed is not None
            else self.of(case).shares(release, points)
            for case in self.cases
        ]
        return np.concatenate(parts, axis=1)

    def flights(self, release: Release, points: Array) -> Sequence[NextFlight]:
        """Return the flights of paths."""
        return self.nominal.flights(release, points)

    def of(self, case: Case) -> FlightSpace:
        """Return the flights of the platform in a case."""
        platform = case.platform(self.nominal.platform)
        if not isinstance(self.nominal, ActuatorSpace) or case.failed is None:
            return replace(self.nominal, platform=platform)  # type: ignore[type-var]
        floor = FAILED_MEASURE * self.nominal.limits.min_singularity_measure
        limits = replace(self.nominal.limits, envelope_fraction=FAILED_ENVELOPE, min_singularity_measure=floor)
        return replace(self.nominal, platform=platform, limits=limits)


def robust_space(scenario: Scenario) -> RobustSpace:
    """Return flights that keep the limits of a platform in every case."""
    nominal = flight_space(scenario)
    return RobustSpace(nominal=nominal, cases=cases_of(nominal))


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
    space: RobustSpace,
    flights: Sequence[NextFlight],
    progress: Callable[[str], None] = lambda _: None,
    refinement: Callable[[NextFlight], NextFlight] | None = None,
) -> Chosen | None:
    """Return the flight with the largest gain in the mean over all cases; None where there are none.

    The best of the given ones is refined, and the refined one taken where it is better in that mean.

    Args:
        goal: what it is chosen for.
        runs: the flights so far, whose channels and noise it will have.
        space: platform and limits.
        flights: to choose among.
        progress: called with what is being done.
        refinement: makes a flight better; None where there is none for this goal.
    """
    if not flights:
        return None
    progress("what each flight would show")
    expected = _gains(goal, runs, space, flights, Case())
    finalists = [flights[index] for index in np.argsort(-expected, kind="stable")[:FINALISTS]]
    progress("what the best flights would show in the worst cases")
    by_case = _gains_by_case(goal, runs, space, finalists)
    most = int(by_case.mean(axis=0).argmax())
    if refinement is not None:
        finalists.append(refinement(finalists[most]))
        by_case = np.hstack([by_case, _gains_by_case(goal, runs, space, finalists[-1:])])
        most = int(by_case.mean(axis=0).argmax())
    return Chosen(
        flight=finalists[most],
        gain=float(by_case[0, most]),
        worst=float(by_case[:, most].min()),
        worst_case=space.cases[int(by_case[:, most].argmin())].text,
    )


def _gains_by_case(goal: Goal, runs: Runs, space: RobustSpace, flights: Sequence[NextFlight]) -> Array:
    """Return what is expected of flights in every case, shape (cases, F)."""
    return np.stack([_gains(goal, runs, space, flights, case) for case in space.cases])


def _gains(goal: Goal, runs: Runs, space: RobustSpace, flights: Sequence[NextFlight], case: Case) -> Array:
    """Return what is expected of flights in a case, shape (F,)."""
    if case.failed is not None:
        flights = [
            space.of(case).flights(case.released(each.release), case.points(each.control_points)[None])[0]
            for each in flights
        ]
    blank = blank_runs(flights, case.runs(runs), case.platform(space.platform))
    columns = forecast_columns(case.model(goal.model), flights, blank)
    common = goal.model.jacobian.shape[1] - parameters_of_runs(runs)
    return goal.gains(information_of(columns, common))


def most_gained(goal: Goal, runs: Runs, space: RobustSpace, flights: Sequence[NextFlight]) -> float:
    """Return the largest gain of any flight where all is as believed; zero where there are none."""
    return float(_gains(goal, runs, space, flights, Case()).max(initial=0.0)) if flights else 0.0
