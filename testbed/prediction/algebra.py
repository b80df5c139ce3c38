"""Vectors, quaternions and symmetric matrices in arithmetic that a complex step passes through."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.dynamics.inertia import inertia_of


def inertia_matrix(theta: Array) -> Array:
    """Return J of θ, shape (P, 3, 3), keeping complex values; as `inertia_of`."""
    if not np.iscomplexobj(theta):
        return inertia_of(theta)
    return inertia_of(theta.real) + 1j * inertia_of(theta.imag)


def cross(left: Array, right: Array) -> Array:
    """Return left × right, shape (..., 3); NumPy's own spends ten times as long on moving axes."""
    a, b, c = left[..., 0], left[..., 1], left[..., 2]
    x, y, z = right[..., 0], right[..., 1], right[..., 2]
    first = b * z - c * y
    product = np.empty((*first.shape, 3), dtype=first.dtype)
    product[..., 0], product[..., 1], product[..., 2] = first, c * x - a * z, a * y - b * x
    return product


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


def matrix_of_quaternion(quaternion: Array) -> Array:
    """Return the rotation matrix of scalar-first quaternions, shape (..., 3, 3), analytic in their entries."""
    w, x, y, z = (quaternion[..., index] for index in range(4))
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion_rate(quaternion: Array, body_rate: Array) -> Array:
    """Return q̇ = ½ q ⊗ (0, ω), shape (..., 4)."""
    scalar, vector = quaternion[..., :1], quaternion[..., 1:]
    turning = scalar * body_rate + cross(vector, body_rate)
    return 0.5 * np.concatenate((-dot(vector, body_rate), turning), axis=-1)
