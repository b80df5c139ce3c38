"""The inner loops of predictions as machine code: NumPy passes over its arrays ten times for what takes one.

Arrays hold vectors of N instants and P parameter sets, and broadcast over both. Numbers are real, or complex where
they carry a derivative.
"""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Flags
from testbed.compiled import kept

_REAL, _CARRYING, _MATRICES = ("f8", 3), ("c16", 3), ("f8", 4)
"""Kinds of numbers and numbers of axes: vectors, vectors that carry a derivative, matrices."""

_TURNED = ("c16", 4)
"""The same of rotation matrices that carry a derivative."""

_LAW, _TICKS = ("f8", 1), (("f8", 2), ("c16", 2))
"""Kinds of numbers and numbers of axes: the constants of a servo's law, its signals at ticks."""


class Polynomials(NamedTuple):
    """Polynomials of the second degree in numbers z, of P parameter sets.

    Attributes:
        terms: of each, which polynomial it belongs to and which two of (1, z) are multiplied, shape (T, 3).
        factors: of the terms, shape (P, T).
    """

    terms: NDArray[np.intp]
    factors: Array


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


def cross(left: Array, right: Array) -> Array:
    """Return left × right, shape (..., 3), of arrays that broadcast to one another."""
    sides = np.broadcast(left, right).shape
    kind = np.result_type(left, right)
    rows = [as_large(each.astype(kind, copy=False), sides).reshape(-1, *sides[-2:]) for each in (left, right)]
    product = np.empty(sides, dtype=kind)
    kept(_cross, (_REAL,) * 3, (_CARRYING,) * 3)(*rows, product.reshape(rows[0].shape))
    return product


def as_large(values: Array, shape: tuple[int, ...]) -> Array:
    """Return values broadcast to a shape, at no cost where they have it."""
    return values if values.shape == shape else np.broadcast_to(values, shape)


def matrix_of_quaternion(quaternion: Array) -> Array:
    """Return the rotation matrices of scalar-first quaternions, shape (N, P, 4), analytic in them: (N, P, 3, 3)."""
    matrix = np.empty((*quaternion.shape[:-1], 3, 3), dtype=quaternion.dtype)
    kept(_matrix_of_quaternion, (_REAL, _MATRICES), (_CARRYING, _TURNED))(quaternion, matrix)
    return matrix


def quaternion_rate(quaternion: Array, rate: Array) -> Array:
    """Return q̇ = ½ q ⊗ (0, ω), shape (N, P, 4), of quaternions (N, P, 4) and ω (N, P, 3), rad/s."""
    kind = np.result_type(quaternion, rate)
    given = [each.astype(kind, copy=False) for each in (quaternion, rate)]
    turning = np.empty(quaternion.shape, dtype=kind)
    kept(_quaternion_rate, (_REAL,) * 3, (_CARRYING,) * 3)(*given, turning)
    return turning


def turned_along(rates: Array, step: Array) -> Array:
    """Return quaternions along a motion that begins with the identity, shape (R, N, 4).

    Args:
        rates: ω at nodes, shape (R, N, 3), rad/s, body axes.
        step: from node to node, shape (R,), s.
    """
    quaternions = np.empty((*rates.shape[:2], 4))
    kept(_turn_along, (_REAL, ("f8", 1), _REAL))(rates, step, quaternions)
    return quaternions


def turned_back(direction: Array, matrix: Array) -> Array:
    """Return Rᵀ u, shape (N, P, 3).

    Args:
        direction: u, shape (N or 1, 1, 3).
        matrix: R, shape (N, P, 3, 3).
    """
    components = np.empty(matrix.shape[:3], dtype=matrix.dtype)
    given = np.broadcast_to(direction, components.shape)
    kept(_turned_back, (_REAL, _MATRICES, _REAL), (_REAL, _TURNED, _CARRYING))(given, matrix, components)
    return components


