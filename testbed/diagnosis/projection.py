"""What columns span, and what is left of others beside it."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array

NEGLIGIBLE = 1e-9
"""Share of a column's length that has to be left for its direction to count."""


def orthonormal(matrix: Array) -> Array:
    """Return an orthonormal basis of what a matrix's columns span, whatever their scales, shape (N, rank)."""
    scale = np.maximum(np.linalg.norm(matrix, axis=0), np.finfo(float).tiny)
    left, strength, _ = np.linalg.svd(matrix / scale, full_matrices=False)
    return np.asarray(left[:, strength > NEGLIGIBLE])


def projected_out(values: Array, basis: Array) -> Array:
    """Return what of a vector or of columns lies outside of what a basis spans.

    Args:
        values: shape (N,) or (N, C).
        basis: orthonormal, shape (N, rank).
    """
    return np.asarray(values - basis @ (basis.T @ values))
