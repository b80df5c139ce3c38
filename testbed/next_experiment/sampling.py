"""Flights to choose among: releases at rest, with a spin or with a momentum bias, and random paths."""

from __future__ import annotations

from itertools import product

import numpy as np

from testbed.arrays import Array
from testbed.next_experiment.flight import NextFlight, Release
from testbed.next_experiment.space import FlightSpace

_SEED = 1
"""Of the random paths: the same data get the same proposal. It matters: for case 11 of 14 of seed 90817, a tether or a
drag, the flights of seeds 1, 2 and 4 bring 3.1, 2.8 and 3.3 σ, that of seed 3 9.7 σ, so that more draws would find
better flights."""
_SMALLER = 0.85
"""Ratio of the sizes at which a path is tried, from its whole on: the largest that keeps the limits is within 15 %."""
_SIZES = 25
"""Of those sizes: the smallest is 2 % of the path, 0.03 rad, which shows nothing any more."""


def sampled_flights(space: FlightSpace) -> list[NextFlight]:
    """Return flights within the limits: every release with every path."""
    paths = space.paths(np.random.default_rng(_SEED))
    return [
        flight for release, path in product(space.releases(), paths) for flight in largest_flight(space, release, path)
    ]


def largest_flight(space: FlightSpace, release: Release, path: Array) -> list[NextFlight]:
    """Return a path as large as the limits let it be; none where not even the release keeps them."""
    sizes = _SMALLER ** np.arange(_SIZES)
    points = space.points(release, sizes[:, None, None] * path)
    kept = space.shares(release, points).max(axis=1) <= 1.0
    return list(space.flights(release, points[kept.argmax()][None])) if kept.any() else []
