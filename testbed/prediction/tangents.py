"""Slopes of a gyrostat's states with their derivatives, and those of a whole step, as machine code.

Rows are states: the momentum, the attitude as a quaternion where it is asked for, and the effects' own. What the
effects add to slopes is given; all that a gyrostat itself does to them is worked out here in one pass.
"""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.compiled import kept

_SERIES, _TABLE, _BLOCKS, _SETS = ("f8", 1), ("f8", 2), ("f8", 3), ("f8", 4)
"""Kinds of numbers and numbers of axes."""
BESIDE = 4
"""Columns of a slope's array beside the derivatives by the states: by the momentum that is held, and the slope."""


def slopes(
    states: Array,
    rates: Array,
    momentum: Array,
    torque: Array,
    inverse: Array,
    hidden: Array,
    live: Array,
    coupling: Array,
    effects: Array,
    attitude: bool,
) -> Array:
    """Return slopes of states at N instants beside their derivatives, shape (N, S, S + 4).

    Columns are the derivatives by the states, by the momentum h that the units hold, and the slope itself.

    Args:
        states: shape (N, S); the first three are the momentum L about the axes that turn, N·m·s, body axes.
        rates: ω, shape (N, 3), rad/s.
        momentum: L about all axes, shape (N, 3), N·m·s.
        torque: on the body, but that of the effects, shape (N, 3), N·m.
        inverse: J⁻¹, shape (N, 3, 3), 1/(kg·m²).
        hidden: derivatives by the states of the momentum that the effects' states hold, shape (N, 3, S).
        live: one for axes about which the body turns, zero for those that a bearing holds, shape (N, 3).
        coupling: rows of J of held axes in the columns of free ones, shape (N, 3, 3), kg·m².
        effects: what they add: derivatives by states and by ω, and slopes, shape (N, S, S + 4).
        attitude: whether the next four states are one, as a quaternion.
    """
    number, size = states.shape
    given = [
        np.broadcast_to(each, (number, *each.shape[1:]))
        for each in (states, rates, momentum, torque, inverse, hidden, live, coupling, effects)
    ]
    found = np.empty((number, size, size + BESIDE))
    kinds = (_TABLE, _TABLE, _TABLE, _TABLE, _BLOCKS, _BLOCKS, _TABLE, _BLOCKS, _BLOCKS, ("b1", 1), _BLOCKS)
    kept(_slopes, kinds)(*given, np.array([attitude]), found)
    return found


def weights(of_slopes: Array, step: Array) -> Array:
    """Return how what steps of the classical rule reach changes with each slope and with h, shape (4, N, S, S + 3).

    Args:
        of_slopes: the four slopes of N steps as `slopes` returns them, shape (4, N, S, S + 4).
        step: shape (N,), s.
    """
    found = np.empty((*of_slopes.shape[:3], of_slopes.shape[2] + 3))
    kept(_weights, (_SETS, _SERIES, _SETS))(of_slopes, step, found)
    return found


def tangents(of_slopes: Array, by_slope: Array) -> Array:
    """Return the derivatives of what steps reach by the states before, transposed, shape (N, S, S).

    Args:
        of_slopes: the four slopes of N steps as `slopes` returns them, shape (4, N, S, S + 4).
        by_slope: their weights as `weights` returns them, shape (4, N, S, S + 3).
    """
    _, number, size, _ = of_slopes.shape
    found = np.empty((number, size, size))
    kept(_tangents, (_SETS, _SETS, _BLOCKS))(of_slopes, by_slope, found)
    return found


def _slopes(states, rates, momentum, torque, inverse, hidden, live, coupling, effects, attitude, found):
    size = states.shape[1]
    by_rate, rate_by = np.empty((size, 3)), np.empty((3, size))
    turning, across = np.empty((3, 3)), np.empty((3, 3))
    for n in range(found.shape[0]):
        of = found[n]
        _cross_matrix(rates[n], turning)
        for row in range(size):
            for column in range(size):
                of[row, column] = effects[n, row, column]
            for axis in range(3):
                by_rate[row, axis] = effects[n, row, size + axis]
                of[row, size + axis] = 0.0
            of[row, size + 3] = effects[n, row, size + 3]
        _momentum_rows(of, by_rate, turning, across, momentum[n], torque[n], live[n], coupling[n], hidden[n])
        if attitude[0]:
            _attitude_rows(of, by_rate, states[n], rates[n], turning)
        _rate_by_states(inverse[n], hidden[n], rate_by)
        for row in range(size):
            for column in range(size):
                for axis in range(3):
                    of[row, column] += by_rate[row, axis] * rate_by[axis, column]
            for column in range(3):
                for axis in range(3):
                    of[row, size + column] -= by_rate[row, axis] * inverse[n, axis, column]


