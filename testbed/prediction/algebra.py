"""Vectors and symmetric matrices in arithmetic that a complex step passes through."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.dynamics.inertia import inertia_of


def inertia_matrix(theta: Array) -> Array:
    """Return J of θ, shape (P, 3, 3), keeping complex values; as `inertia_of`."""
    if not np.iscomplexobj(theta):
        return inertia_of(theta)
    return inertia_of(theta.real) + 1j * inertia_of(theta.imag)


def dot(left: Array, right: Array) -> Array:
    """Return left · right, shape (..., 1), without a conjugate; over three components sums are slow."""
    return np.asarray(
        left[..., :1] * right[..., :1] + left[..., 1:2] * right[..., 1:2] + left[..., 2:] * right[..., 2:]
    )


def applied(matrix: Array, vector: Array) -> Array:
    """Return matrix · vector, shape (..., P, 3), of matrices (..., P or 1, 3, 3); faster than `numpy.matvec`."""
    if matrix.shape[-3] == 1:
        return np.asarray(vector @ np.swapaxes(matrix[..., 0, :, :], -1, -2))
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    rows = [matrix[..., row, 0] * x + matrix[..., row, 1] * y + matrix[..., row, 2] * z for row in range(3)]
    return np.stack(rows, axis=-1)
