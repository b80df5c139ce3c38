"""Scalar-first quaternions: products, matrices, and vectors turned between frames.

All functions broadcast over one leading axis, of a single quaternion or vector over any number of them. SciPy's
rotations do the arithmetic; this is where its conventions end.
"""

from __future__ import annotations

import numpy as np
import scipy

from testbed.arrays import Array, Matrices3, Quaternions, Series, Vectors3


def quaternion_product(left: Quaternions, right: Quaternions) -> Quaternions:
    """Return quat_AC = quat_AB ⊗ quat_BC, shape (..., 4), unit; broadcasts.

    Written out, to the last bit as SciPy does it: that takes ten times as long for a few thousand.

    Args:
        left: quat_AB, shape (..., 4).
        right: quat_BC, shape (..., 4).
    """
    a, b, c, d = _unit(*np.moveaxis(np.asarray(left, dtype=np.float64), -1, 0))
    e, f, g, h = _unit(*np.moveaxis(np.asarray(right, dtype=np.float64), -1, 0))
    product = _unit(
        a * e - b * f - c * g - d * h,
        a * f + e * b + (c * h - d * g),
        a * g + e * c + (d * f - b * h),
        a * h + e * d + (b * g - c * f),
    )
    return np.stack(product, axis=-1)


def quaternion_inverse(quat_AB: Quaternions) -> Quaternions:
    """Return quat_BA, shape (..., 4)."""
    return _quaternion(_rotation(quat_AB).inv())


def matrix_of(quat_AB: Quaternions) -> Matrices3:
    """Return R_AB, shape (..., 3, 3), which takes B components to A."""
    matrices = _rotation(np.reshape(quat_AB, (-1, 4))).as_matrix()
    return np.asarray(matrices.reshape(*np.shape(quat_AB)[:-1], 3, 3))


def matrix_or_identity(quat_AB: Quaternions) -> Matrices3:
    """Return R_AB, shape (..., 3, 3); the identity where a diverged step left no attitude (zero, not finite)."""
    length = np.linalg.norm(quat_AB, axis=-1, keepdims=True)
    return matrix_of(np.where(np.isfinite(length) & (length > 0.0), quat_AB, [1.0, 0.0, 0.0, 0.0]))


def turned(quat_AB: Quaternions, vector_B: Vectors3) -> Vectors3:
    """Return the A components of a vector given in B, shape (..., 3)."""
    return np.asarray(_rotation(quat_AB).apply(vector_B))


def exponential(rotation_vector: Vectors3) -> Quaternions:
    """Return the quaternion that turns by |φ| about φ, shape (..., 4).

    Args:
        rotation_vector: φ, shape (..., 3), rad.
    """
    turns = scipy.spatial.transform.Rotation.from_rotvec(np.reshape(rotation_vector, (-1, 3)))
    return _quaternion(turns).reshape(*np.shape(rotation_vector)[:-1], 4)


def tilts(quat_NB: Quaternions) -> Series:
    """Return the angles between the body z axis and that of N, shape (...,), rad."""
    return np.asarray(2.0 * np.arcsin(np.minimum(1.0, np.hypot(quat_NB[..., 1], quat_NB[..., 2]))))


def _unit(w: Array, x: Array, y: Array, z: Array) -> tuple[Array, Array, Array, Array]:
    length = np.sqrt(x * x + y * y + z * z + w * w)
    return w / length, x / length, y / length, z / length


def _rotation(quat_AB: Quaternions) -> scipy.spatial.transform.Rotation:
    return scipy.spatial.transform.Rotation.from_quat(quat_AB, scalar_first=True)


def _quaternion(rotation: scipy.spatial.transform.Rotation) -> Quaternions:
    return np.asarray(rotation.as_quat(scalar_first=True))
