"""A size and a direction as one vector: linear from nothing on, where a size and two angles would not be."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array

SPECK = 1e-9
"""Share of the typical size at which a search starts: no motion shows it, but it has a direction."""


def size_and_direction(vector: Array) -> tuple[Array, Array]:
    """Return |v|, shape (..., 1), and the unit vector, shape (..., 3), analytic in v; both zero where v is.

    Args:
        vector: v, shape (..., 3).
    """
    square = (vector * vector).sum(axis=-1, keepdims=True)
    none = square.real == 0.0
    size = np.sqrt(np.where(none, 1.0, square))
    return np.where(none, 0.0, size), np.asarray(vector / size)


def scanned(frequencies: Array, damping_ratio: float, typical: float) -> Array:
    """Return starts (frequency, damping ratio, v) at every frequency with a speck along each axis, shape (S, 5).

    Args:
        frequencies: Hz.
        damping_ratio: at every start.
        typical: size of v.
    """
    specks = SPECK * typical * np.eye(3)
    return np.array([[frequency, damping_ratio, *speck] for frequency in frequencies for speck in specks])
