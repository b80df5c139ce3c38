"""Arrays of reaction wheels: geometry, momentum, and which wheel gives what share of a momentum or a torque.

A wheel holds h = Jw Ω a along its axis a, Ω its speed relative to the body; it has no gimbal, so that J never changes.
All functions broadcast over leading axes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import cos, sin, sqrt
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array, Axes, Series, Units, UnitSeries, Vectors3
from testbed.cmg.arrays import azimuths

WheelArrayKind: TypeAlias = Literal["orthogonal", "tetrahedron", "pyramid"]
_PARALLEL = 1e-9
"""Length of the cross product of two unit axes below which they count as parallel, and span no facet."""


@dataclass(frozen=True, kw_only=True)
class Wheels:
    """W reaction wheels.

    Attributes:
        axis_B: a, shape (W, 3), unit vectors, body axes.
        spin_inertia: Jw, shape (W,), kg·m², about the axis.
        momentum_limit: largest |Jw Ω|, shape (W,), N·m·s.
        torque_limit: of each motor, shape (W,), N·m.
        position_B: of each rotor from the platform's centre of mass, shape (W, 3), m, body axes; None where that is not
            known.
    """

    axis_B: Axes
    spin_inertia: Units
    momentum_limit: Units
    torque_limit: Units
    position_B: Axes | None = None

    @cached_property
    def facet_normals_B(self) -> Vectors3:
        """Normals of the momentum envelope's facets, shape (F, 3), unit vectors, each facet and its opposite once.

        The envelope is a zonotope: every facet is spanned by two axes, or more that lie in their plane.
        """
        normals = [np.cross(first, second) for first, second in combinations(self.axis_B, 2)]
        return np.array([normal / np.linalg.norm(normal) for normal in normals if np.linalg.norm(normal) > _PARALLEL])


def wheel_axes(kind: WheelArrayKind, wheels: int, skew: float) -> Axes:
    """Return the axes of a usual array, shape (W, 3), unit vectors, body axes.

    Args:
        kind: orthogonal: three along body x, y, z; tetrahedron: four that point to its corners, one along z; pyramid:
            on a cone about z.
        wheels: W; of a pyramid.
        skew: angle between body z and every axis, rad; of a pyramid.

    Source: Markley and Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, ch. 7.5.
    """
    return _ARRAYS[kind](wheels, skew)


def turned_wheel_axes(axis_B: Axes, turns: Array) -> Axes:
    """Return axes (a + v × a) / |a + v × a| with v = α e1 + β e2, shape (W, 3), unit vectors, body axes.

    e1 is normal to a and to body z, or body x for an axis along z, and e2 = a × e1. Analytic in the turns.

    Args:
        axis_B: a as drawn, shape (W, 3), unit vectors, body axes.
        turns: α and β, shape (..., W, 2), rad; small.
    """
    first, second = wheel_turning_directions(axis_B)
    turned = axis_B + turns[..., :1] * first + turns[..., 1:] * second
    return np.asarray(turned / np.sqrt(1.0 + (turns**2).sum(axis=-1, keepdims=True)))


def wheel_turning_directions(axis_B: Axes) -> Array:
    """Return where an axis moves as it turns: e1 × a = -e2 and e2 × a = e1 of `turned_wheel_axes`, shape (2, W, 3)."""
    across = np.cross([0.0, 0.0, 1.0], axis_B)
    along_z = np.linalg.norm(across, axis=1, keepdims=True) < _PARALLEL
    first = np.where(along_z, [1.0, 0.0, 0.0], across)
    first = first / np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([-np.cross(axis_B, first), first])


def wheel_momentum(wheels: Wheels, momentum: UnitSeries) -> Vectors3:
    """Return h = Σ (Jw Ω)_i a_i, shape (..., 3), N·m·s, body axes, of each wheel's Jw Ω, shape (..., W), N·m·s."""
    return np.asarray(np.vecmat(momentum, wheels.axis_B))


def momentum_envelope(wheels: Wheels, direction_B: Vectors3) -> Series:
    """Return the support Σ limit_i |u·a_i| of the momentum envelope along u, shape (...,), N·m·s.

    Args:
        wheels: the array.
        direction_B: u, shape (..., 3), unit vectors, body axes.
    """
    return np.asarray(np.abs(np.asarray(direction_B) @ wheels.axis_B.T) @ wheels.momentum_limit)


def wheel_envelope_share(wheels: Wheels, momentum_B: Vectors3) -> Series:
    """Return the share of the momentum envelope that h uses, shape (...,): 1 on its surface, exactly.

    It is the least share of their limits that the most loaded wheel can have.

    Args:
        wheels: the array; its axes span all three directions.
        momentum_B: h, shape (..., 3), N·m·s, body axes.
    """
    return np.asarray(_facet_shares(wheels.axis_B, wheels.momentum_limit, wheels.facet_normals_B, momentum_B).max(-1))