def orbit_torques(first: Array, angle: Array, attitude: Array, inertia: Array, constants: Array) -> Array:
    """Return 3 n² r × J r + m × B and a torque that is constant in local axes, shape (N, P, 3), N·m, body axes.

    As `dynamics.environment.orbit_torque` has it, from the attitude on.

    Args:
        first: R_NR at each run's first sample, shape (N, 3, 3).
        angle: by which local axes have turned since those of N, shape (N,), rad.
        attitude: R_RB, shape (N, P, 3, 3).
        inertia: J, shape (P or 1, 3, 3), kg·m².
        constants: 3 n², m, B and the constant torque, B and torque in local axes, shape (10,).
    """
    kind = np.result_type(attitude, inertia)
    sides = len(attitude), max(attitude.shape[1], len(inertia))
    given = [
        np.broadcast_to(each.astype(kind, copy=False), (*of, 3, 3))
        for each, of in ((attitude, sides), (inertia, sides[1:]))
    ]
    torque = np.empty((*sides, 3), dtype=kind)
    fixed = ("f8", 3), ("f8", 1)
    types = [
        (*fixed, turned, numbers, ("f8", 1), numbers) for turned, numbers in ((_MATRICES, _REAL), (_TURNED, _CARRYING))
    ]
    kept(_orbit_torques, *types)(first, angle, *given, constants, torque)
    return torque


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


def changed_by(added: Array, by: Array, changes: Array, sets: NDArray[np.intp]) -> None:
    """Add what changes of the first of S slopes, or of a momentum, do to some of P parameter sets, (R, W, P, S).

    Args:
        added: is changed.
        by: derivatives by them, shape (R, W, S, K) or more.
        changes: shape (R W, Q, K).
        sets: which Q of the parameter sets change.
    """
    steps = by.reshape(-1, *by.shape[2:])
    kept(_change_by, (_REAL, _REAL, ("i8", 1), _REAL))(steps, changes, sets, added.reshape(-1, *added.shape[2:]))


def forced(added: Array, by: Array, changes: Array, instants: Sequence[int]) -> None:
    """Add what changes of a vector do to states, to an array of shape (R, W, P, S).

    Args:
        added: is changed.
        by: derivatives by the vector at some instants of each of W steps, shape (I, R, W, S, 3).
        changes: of the vector along the grid, shape (R or 1, P, T or 1, 3).
        instants: in half steps from the steps' beginnings, I of them.
    """
    runs, steps, sets, _ = added.shape
    everywhere = np.broadcast_to(changes, (runs, sets, 2 * steps + max(instants) - 1, 3))
    kept(_force, (("f8", 5), ("f8", 4), ("i8", 1), ("f8", 4)))(by, everywhere, np.array(instants), added)


def driven(
    rate: Polynomials,
    held: Polynomials,
    start: Array,
    motion: tuple[Array, Array],
    by_momentum: Array,
    by_node: Array,
) -> Array:
    """Return what states add that follow a motion by the classical rule, shape (R, M + 1, P, S + 3).

    At every node: what its step adds to the changes of the motion's S states, none at the last one, and the change of ω
    there by the momentum that they hold.

    Args:
        rate: of the K states, polynomials in these and ω.
        held: momentum, 3 polynomials in the same.
        start: the states at first, shape (R, P, K).
        motion: ω where the steps take their slopes, shape (4, R, M, 3), rad/s, and each run's step, shape (R,), s.
        by_momentum: derivatives of the motion's states after each step by the momentum in each slope, shape
            (4, R, M, S, 3).
        by_node: of ω at the nodes, shape (R, M + 1, 3, 3).
    """
    changes = np.zeros((start.shape[0], by_node.shape[1], start.shape[1], by_momentum.shape[3] + 3))
    terms, factors = ("i8", 2), ("c16", 2)
    signature = (terms, factors, terms, factors, _CARRYING, _MATRICES, ("f8", 1), ("f8", 5), _MATRICES, _MATRICES)
    kept(_drive, signature)(*rate, *held, start, *motion, by_momentum, by_node, changes)
    return changes


