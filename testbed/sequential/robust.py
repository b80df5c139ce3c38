"""Flights that keep the limits whatever the inertia is within 20 %, and whichever unit fails.

Limits hold in every case: a flight is drawn and scaled down until it keeps those of all of them. With a failed unit the
flight is flown as it was planned, less that unit: its rotor holds no momentum and its gimbal stays at zero, while the
others follow their own paths. A failure is what reserves are for, so that there the limits themselves hold.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from testbed.arrays import Array, Flags
from testbed.assembly.platform import PlatformModel
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.next_experiment.actuator_space import ActuatorSpace
from testbed.next_experiment.flight import NextFlight, Release
from testbed.next_experiment.proposal import flight_space
from testbed.next_experiment.space import FlightSpace
from testbed.scenario.scenario import Scenario

INERTIA_FACTORS = (1.0, 0.8, 1.2)
"""Times the estimated inertia. Source: the 20 % by which a campaign is to be robust."""
FAILED_ENVELOPE = 1.0
"""Share of the momentum envelope that a flight may use with a failed unit: all of it."""
FAILED_MEASURE = 0.5
"""Share of the smallest singularity measure of a design that remains with a failed unit. Source: chosen; without a
unit the measure of six at zero falls from 0.5 to 0.42, that along the design of zero_g.toml to 0.19 to 0.31."""


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

    def flown_in(self, case: Case, flight: NextFlight) -> NextFlight:
        """Return a flight as it is flown in a case: without the failed unit, the others on their own paths."""
        if case.failed is None:
            return flight
        points = case.points(flight.control_points)[None]
        return self.of(case).flights(case.released(flight.release), points)[0]

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
