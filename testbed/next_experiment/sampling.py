"""Flights to choose among: releases at rest, with a spin or with a momentum bias, and random paths of the gimbals."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Units
from testbed.cmg.cluster import Cluster, momentum_jacobian
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.limits import CONTROL_POINTS, DesignLimits, limit_shares

RELEASE_SPIN = 0.3
"""rad/s. It doubles several distances by itself, and makes a gyro's scale visible."""
BIAS_ANGLE = 0.4
"""rad; of the gimbals that hold a momentum bias, 0.01 N·m·s along z on the nominal platform."""
TURNS = (2, 4, 8, 16)
"""Random angles that a path goes through: slow paths go far, fast ones accelerate."""
_DIAGONALS = np.array([[1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]]) / np.sqrt(3.0)
"""Of a cube, up to their sign: spins that have all three rates at once, which products of rates need."""
_SEED = 1
"""Of the random paths: the same data get the same proposal. It matters: for case 11 of 14 of seed 90817, a tether or a
drag, the flights of seeds 1, 2 and 4 bring 3.1, 2.8 and 3.3 σ, that of seed 3 9.7 σ, so that more draws would find
better flights."""
_FARTHEST = 1.5
"""rad from the first angles; the limits make it less."""
_SMALLER = 0.85
"""Ratio of the sizes at which a path is tried, from its whole on: the largest that keeps the limits is within 15 %."""
_SIZES = 25
"""Of those sizes: the smallest is 2 % of the path, 0.03 rad, which shows nothing any more."""


def sampled_flights(design_limits: DesignLimits) -> list[NextFlight]:
    """Return flights within the limits: every release with every path.

    Args:
        design_limits: the limits.
    """
    flights = (
        _largest(design_limits, *release, path)
        for release, path in product(_releases(design_limits.cluster), _paths(design_limits.cluster))
    )
    return [flight for flight in flights if flight is not None]


def control_points(first: Units, moves: Array) -> Array:
    """Return control points that start from given angles and at rest, and end at rest, shape (..., n, 6), rad.

    Args:
        first: angles at release, shape (6,), rad.
        moves: away from them, shape (..., n - 3, 6), rad.
    """
    still = np.zeros((*moves.shape[:-2], 2, moves.shape[-1]))
    return np.asarray(first + np.concatenate([still, moves, moves[..., -1:, :]], axis=-2))


def _releases(cluster: Cluster) -> Iterator[tuple[Array, Units]]:
    """Yield body rates and first gimbal angles."""
    still, none = np.zeros(3), np.zeros(len(cluster.rotor_momentum))
    yield still, none
    for axis in (*np.eye(3), *_DIAGONALS):
        yield RELEASE_SPIN * axis, none
    for axis in np.eye(3):
        angle = np.linalg.pinv(momentum_jacobian(cluster, none)) @ axis
        yield still, BIAS_ANGLE * angle / np.abs(angle).max()


def _paths(cluster: Cluster) -> list[Array]:
    """Return paths of any gimbal motion, and as many that leave out null motion, which moves nothing but the units."""
    rng = np.random.default_rng(_SEED)
    units = len(cluster.rotor_momentum)
    jacobian = momentum_jacobian(cluster, np.zeros(units))
    moving = np.linalg.pinv(jacobian) @ jacobian
    drawn = [rng.uniform(-_FARTHEST, _FARTHEST, (turns, units)) for turns in TURNS]
    return [_path(angles) for angles in (*drawn, *(each @ moving for each in drawn))]


def _path(angles: Array) -> Array:
    """Return the free control points of a path from zero through given angles, shape (CONTROL_POINTS - 3, M), rad.

    It leaves and arrives slowly: a jump at either end would take the whole of the acceleration limit.
    """
    through = np.concatenate([np.zeros((1, angles.shape[1])), angles])
    spline = CubicSpline(np.linspace(0.0, 1.0, len(through)), through, bc_type="clamped")
    return np.asarray(spline(np.linspace(0.0, 1.0, CONTROL_POINTS - 1)[1:-1]))


def _largest(design_limits: DesignLimits, body_rate: Array, first: Units, path: Array) -> NextFlight | None:
    """Return a path as large as the limits let it be; None where not even the release keeps them."""
    sizes = _SMALLER ** np.arange(_SIZES)
    moves = sizes[:, None, None] * path * (design_limits.cluster.rotor_momentum != 0.0)
    points = control_points(first, moves)
    kept = limit_shares(design_limits, np.tile(body_rate, (len(sizes), 1)), points).max(axis=1) <= 1.0
    if not kept.any():
        return None
    return NextFlight(body_rate=body_rate, control_points=points[kept.argmax()], duration=design_limits.duration)