def forced_by_inertia(added: Array, by: Array, rates: Array, inertia_step: Array, instants: Sequence[int]) -> None:
    """Add what changes of the inertia do, as `forced`: each is as a change of the momentum by dJ ω.

    Args:
        added: is changed.
        by: as there, by the momentum.
        rates: ω at these instants, shape (I, R, W, 3), rad/s.
        inertia_step: dJ, shape (R or 1, P, T or 1, 3, 3), kg·m².
        instants: as there.
    """
    runs, steps, sets, _ = added.shape
    everywhere = np.broadcast_to(inertia_step, (runs, sets, 2 * steps + max(instants) - 1, 3, 3))
    signature = (("f8", 5), ("f8", 4), ("f8", 5), ("i8", 1), ("f8", 4))
    kept(_force_by_inertia, signature)(by, rates, everywhere, np.array(instants), added)


def answers(
    by_torque: Array, tangents: Array, by_state: Array, knots: NDArray[np.intp], axes: NDArray[np.intp], apart: float
) -> Array:
    """Return what torques at knots do to ω at the nodes of R runs, shape (R, P, M + 1, 3), rad/s per N·m.

    A torque is linear between knots: one at its own, zero at the others.

    Args:
        by_torque: derivatives of the states after each step by a torque at its beginning, twice in its middle and at
            its end, shape (4, R, M, S, 3).
        tangents: as in `carried`.
        by_state: derivatives of ω at the nodes by the states, shape (R, M + 1, 3, S).
        knots: at which, P of them, counted from that at the first node.
        axes: about which, shape (P,).
        apart: half steps from knot to knot.
    """
    runs, nodes = by_state.shape[:2]
    rates = np.zeros((runs, len(knots), nodes, 3))
    signature = (("f8", 5), _MATRICES, _MATRICES, ("i8", 1), ("i8", 1), ("f8", 1), _MATRICES)
    kept(_answer, signature)(by_torque, tangents, by_state, knots, axes, np.array([apart]), rates)
    return rates


def slopes_a_unit_apart(values: Array) -> Array:
    """Return the slopes of the cubic spline through values at nodes that are a unit apart, as in `smooth.node_slopes`.

    Args:
        values: shape (..., M + 1, A), of four nodes or more.
    """
    flat = values.reshape(-1, *values.shape[-2:])
    slopes = np.empty(flat.shape, dtype=values.dtype)
    kept(_solve_slopes, (_REAL, _REAL), (_CARRYING, _CARRYING))(flat, slopes)
    return slopes.reshape(values.shape)


def cubic_between(values: Array, rises: Array, place: Array) -> Array:
    """Return cubics between nodes, shape (P, N, A).

    Args:
        values: at the nodes, shape (P, M + 1, A).
        rises: their slopes there, times the nodes' distance, alike.
        place: where, in nodes from the first, shape (P, N); before the first it is the first piece that goes on.
    """
    kind = np.result_type(values, place)
    given = [np.asarray(each, dtype=kind) for each in (values, rises, place)]
    between = np.empty((*place.shape, values.shape[-1]), dtype=kind)
    kept(_between, *((each, each, (each[0], 2), each) for each in (_REAL, _CARRYING)))(*given, between)
    return between


def followed(begin: Array, end: Array, kept_share: Array) -> Array:
    """Return what settles on lines, one in each step, shape (P, M + 1, A): at first it is on the first one.

    Args:
        begin: where the lines begin, shape (P, M, A).
        end: where they end, alike.
        kept_share: of the distance to a line after its step, shape (P, M).
    """
    kind = np.result_type(begin, end, kept_share)
    given = [np.asarray(each, dtype=kind) for each in (begin, end, kept_share)]
    states = np.empty((begin.shape[0], begin.shape[1] + 1, begin.shape[2]), dtype=kind)
    kept(_follow, *((each, each, (each[0], 2), each) for each in (_REAL, _CARRYING)))(*given, states)
    return states