def least_norm_allocation(wheels: Wheels, vector_B: Vectors3) -> UnitSeries:
    """Return the wheels' shares of a momentum or torque with the least sum of squares, shape (..., W): W⁺ v."""
    return np.asarray(np.vecmat(np.asarray(vector_B), np.linalg.pinv(wheels.axis_B)))


def minimax_allocation(wheels: Wheels, vector_B: Vectors3, limit: Units) -> UnitSeries:
    """Return the wheels' shares of a momentum or torque, the largest share of a limit as small as can be.

    The vector points to a facet of the envelope: every wheel that does not span it is at the same share of its limit,
    with the sign of its projection on the facet's normal; those that span it share the rest, in the same way.

    Args:
        wheels: the array; its axes span all three directions.
        vector_B: v, shape (..., 3), body axes.
        limit: of each wheel, shape (W,), in the vector's unit.

    Returns:
        Shares, shape (..., W), in the vector's unit; their sum along the axes is v.

    Source: Markley, Reynolds, Liu and Lebsock, "Maximum torque and momentum envelopes for reaction-wheel arrays",
    J. Guidance, Control, and Dynamics 33 (2010).
    """
    vectors = np.asarray(vector_B, dtype=np.float64)
    allocated = _allocated(wheels.axis_B, limit, wheels.facet_normals_B, vectors.reshape(-1, 3))
    return allocated.reshape(*vectors.shape[:-1], -1)


def no_wheels() -> Wheels:
    """Return an array without wheels."""
    none = np.zeros(0)
    return Wheels(axis_B=np.zeros((0, 3)), spin_inertia=none, momentum_limit=none, torque_limit=none)


def wheel_null_space(wheels: Wheels) -> Array:
    """Return an orthonormal basis of the wheel momenta that add up to none, shape (W, W - 3)."""
    return np.asarray(np.linalg.svd(wheels.axis_B.T)[2][3:].T)


def _facet_shares(axis_B: Axes, limit: Units, normals_B: Vectors3, vector_B: Vectors3) -> Array:
    """Return |u·v| / support(u) for the normal u of every facet, shape (..., F)."""
    support = np.abs(normals_B @ axis_B.T) @ limit
    # vecmat: a product of many rows would round one by how many there are.
    return np.asarray(np.abs(np.vecmat(vector_B, normals_B.T)) / support)


def _allocated(axis_B: Axes, limit: Units, normals_B: Vectors3, vector_B: Vectors3) -> UnitSeries:
    """Return minimax allocations, shape (N, W), of vectors in the span of the axes: space, a plane or a line."""
    if not len(normals_B):  # a line: all share alike
        return np.asarray(np.vecmat(vector_B, (axis_B * (limit / limit.sum())[:, None]).T))
    shares = _facet_shares(axis_B, limit, normals_B, vector_B)
    facets = shares.argmax(axis=1)
    allocated = np.empty((len(vector_B), len(axis_B)))
    for facet in np.unique(facets):
        rows, normal_B = facets == facet, normals_B[facet]
        along = axis_B @ normal_B
        within = np.abs(along) < _PARALLEL
        signs = np.sign(np.vecdot(vector_B[rows], normal_B))[:, None] * np.sign(along)
        part = shares[rows, facet, None] * signs * limit
        rest = vector_B[rows] - np.vecmat(np.where(within, 0.0, part), axis_B)
        part[:, within] = _allocated(axis_B[within], limit[within], _edges_B(axis_B[within], normal_B), rest)
        allocated[rows] = part
    return allocated


def _edges_B(axis_B: Axes, normal_B: Array) -> Vectors3:
    """Return normals, within their plane, of the edges that axes span there, shape (E, 3); none of axes in a line."""
    edges = np.cross(normal_B, axis_B)
    in_line = np.linalg.norm(np.cross(axis_B, axis_B[0]), axis=1).max() < _PARALLEL
    return edges[:0] if in_line else edges


def _orthogonal(_: int, __: float) -> Axes:
    return np.eye(3)


def _tetrahedron(_: int, __: float) -> Axes:
    return np.vstack([[0.0, 0.0, 1.0], _cone(3, -1.0 / 3.0, 2.0 * sqrt(2.0) / 3.0)])


def _pyramid(wheels: int, skew: float) -> Axes:
    return _cone(wheels, cos(skew), sin(skew))


def _cone(wheels: int, along: float, across: float) -> Axes:
    azimuth = np.radians(azimuths(wheels))
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.full(wheels, along)], axis=1)


_ARRAYS: Mapping[WheelArrayKind, Callable[[int, float], Axes]] = {
    "orthogonal": _orthogonal,
    "tetrahedron": _tetrahedron,
    "pyramid": _pyramid,
}
