"""Recursions over many steps as machine code."""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.compiled import kept


def accumulated(keeps: Array, added: Array) -> Array:
    """Return y with y_k = a_k y_{k-1} + x_k along the second axis, y_0 = x_0, shape (P, K, W).

    Args:
        keeps: a; of the first of the K it counts for nothing, shape (P, K, W) or (1, K, W).
        added: x, shape (P, K, W) or (1, K, W).
    """
    kind = np.result_type(keeps, added)
    shape = np.broadcast_shapes(keeps.shape, added.shape)
    sums = np.array(np.broadcast_to(added, shape), dtype=kind, order="C")
    accumulate = kept(_accumulate, (("f8", 3), ("f8", 3)), (("c16", 3), ("c16", 3)))
    accumulate(np.broadcast_to(keeps, shape).astype(kind), sums)
    return sums


def pivots(own: Array, shared: Array) -> Array:
    """Return the pivots d of W symmetric tridiagonal matrices, d_k = a_k - b_k² / d_{k-1}, shape (K, W).

    Args:
        own: a, on the diagonal, shape (K, W).
        shared: b, beside it, of each with the one before; none of the first, shape (K, W).
    """
    left = np.array(own, order="C")
    kept(_eliminate, (("f8", 2), ("f8", 2)))(shared, left)
    return left


def _accumulate(keeps, sums):
    for guess in range(sums.shape[0]):
        for step in range(1, sums.shape[1]):
            for unit in range(sums.shape[2]):
                sums[guess, step, unit] += keeps[guess, step, unit] * sums[guess, step - 1, unit]


def _eliminate(shared, left):
    for step in range(1, left.shape[0]):
        for unit in range(left.shape[1]):
            left[step, unit] -= shared[step, unit] ** 2 / left[step - 1, unit]