def settled_cubics(values: Array, slopes: Array, lag: Array, kept_share: Array) -> Array:
    """Return what follows cubics a unit apart behind T ẋ = u - x, settled on the first one, shape (P, M + 1, A).

    With u(s) = Σ c_j sʲ on a step, the particular solution is Σ d_j sʲ, d_3 = c_3, d_j = c_j - (j + 1) T d_(j+1).

    Args:
        values: at nodes, shape (P, M + 1, A).
        slopes: there, a unit.
        lag: T, shape (P,), in units.
        kept_share: exp(-1 / T), shape (P,).
    """
    kind = np.result_type(values, slopes, lag, kept_share)
    given = [np.asarray(each, dtype=kind) for each in (values, slopes, lag, kept_share)]
    states = np.empty(values.shape, dtype=kind)
    kept(_settle, *((each, each, (each[0], 1), (each[0], 1), each) for each in (_REAL, _CARRYING)))(*given, states)
    return states


def servo_angles(signals: Sequence[Array], step: Sequence[Array], law: Sequence[float]) -> Array:
    """Return the angles of W gimbals at N ticks of their servo's clock, shape (N, W), rad.

    Args:
        signals: commanded rate, rad/s, push that is fed forward, load and its slope, rad/s², shapes (N, W), as in
            `servo.Ticks`; the first rows' angle, rad, shape (1, W), is the last of them.
        step: what the next angle takes of rate, push, rest and slope; what the next rate keeps of itself and takes of
            push, rest and slope; and the share of the rest that remains, each a number or of shape (W,).
        law: ω_b, 1/s, ω_n² / ω_b, 1/s, the rate limit, rad/s, the bound of d_c, rad, and the period, s.
    """
    kind = np.result_type(*signals, *step)
    command, *_, first = signals
    table = np.stack([np.broadcast_to(each, first.shape[1]) for each in step])
    angles = np.empty(command.shape, dtype=kind)
    given = [np.asarray(each, dtype=kind) for each in (*signals, table)]
    kept(_servo_angles, *((each,) * 6 + (_LAW, each) for each in _TICKS))(*given, np.array(law), angles)
    return angles


def set_points(command: Array, angle: Array, anew: Flags, law: Sequence[float]) -> Array:
    """Return the set points of W tachometer loops before their limit, by measured angles, shape (N, W), rad/s.

    Args:
        command: commanded rate at N ticks of the servo's clock, shape (N, W), rad/s.
        angle: measured there, alike, rad.
        anew: at which ticks d_c counts as where the gimbals are, shape (N,); at the first one it always does.
        law: ω_n² / ω_b, 1/s, the bound of d_c, rad, and the period, s.
    """
    points = np.empty(command.shape)
    kept(_set_points, (_TICKS[0], _TICKS[0], ("b1", 1), _LAW, _TICKS[0]))(command, angle, anew, np.array(law), points)
    return points


def _vectors(vectors: tuple[Array, ...], matrices: tuple[Array, ...]) -> tuple[list[Array], Array]:
    """Return arrays broadcast to one another, the vectors with one kind of number, and room for a result like them."""
    sides = np.broadcast(*(each[..., 0] for each in vectors), *(each[..., 0, 0] for each in matrices)).shape
    kind = np.result_type(*vectors)
    given = [as_large(each.astype(kind, copy=False), (*sides, 3)) for each in vectors]
    given += [as_large(each, (*sides, 3, 3)) for each in matrices]
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


def _cross(left, right, product):
    for n in range(product.shape[0]):
        for p in range(product.shape[1]):
            a, b, c = left[n, p, 0], left[n, p, 1], left[n, p, 2]
            x, y, z = right[n, p, 0], right[n, p, 1], right[n, p, 2]
            product[n, p, 0] = b * z - c * y
            product[n, p, 1] = c * x - a * z
            product[n, p, 2] = a * y - b * x


def _matrix_of_quaternion(quaternion, matrix):
    for n in range(matrix.shape[0]):
        for p in range(matrix.shape[1]):
            w, x, y, z = quaternion[n, p, 0], quaternion[n, p, 1], quaternion[n, p, 2], quaternion[n, p, 3]
            of = matrix[n, p]
            of[0, 0] = w * w + x * x - y * y - z * z
            of[0, 1] = 2 * (x * y - w * z)
            of[0, 2] = 2 * (x * z + w * y)
            of[1, 0] = 2 * (x * y + w * z)
            of[1, 1] = w * w - x * x + y * y - z * z
            of[1, 2] = 2 * (y * z - w * x)
            of[2, 0] = 2 * (x * z - w * y)
            of[2, 1] = 2 * (y * z + w * x)
            of[2, 2] = w * w - x * x - y * y + z * z


