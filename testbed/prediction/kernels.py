"""The inner loops of the integration as machine code: NumPy passes over its arrays ten times for what takes one.

Arrays hold vectors of N instants and P parameter sets, and broadcast over both. Numbers are real, or complex where
they carry a derivative.
"""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.compiled import kept

_REAL, _CARRYING, _MATRICES = ("f8", 3), ("c16", 3), ("f8", 4)
"""Kinds of numbers and numbers of axes."""


def body_rate(momentum: Array, held: Array, inverse: Array) -> Array:
    """Return ω = J⁻¹ (L - h), shape (N, P, 3), rad/s, body axes.

    Args:
        momentum: L, shape (N, P, 3), N·m·s.
        held: h, shape (N, P, 3), N·m·s.
        inverse: J⁻¹, real, shape (N, P, 3, 3), 1/(kg·m²).
    """
    given, rate = _vectors((momentum, held), (inverse,))
    types = [(kind, kind, _MATRICES, kind) for kind in (_REAL, _CARRYING)]
    kept(_body_rate, *types)(*given, rate)
    return rate


def stepped_body_rate(momentum: Array, held: Array, inverse: Array, inertia_step: Array) -> Array:
    """Return ω = (J + i dJ)⁻¹ (L - h) to first order in dJ, shape (N, P, 3), rad/s, body axes.

    Args:
        momentum: L, shape (N, P, 3), N·m·s.
        held: h, shape (N, P, 3), N·m·s.
        inverse: J⁻¹, real, shape (N, P, 3, 3), 1/(kg·m²).
        inertia_step: dJ, real, shape (N, P, 3, 3), kg·m².
    """
    given, rate = _vectors((momentum.astype(np.complex128, copy=False), held), (inverse, inertia_step))
    kept(_stepped_body_rate, (_CARRYING, _CARRYING, _MATRICES, _MATRICES, _CARRYING))(*given, rate)
    return rate


def turning(torque: Array, momentum: Array, rate: Array) -> Array:
    """Return L̇ = torque + L × ω, shape (N, P, 3), N·m, body axes.

    Args:
        torque: shape (N, P, 3), N·m.
        momentum: L, shape (N, P, 3), N·m·s.
        rate: ω, shape (N, P, 3), rad/s.
    """
    given, slope = _vectors((torque, momentum, rate), ())
    kept(_turning, (_REAL,) * 4, (_CARRYING,) * 4)(*given, slope)
    return slope


def carried(tangents: Array, start: Array, added: Array) -> Array:
    """Return changes of states at all nodes, each the tangent of the one before and what a step adds.

    Args:
        tangents: transposed, shape (R, M, S, S).
        start: at the first node, shape (R, P, S).
        added: by each step, shape (R, M, P, S).
    """
    changes = np.concatenate([start[:, None], added], axis=1)
    kept(_carry, (_MATRICES, _MATRICES))(tangents, changes)
    return changes


def _vectors(vectors: tuple[Array, ...], matrices: tuple[Array, ...]) -> tuple[list[Array], Array]:
    """Return arrays broadcast to one another, the vectors with one kind of number, and room for a result like them."""
    sides = np.broadcast_shapes(*(each.shape[:2] for each in (*vectors, *matrices)))
    kind = np.result_type(*vectors)
    given = [np.broadcast_to(each.astype(kind, copy=False), (*sides, 3)) for each in vectors]
    given += [np.broadcast_to(each, (*sides, 3, 3)) for each in matrices]
    return given, np.empty((*sides, 3), dtype=kind)


def _body_rate(momentum, held, inverse, rate):
    for n in range(rate.shape[0]):
        for p in range(rate.shape[1]):
            x = momentum[n, p, 0] - held[n, p, 0]
            y = momentum[n, p, 1] - held[n, p, 1]
            z = momentum[n, p, 2] - held[n, p, 2]
            for row in range(3):
                rate[n, p, row] = inverse[n, p, row, 0] * x + inverse[n, p, row, 1] * y + inverse[n, p, row, 2] * z


def _stepped_body_rate(momentum, held, inverse, inertia_step, rate):
    for n in range(rate.shape[0]):
        for p in range(rate.shape[1]):
            x = momentum[n, p, 0] - held[n, p, 0]
            y = momentum[n, p, 1] - held[n, p, 1]
            z = momentum[n, p, 2] - held[n, p, 2]
            by, step = inverse[n, p], inertia_step[n, p]
            for row in range(3):
                rate[n, p, row] = by[row, 0] * x + by[row, 1] * y + by[row, 2] * z
            a, b, c = rate[n, p, 0].real, rate[n, p, 1].real, rate[n, p, 2].real
            first = step[0, 0] * a + step[0, 1] * b + step[0, 2] * c
            second = step[1, 0] * a + step[1, 1] * b + step[1, 2] * c
            third = step[2, 0] * a + step[2, 1] * b + step[2, 2] * c
            for row in range(3):
                rate[n, p, row] -= 1j * (by[row, 0] * first + by[row, 1] * second + by[row, 2] * third)


def _turning(torque, momentum, rate, slope):
    for n in range(slope.shape[0]):
        for p in range(slope.shape[1]):
            x, y, z = momentum[n, p, 0], momentum[n, p, 1], momentum[n, p, 2]
            a, b, c = rate[n, p, 0], rate[n, p, 1], rate[n, p, 2]
            slope[n, p, 0] = torque[n, p, 0] + y * c - z * b
            slope[n, p, 1] = torque[n, p, 1] + z * a - x * c
            slope[n, p, 2] = torque[n, p, 2] + x * b - y * a


def _carry(tangents, changes):
    for run in range(changes.shape[0]):
        for step in range(tangents.shape[1]):
            for row in range(changes.shape[2]):
                for state in range(changes.shape[3]):
                    for before in range(changes.shape[3]):
                        changes[run, step + 1, row, state] += (
                            changes[run, step, row, before] * tangents[run, step, before, state]
                        )
