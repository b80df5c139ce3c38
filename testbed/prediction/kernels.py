"""The inner loops of the integration as machine code: NumPy passes over its arrays ten times for what takes one.

They broadcast as NumPy's own functions do. Numbers are real, or complex where they carry a derivative.
"""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.compiled import elementwise


def body_rate(momentum: Array, held: Array, inverse: Array) -> Array:
    """Return ω = J⁻¹ (L - h), shape (..., 3), rad/s, body axes.

    Args:
        momentum: L, shape (..., 3), N·m·s.
        held: h, shape (..., 3), N·m·s.
        inverse: J⁻¹, real, shape (..., 3, 3), 1/(kg·m²).
    """
    types = ("void(f8[:], f8[:], f8[:, :], f8[:])", "void(c16[:], c16[:], f8[:, :], c16[:])")
    return np.asarray(elementwise(_body_rate, "(n),(n),(n,n)->(n)", types)(momentum, held, inverse))


def stepped_body_rate(momentum: Array, held: Array, inverse: Array, inertia_step: Array) -> Array:
    """Return ω = (J + i dJ)⁻¹ (L - h) to first order in dJ, shape (..., 3), rad/s, body axes.

    Args:
        momentum: L, shape (..., 3), N·m·s.
        held: h, shape (..., 3), N·m·s.
        inverse: J⁻¹, real, shape (..., 3, 3), 1/(kg·m²).
        inertia_step: dJ, real, shape (..., 3, 3), kg·m².
    """
    types = ("void(c16[:], c16[:], f8[:, :], f8[:, :], c16[:])",)
    layout = "(n),(n),(n,n),(n,n)->(n)"
    return np.asarray(elementwise(_stepped_body_rate, layout, types)(momentum, held, inverse, inertia_step))


def turning(torque: Array, momentum: Array, rate: Array) -> Array:
    """Return L̇ = torque + L × ω, shape (..., 3), N·m, body axes.

    Args:
        torque: shape (..., 3), N·m.
        momentum: L, shape (..., 3), N·m·s.
        rate: ω, shape (..., 3), rad/s.
    """
    types = ("void(f8[:], f8[:], f8[:], f8[:])", "void(c16[:], c16[:], c16[:], c16[:])")
    return np.asarray(elementwise(_turning, "(n),(n),(n)->(n)", types)(torque, momentum, rate))


def carried(tangents: Array, start: Array, added: Array) -> Array:
    """Return changes of states at all nodes, each what a step adds and the tangent of the one before.

    Args:
        tangents: transposed, shape (..., M, S, S).
        start: at the first node, shape (..., P, S).
        added: by each step, shape (..., M, P, S).
    """
    given = np.concatenate([start[..., None, :, :], added], axis=-3)
    types = ("void(f8[:, :, :], f8[:, :, :], f8[:, :, :])",)
    return np.asarray(elementwise(_carry, "(m,s,s),(k,p,s)->(k,p,s)", types)(tangents, given))


def _body_rate(momentum, held, inverse, rate):
    x, y, z = momentum[0] - held[0], momentum[1] - held[1], momentum[2] - held[2]
    for row in range(3):
        rate[row] = inverse[row, 0] * x + inverse[row, 1] * y + inverse[row, 2] * z


def _stepped_body_rate(momentum, held, inverse, inertia_step, rate):
    x, y, z = momentum[0] - held[0], momentum[1] - held[1], momentum[2] - held[2]
    for row in range(3):
        rate[row] = inverse[row, 0] * x + inverse[row, 1] * y + inverse[row, 2] * z
    x, y, z = rate[0].real, rate[1].real, rate[2].real
    first = inertia_step[0, 0] * x + inertia_step[0, 1] * y + inertia_step[0, 2] * z
    second = inertia_step[1, 0] * x + inertia_step[1, 1] * y + inertia_step[1, 2] * z
    third = inertia_step[2, 0] * x + inertia_step[2, 1] * y + inertia_step[2, 2] * z
    for row in range(3):
        rate[row] -= 1j * (inverse[row, 0] * first + inverse[row, 1] * second + inverse[row, 2] * third)


def _turning(torque, momentum, rate, result):
    result[0] = torque[0] + momentum[1] * rate[2] - momentum[2] * rate[1]
    result[1] = torque[1] + momentum[2] * rate[0] - momentum[0] * rate[2]
    result[2] = torque[2] + momentum[0] * rate[1] - momentum[1] * rate[0]


def _carry(tangents, given, changes):
    steps, states = len(tangents), tangents.shape[1]
    changes[0] = given[0]
    for step in range(steps):
        for row in range(given.shape[1]):
            for state in range(states):
                total = given[step + 1, row, state]
                for before in range(states):
                    total += changes[step, row, before] * tangents[step, before, state]
                changes[step + 1, row, state] = total