def _quaternion_rate(quaternion, rate, turning):
    for n in range(turning.shape[0]):
        for p in range(turning.shape[1]):
            w, x, y, z = quaternion[n, p, 0], quaternion[n, p, 1], quaternion[n, p, 2], quaternion[n, p, 3]
            a, b, c = rate[n, p, 0], rate[n, p, 1], rate[n, p, 2]
            turning[n, p, 0] = 0.5 * -(x * a + y * b + z * c)
            turning[n, p, 1] = 0.5 * (w * a + (y * c - z * b))
            turning[n, p, 2] = 0.5 * (w * b + (z * a - x * c))
            turning[n, p, 3] = 0.5 * (w * c + (x * b - y * a))


def _turn_along(rates, step, quaternions):
    for run in range(rates.shape[0]):
        w, x, y, z = 1.0, 0.0, 0.0, 0.0
        for node in range(rates.shape[1]):
            if node:
                half = step[run] / 4.0
                a = half * (rates[run, node - 1, 0] + rates[run, node, 0])
                b = half * (rates[run, node - 1, 1] + rates[run, node, 1])
                c = half * (rates[run, node - 1, 2] + rates[run, node, 2])
                angle = np.sqrt(a * a + b * b + c * c)
                share = np.sin(angle) / angle if angle > 0.0 else 1.0
                e, a, b, c = np.cos(angle), share * a, share * b, share * c
                w, x, y, z = (
                    w * e - x * a - y * b - z * c,
                    w * a + x * e + y * c - z * b,
                    w * b + y * e + z * a - x * c,
                    w * c + z * e + x * b - y * a,
                )
            of = quaternions[run, node]
            of[0], of[1], of[2], of[3] = w, x, y, z


def _turned_back(direction, matrix, components):
    for n in range(components.shape[0]):
        for p in range(components.shape[1]):
            x, y, z = direction[n, p, 0], direction[n, p, 1], direction[n, p, 2]
            for axis in range(3):
                components[n, p, axis] = (
                    x * matrix[n, p, 0, axis] + y * matrix[n, p, 1, axis] + z * matrix[n, p, 2, axis]
                )


def _orbit_torques(first, angle, attitude, inertia, constants, torque):
    gradient = constants[0]
    for n in range(torque.shape[0]):
        cosine, sine = np.cos(angle[n]), np.sin(angle[n])
        # What is up, the field and the constant torque, of local axes in those of the run's first sample.
        run = np.empty((3, 3))
        for vector in range(3):
            x = 0.0 if vector == 0 else constants[1 + 3 * vector]
            y = 0.0 if vector == 0 else constants[2 + 3 * vector]
            z = 1.0 if vector == 0 else constants[3 + 3 * vector]
            along, up = cosine * x - sine * z, sine * x + cosine * z
            for axis in range(3):
                run[vector, axis] = first[n, 0, axis] * along + first[n, 1, axis] * y + first[n, 2, axis] * up
        for p in range(torque.shape[1]):
            turned, own, of = attitude[n, p], inertia[p], torque[n, p]
            rx = run[0, 0] * turned[0, 0] + run[0, 1] * turned[1, 0] + run[0, 2] * turned[2, 0]
            ry = run[0, 0] * turned[0, 1] + run[0, 1] * turned[1, 1] + run[0, 2] * turned[2, 1]
            rz = run[0, 0] * turned[0, 2] + run[0, 1] * turned[1, 2] + run[0, 2] * turned[2, 2]
            bx = run[1, 0] * turned[0, 0] + run[1, 1] * turned[1, 0] + run[1, 2] * turned[2, 0]
            by = run[1, 0] * turned[0, 1] + run[1, 1] * turned[1, 1] + run[1, 2] * turned[2, 1]
            bz = run[1, 0] * turned[0, 2] + run[1, 1] * turned[1, 2] + run[1, 2] * turned[2, 2]
            jx = own[0, 0] * rx + own[0, 1] * ry + own[0, 2] * rz
            jy = own[1, 0] * rx + own[1, 1] * ry + own[1, 2] * rz
            jz = own[2, 0] * rx + own[2, 1] * ry + own[2, 2] * rz
            mx, my, mz = constants[1], constants[2], constants[3]
            of[0] = gradient * (ry * jz - rz * jy) + my * bz - mz * by
            of[1] = gradient * (rz * jx - rx * jz) + mz * bx - mx * bz
            of[2] = gradient * (rx * jy - ry * jx) + mx * by - my * bx
            for axis in range(3):
                of[axis] += run[2, 0] * turned[0, axis] + run[2, 1] * turned[1, axis] + run[2, 2] * turned[2, axis]


