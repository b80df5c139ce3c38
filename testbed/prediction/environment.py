"""What acts on the platform from outside, in the prediction: as the scenario believes, along the predicted attitude."""

from __future__ import annotations

from functools import lru_cache
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.dynamics.environment import Orbiting, Pivoted, local_axes
from testbed.prediction.algebra import inertia_matrix
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, Instant
from testbed.prediction.kernels import cross, orbit_torques, turned_back

_OUTWARD_L = np.array([0.0, 0.0, 1.0])
"""The z axis of an orbit's local axes, away from the Earth."""
_ENVIRONMENTS = 8
"""That are kept: those of a nominal and a healthy model, and of platforms compared side by side; a miss costs time."""


@final
class PivotHooks(Hooks):
    """Gravity and drag on a pivot; its parameters are θ, about the centre of mass."""

    needs_attitude = True

    def __init__(self, pivot: Pivoted) -> None:
        """Take the pivot with the believed centre of mass."""
        self._pivot = pivot

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        pivot = self._pivot
        gravity_B = cross(up_B(at), np.broadcast_to(pivot.weight * pivot.offset_B, at.body_rate.shape))
        return gravity_B - pivot.drag * at.body_rate if pivot.drag else gravity_B

    @override
    def added_inertia(self, value: Array, grid: Grid) -> Array:
        return self._pivot.added_inertia


@final
class OrbitHooks(Hooks):
    """Gravity gradient, field and constant torque on orbit; its parameters are θ."""

    needs_attitude = True
    needs_rate = False

    def __init__(self, orbit: Orbiting) -> None:
        """Take the orbit with the believed dipole."""
        self._orbit = orbit
        gradient = 3.0 * orbit.rate**2 * orbit.gradient
        self._constants = np.concatenate([[gradient], orbit.dipole_B, orbit.field_L, orbit.torque_L])

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        orbit, runs = self._orbit, len(at.attitude)
        first_NB = np.broadcast_to(at.first_NB[:, 0], (runs, 3, 3))
        angle = np.broadcast_to(orbit.rate * at.time[:, 0], runs)
        return orbit_torques(first_NB, angle, at.attitude, inertia_matrix(value), self._constants)


def environment_hooks(grid: Grid) -> Hooks | None:
    """Return what acts on the runs from outside; None where nothing does."""
    surroundings = grid.runs[0].surroundings
    if surroundings is None:
        return None
    return _hooks_of(surroundings.environment)


@lru_cache(maxsize=_ENVIRONMENTS)  # by what acts a motion is known again that was found before
def _hooks_of(environment: Pivoted | Orbiting) -> Hooks:
    return PivotHooks(environment) if isinstance(environment, Pivoted) else OrbitHooks(environment)


def environment_kind(grid: Grid) -> str:
    """Return `environment.kind` of the runs; empty where they fly freely."""
    surroundings = grid.runs[0].surroundings
    if surroundings is None:
        return ""
    return "air_bearing" if isinstance(surroundings.environment, Pivoted) else "orbit"


def up_B(at: Instant) -> Array:
    """Return the z axis of N in body axes, shape (R, P, 3)."""
    return turned_back(at.first_NB[..., 2, :], at.attitude)


def orbit_of(at: Instant) -> Orbiting:
    """Return the orbit of a platform that is known to be on one."""
    assert at.surroundings is not None
    orbit = at.surroundings.environment
    assert isinstance(orbit, Orbiting)
    return orbit


def outward_in_body(orbit: Orbiting, at: Instant) -> Array:
    """Return the z axis of L, away from the Earth, in body axes, shape (R, P, 3)."""
    return _in_body(_OUTWARD_L, _local_in_run(orbit, at), at)


def field_in_body(orbit: Orbiting, at: Instant) -> Array:
    """Return the magnetic field in body axes, shape (R, P, 3), T."""
    return _in_body(orbit.field_L, _local_in_run(orbit, at), at)


def _local_in_run(orbit: Orbiting, at: Instant) -> Array:
    """Return R_RL, from the orbit's local axes to those of the run's first sample: one for all parameter sets."""
    return np.asarray(np.swapaxes(at.first_NB, -1, -2) @ local_axes(orbit, at.time))


def _in_body(vector_L: Array, local_R: Array, at: Instant) -> Array:
    """Return a vector that is fixed in the orbit's local axes in body axes, shape (R, P, 3)."""
    return turned_back(np.matvec(local_R, vector_L), at.attitude)