def _rate_by_states(inverse, hidden, rate_by):
    """Fill in the derivatives of ω = J⁻¹ (L - h - hidden)."""
    for axis in range(3):
        for column in range(rate_by.shape[1]):
            total = inverse[axis, column] if column < 3 else 0.0
            for between in range(3):
                total -= inverse[axis, between] * hidden[between, column]
            rate_by[axis, column] = total


def _cross_matrix(vector, matrix):
    matrix[0, 0], matrix[0, 1], matrix[0, 2] = 0.0, -vector[2], vector[1]
    matrix[1, 0], matrix[1, 1], matrix[1, 2] = vector[2], 0.0, -vector[0]
    matrix[2, 0], matrix[2, 1], matrix[2, 2] = -vector[1], vector[0], 0.0


def _momentum_rows(of, by_rate, turning, across, momentum, torque, live, coupling, hidden):
    """Add L̇ = torque - ω × L; the momentum about held axes is no state, but follows from the others."""
    size = of.shape[0]
    for row in range(3):
        for axis in range(3):
            across[row, axis] = -turning[row, axis] * (1.0 - live[axis])
            of[row, axis] -= turning[row, axis] * live[axis]
            of[row, size + axis] = across[row, axis]
            of[row, size + 3] -= turning[row, axis] * momentum[axis]
        of[row, size + 3] += torque[row]
    x, y, z = momentum[0], momentum[1], momentum[2]
    by_rate[0, 1] -= z
    by_rate[0, 2] += y
    by_rate[1, 0] += z
    by_rate[1, 2] -= x
    by_rate[2, 0] -= y
    by_rate[2, 1] += x
    for row in range(3):
        for between in range(3):
            for axis in range(3):
                by_rate[row, axis] += across[row, between] * coupling[between, axis]
            for column in range(size):
                of[row, column] += across[row, between] * hidden[between, column]
        for axis in range(3):
            by_rate[row, axis] *= live[row]
        for column in range(size + 4):
            of[row, column] *= live[row]


def _attitude_rows(of, by_rate, state, rate, turning):
    """Add q̇ = ½ q ⊗ (0, ω)."""
    size = of.shape[0]
    w, x, y, z = state[3], state[4], state[5], state[6]
    for axis in range(3):
        of[3, 4 + axis] -= 0.5 * rate[axis]
        of[4 + axis, 3] += 0.5 * rate[axis]
        by_rate[3, axis] -= 0.5 * state[4 + axis]
        by_rate[4 + axis, axis] += 0.5 * w
        for other in range(3):
            of[4 + axis, 4 + other] -= 0.5 * turning[axis, other]
    by_rate[4, 1] -= 0.5 * z
    by_rate[4, 2] += 0.5 * y
    by_rate[5, 0] += 0.5 * z
    by_rate[5, 2] -= 0.5 * x
    by_rate[6, 0] -= 0.5 * y
    by_rate[6, 1] += 0.5 * x
    a, b, c = rate[0], rate[1], rate[2]
    of[3, size + 3] -= 0.5 * (x * a + y * b + z * c)
    of[4, size + 3] += 0.5 * (w * a + (y * c - z * b))
    of[5, size + 3] += 0.5 * (w * b + (z * a - x * c))
    of[6, size + 3] += 0.5 * (w * c + (x * b - y * a))


def _weights(of_slopes, step, found):
    size = of_slopes.shape[2]
    for n in range(found.shape[1]):
        for stage in range(3, -1, -1):
            of = found[stage, n]
            times = step[n] / 6.0 if stage in (0, 3) else step[n] / 3.0
            share = 0.0 if stage == 3 else (step[n] if stage == 2 else step[n] / 2.0)
            for row in range(size):
                for column in range(size):
                    total = times if row == column else 0.0
                    if stage < 3:
                        for between in range(size):
                            later = found[stage + 1, n, row, between]
                            total += share * later * of_slopes[stage + 1, n, between, column]
                    of[row, column] = total
                for axis in range(3):
                    total = 0.0
                    for between in range(size):
                        total += of[row, between] * of_slopes[stage, n, between, size + axis]
                    of[row, size + axis] = total


def _tangents(of_slopes, by_slope, found):
    size = found.shape[1]
    for n in range(found.shape[0]):
        for row in range(size):
            for column in range(size):
                found[n, column, row] = 1.0 if row == column else 0.0
        for stage in range(4):
            for row in range(size):
                for between in range(size):
                    weight = by_slope[stage, n, row, between]
                    for column in range(size):
                        found[n, column, row] += weight * of_slopes[stage, n, between, column]