def _solve_slopes(values, slopes):
    last = values.shape[1] - 1
    above = np.empty(last + 1)
    above[0] = 2.0
    for node in range(1, last):
        above[node] = 1.0 / (4.0 - above[node - 1])
    end = 1.0 - 2.0 * above[last - 1]
    for row in range(values.shape[0]):
        of, found = values[row], slopes[row]
        for axis in range(values.shape[2]):
            found[0, axis] = (5.0 * (of[1, axis] - of[0, axis]) + (of[2, axis] - of[1, axis])) / 2.0
        for node in range(1, last):
            for axis in range(values.shape[2]):
                right = 3.0 * (of[node + 1, axis] - of[node - 1, axis])
                found[node, axis] = (right - found[node - 1, axis]) * above[node]
        for axis in range(values.shape[2]):
            right = (5.0 * (of[last, axis] - of[last - 1, axis]) + (of[last - 1, axis] - of[last - 2, axis])) / 2.0
            found[last, axis] = (right - 2.0 * found[last - 1, axis]) / end
        for node in range(last - 1, -1, -1):
            for axis in range(values.shape[2]):
                found[node, axis] -= above[node] * found[node + 1, axis]


def _between(values, rises, place, between):
    for row in range(between.shape[0]):
        for at in range(between.shape[1]):
            index = min(max(int(np.floor(place[row, at].real)), 0), values.shape[1] - 2)
            part = place[row, at] - index
            for axis in range(values.shape[2]):
                first, rise, fall = values[row, index, axis], rises[row, index, axis], rises[row, index + 1, axis]
                change = values[row, index + 1, axis] - first
                bend = 3.0 * change - 2.0 * rise - fall + part * (rise + fall - 2.0 * change)
                between[row, at, axis] = first + part * (rise + part * bend)


def _follow(begin, end, kept_share, states):
    for row in range(states.shape[0]):
        for axis in range(states.shape[2]):
            states[row, 0, axis] = begin[row, 0, axis]
        for step in range(begin.shape[1]):
            for axis in range(states.shape[2]):
                left = states[row, step, axis] - begin[row, step, axis]
                states[row, step + 1, axis] = end[row, step, axis] + kept_share[row, step] * left


def _settle(values, slopes, lag, kept_share, states):
    for row in range(values.shape[0]):
        of, turning, found, late, left = values[row], slopes[row], states[row], lag[row], kept_share[row]
        for step in range(values.shape[1] - 1):
            for axis in range(values.shape[2]):
                rise = turning[step, axis]
                change = of[step + 1, axis] - of[step, axis] - rise
                bend = turning[step + 1, axis] - rise
                cubic = bend - 2.0 * change
                square = 3.0 * change - bend - 3.0 * late * cubic
                linear = rise - 2.0 * late * square
                begin = of[step, axis] - late * linear
                if step == 0:
                    found[0, axis] = begin
                end = begin + linear + square + cubic
                found[step + 1, axis] = end + left * (found[step, axis] - begin)


