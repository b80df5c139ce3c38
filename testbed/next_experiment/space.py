"""The flights among which the next one is chosen: what a platform can be released with and fly, and its limits.

Where the total momentum is conserved, flights are paths of all gimbals and wheels, from which the motion follows; on a
pivot, where gravity changes it, they are paths of the body rate, which gimbals and wheels follow. A path is given by
its moves: control points less the first one, in units of which about one is as far as a path goes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Flags
from testbed.assembly.maneuver import profile_of
from testbed.assembly.platform import PlatformModel
from testbed.cmg.singularity import sphere_directions
from testbed.next_experiment.flight import NextFlight, Release
from testbed.scenario.maneuver import ActuatorDesign, CsvManeuver, GimbalDesign
from testbed.scenario.scenario import Scenario
from testbed.signals import AXES

CONTROL_POINTS = 24
"""Of a flight's spline: 1.9 Hz at most in 5 s, above which the acceleration limit leaves no momentum to see."""
RELEASE_SPIN = 0.3
"""rad/s, of a platform that its actuators can turn as fast. It doubles several distances by itself, and makes a gyro's
scale visible."""
_SPIN_SHARE = 2.0 / 3.0
"""Share of the momentum envelope that a spin takes at most, about the axis where it takes least.

Nobody releases a large satellite at 0.3 rad/s, and on orbit it gives itself the spin; a third is left to the path.

Source: chosen; all shipped platforms but those that keep their momentum on orbit can turn at 0.3 rad/s with it."""
SPHERE = sphere_directions(100)
"""Unit vectors on which the momentum envelope is taken, 0.35 rad apart: of 4,000 random angles the envelope's share is
up to 0.02 less than with 5,000 vectors, for which the share of a design has room."""
BIAS = 0.4
"""rad, and share of a wheel's momentum limit: of the actuators that hold a momentum bias, 0.01 N·m·s along z on the
nominal platform."""
FARTHEST = 1.5
"""rad from the first angles; the limits make it less."""
TURNS = (2, 4, 8, 16)
"""Random angles that a path goes through: slow paths go far, fast ones accelerate."""
_USUAL_SHARE = 0.8
"""Of envelope and gimbal rate, left to a path where the scenario designs none: those of the shipped
diagnose.toml and zero_g.toml; the rest is for what the nominal model gets wrong."""
_USUAL_ACCELERATION = 10.0
"""rad/s² of a gimbal, as in the same designs: with it, gimbal_d_optimal.toml saturates in none of 250 seeds."""
_USUAL_MEASURE = 0.3
"""Singularity measure at least, as in the same designs: below, gimbal rates grow faster than the torque that they
give."""
_GYRO_RATE = 16.0
"""Hz: the gyro of the paper. Only the designer's criterion would use it, which is not asked for here."""
_PREFILTER = 0.8
"""s: the prefilter of the paper, likewise of the designer's criterion alone."""


class FlightSpace(Protocol):
    """Flights of one duration."""

    @property
    def platform(self) -> PlatformModel:
        """The nominal one."""
        ...

    @property
    def free(self) -> Flags:
        """Which columns of a path may move, shape (K,): not those of failed units."""
        ...

    def releases(self) -> Iterator[Release]:
        """Yield how the platform can be let go."""
        ...

    def paths(self, rng: np.random.Generator) -> list[Array]:
        """Return random moves, each of shape (m, K)."""
        ...

    def points(self, release: Release, moves: Array) -> Array:
        """Return the control points of moves of shape (..., m, K), shape (..., n, K)."""
        ...

    def moves(self, flight: NextFlight) -> Array:
        """Return the moves of a flight, shape (m, K)."""
        ...

    def shares(self, release: Release, points: Array) -> Array:
        """Return shares of limits, each at most 1 where a path keeps them, shape (F, L).

        Args:
            release: of all paths.
            points: their control points, shape (F, n, K).
        """
        ...

    def flights(self, release: Release, points: Array) -> Sequence[NextFlight]:
        """Return the flights of paths; arguments as of `shares`."""
        ...


def release_spin(platform: PlatformModel) -> float:
    """Return the rate of a release with a spin, rad/s: no faster than the actuators turn a platform about some axis."""
    shares = platform.envelope_share(RELEASE_SPIN * platform.inertia, SPHERE)
    return RELEASE_SPIN * min(1.0, _SPIN_SHARE / float(shares.min()))


def path_through(angles: Array, inner: int, derivative: int = 0) -> Array:
    """Return a path from zero through given angles at equal intervals of one unit of time, shape (inner, K).

    It leaves and arrives slowly: a jump at either end would take the whole of the acceleration limit.

    Args:
        angles: shape (turns, K).
        inner: number of instants between both ends.
        derivative: of the path that is returned.
    """
    through = np.concatenate([np.zeros((1, angles.shape[1])), angles])
    spline = CubicSpline(np.linspace(0.0, 1.0, len(through)), through, bc_type="clamped")
    return np.asarray(spline(np.linspace(0.0, 1.0, inner + 2)[1:-1], derivative))


def flight_duration(scenario: Scenario) -> float:
    """Return how long a flight of the scenario lasts, s."""
    if scenario.simulation.duration_s is not None:
        return scenario.simulation.duration_s
    own = scenario.maneuver
    return profile_of(own, scenario).duration if isinstance(own, CsvManeuver) else own.duration_s


def motion_section(scenario: Scenario) -> GimbalDesign | ActuatorDesign:
    """Return the scenario's own design of gimbals and wheels, or the usual one, as of the shipped scenarios.

    Wheels that span all directions give torque where gimbals cannot: beside them no singularity counts.
    """
    own = scenario.maneuver
    if isinstance(own, GimbalDesign | ActuatorDesign):
        return own
    usual: dict[str, Any] = {
        "kind": "design",
        "criterion": "D",
        "duration_s": flight_duration(scenario),
        "control_points": CONTROL_POINTS,
        "starts": 1,
        "seed": 1,
        "sample_rate_hz": _GYRO_RATE,
        "prefilter_time_constant_s": _PREFILTER,
        "envelope_fraction": _USUAL_SHARE,
        "gimbal_rate_fraction": _USUAL_SHARE,
        "gimbal_acceleration_limit_rad_s2": _USUAL_ACCELERATION,
    }
    if not scenario.wheels:
        return GimbalDesign(**usual, parametrization="gimbal", min_singularity_measure=_USUAL_MEASURE)
    spanned = np.linalg.matrix_rank(np.concatenate([each.axes_B for each in scenario.wheels]))
    floor = 0.0 if spanned == len(AXES) else _USUAL_MEASURE
    return ActuatorDesign(**usual, parametrization="actuator", min_singularity_measure=floor)
