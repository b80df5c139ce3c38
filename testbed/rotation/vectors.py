"""Vectors along an array's last axis."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array


def cross(left: Array, right: Array) -> Array:
    """Return left × right, shape (..., 3), of arrays that broadcast to one another.

    The same bits as NumPy's own, which takes four times as long for a few vectors: it looks after axes and dimensions.
    """
    x, y, z = left[..., 0], left[..., 1], left[..., 2]
    u, v, w = right[..., 0], right[..., 1], right[..., 2]
    first = y * w - z * v
    product = np.empty((*first.shape, 3), dtype=first.dtype)
    product[..., 0], product[..., 1], product[..., 2] = first, z * u - x * w, x * v - y * u
    return product