def _servo_angles(command, fed_forward, load, slope, first, step, law, angles):
    bandwidth, gain, limit, bound, period = law
    for unit in range(angles.shape[1]):
        angle = commanded = first[0, unit]
        rate = motor = 0.0 * angle
        moves, pushed, rested, ramped, keeps, turned, turned_rest, turned_ramp, left = step[:, unit]
        for tick in range(angles.shape[0]):
            angles[tick, unit] = angle
            # The law of `cmg.servo_law`; limits act on real parts, so that derivatives pass there or stop.
            point = command[tick, unit] + gain * (commanded - angle)
            if abs(point.real) > limit:
                point = np.sign(point.real) * limit + 0.0 * angle
            commanded = _next_commanded(commanded, angle, bound, period * command[tick, unit])
            demand = bandwidth * point + fed_forward[tick, unit]
            push, rest, ramp = demand + load[tick, unit], motor - demand, slope[tick, unit]
            angle = angle + moves * rate + pushed * push + rested * rest + ramped * ramp
            rate = keeps * rate + turned * push + turned_rest * rest + turned_ramp * ramp
            motor = demand + left * rest


def _next_commanded(commanded, angle, bound, moved):
    # `cmg.servo_law.next_commanded_angle` but for rounding; the bound acts on real parts.
    ahead = commanded - angle
    if abs(ahead.real) > bound:
        ahead = np.sign(ahead.real) * bound + 0.0 * angle
    return angle + ahead + moved


def _set_points(command, angle, anew, law, points):
    gain, bound, period = law
    for unit in range(points.shape[1]):
        commanded = angle[0, unit]
        for tick in range(points.shape[0]):
            at = angle[tick, unit]
            if anew[tick]:
                commanded = at
            points[tick, unit] = command[tick, unit] + gain * (commanded - at)
            commanded = _next_commanded(commanded, at, bound, period * command[tick, unit])


def _change_by(by, changes, sets, added):
    for n in range(added.shape[0]):
        for q in range(sets.shape[0]):
            of, change = added[n, sets[q]], changes[n, q]
            for state in range(added.shape[2]):
                whole = 0.0
                for k in range(changes.shape[2]):
                    whole += by[n, state, k] * change[k]
                of[state] += whole


def _force(by, changes, instants, added):
    for run in range(added.shape[0]):
        for step in range(added.shape[1]):
            for row in range(added.shape[2]):
                for place in range(instants.shape[0]):
                    change = changes[run, row, 2 * step + instants[place]]
                    x, y, z = change[0], change[1], change[2]
                    if x != 0.0 or y != 0.0 or z != 0.0:
                        for state in range(added.shape[3]):
                            of = by[place, run, step, state]
                            added[run, step, row, state] += of[0] * x + of[1] * y + of[2] * z


def _drive(terms, factors, held_terms, held_factors, start, rates, step, by_momentum, by_node, changes):
    # Sets lie side by side, real and imaginary parts apart: wide instructions then do to many what they do to one.
    sets, size, last, width = start.shape[1], start.shape[2], changes.shape[1] - 1, by_momentum.shape[3]
    rate_factors, momentum_factors, numbers = _apart(factors), _apart(held_factors), np.zeros((2, size + 4, sets))
    slope, total, held = np.empty((2, size, sets)), np.empty((2, size, sets)), np.empty((2, 3, sets))
    numbers[0, 0], shares, times = 1.0, (0.0, 0.5, 0.5, 1.0), (1.0, 2.0, 2.0, 1.0)
    for run in range(changes.shape[0]):
        state, slope[:] = _apart(start[run]), 0.0
        for index in range(last + 1):
            total[:] = 0.0
            for stage in range(4 if index < last else 1):
                numbers[:, 1 : 1 + size] = state
                _add_times(shares[stage] * step[run], slope, numbers[:, 1 : 1 + size])
                _sum_terms(held_terms, momentum_factors, numbers, held)
                if stage == 0:
                    _add_turned(by_node[run, index], held[1], changes[run, index, :, width:])
                if index < last:
                    _add_turned(by_momentum[stage, run, index], held[1], changes[run, index, :, :width])
                    for axis in range(3):
                        numbers[0, 1 + size + axis] = rates[stage, run, index, axis]
                    _sum_terms(terms, rate_factors, numbers, slope)
                    _add_times(times[stage], slope, total)
            _add_times(step[run] / 6.0, total, state)


def _apart(rows):
    """Return real and imaginary parts, the columns of the rows first."""
    parts = np.empty((2, rows.shape[1], rows.shape[0]))
    parts[0], parts[1] = rows.T.real, rows.T.imag
    return parts


def _add_times(factor, added, sums):
    for part in range(sums.shape[0]):
        for row in range(sums.shape[1]):
            of, to = added[part, row], sums[part, row]
            for own in range(of.shape[0]):
                to[own] += factor * of[own]


def _sum_terms(terms, factors, numbers, sums):
    sums[:] = 0.0
    for term in range(terms.shape[0]):
        to, first, second = terms[term, 0], terms[term, 1], terms[term, 2]
        factor, factor_step, whole, part = factors[0, term], factors[1, term], sums[0, to], sums[1, to]
        x, x_step, y, y_step = numbers[0, first], numbers[1, first], numbers[0, second], numbers[1, second]
        for own in range(factor.shape[0]):
            product = x[own] * y[own]
            whole[own] += factor[own] * product
            # Products of two complex steps are far below rounding.
            part[own] += factor_step[own] * product + factor[own] * (x_step[own] * y[own] + x[own] * y_step[own])


def _add_turned(by, vectors, sums):
    for row in range(by.shape[0]):
        x, y, z = by[row, 0], by[row, 1], by[row, 2]
        for own in range(vectors.shape[1]):
            sums[own, row] += x * vectors[0, own] + y * vectors[1, own] + z * vectors[2, own]


def _force_by_inertia(by, rates, inertia_step, instants, added):
    for run in range(added.shape[0]):
        for step in range(added.shape[1]):
            for row in range(added.shape[2]):
                for place in range(instants.shape[0]):
                    change = inertia_step[run, row, 2 * step + instants[place]]
                    rate = rates[place, run, step]
                    x = change[0, 0] * rate[0] + change[0, 1] * rate[1] + change[0, 2] * rate[2]
                    y = change[1, 0] * rate[0] + change[1, 1] * rate[1] + change[1, 2] * rate[2]
                    z = change[2, 0] * rate[0] + change[2, 1] * rate[1] + change[2, 2] * rate[2]
                    if x != 0.0 or y != 0.0 or z != 0.0:
                        for state in range(added.shape[3]):
                            of = by[place, run, step, state]
                            added[run, step, row, state] += of[0] * x + of[1] * y + of[2] * z


def _answer(by_torque, tangents, by_state, knots, axes, apart, rates):
    steps, size = tangents.shape[1], tangents.shape[2]
    state, after = np.empty(size), np.empty(size)
    for run in range(rates.shape[0]):
        for row in range(rates.shape[1]):
            knot, axis = knots[row], axes[row]
            state[:] = 0.0
            for step in range(max(int((knot - 1) * apart[0] / 2.0) - 1, 0), steps):
                by = tangents[run, step]
                for one in range(size):
                    after[one] = 0.0
                    for before in range(size):
                        after[one] += state[before] * by[before, one]
                for place in range(4):
                    weight = 1.0 - abs((2 * step + (place + 1) // 2) / apart[0] - knot)
                    if weight > 0.0:
                        for one in range(size):
                            after[one] += weight * by_torque[place, run, step, one, axis]
                for one in range(size):
                    state[one] = after[one]
                of, rate = by_state[run, step + 1], rates[run, row, step + 1]
                for one in range(3):
                    for before in range(size):
                        rate[one] += of[one, before] * state[before]


def _carry(tangents, changes):
    for run in range(changes.shape[0]):
        for step in range(tangents.shape[1]):
            for row in range(changes.shape[2]):
                for state in range(changes.shape[3]):
                    for before in range(changes.shape[3]):
                        changes[run, step + 1, row, state] += (
                            changes[run, step, row, before] * tangents[run, step, before, state]
                        )
