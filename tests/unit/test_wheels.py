"""Reaction wheels: arrays, the momentum envelope, and allocations held against a linear program."""

from __future__ import annotations

from math import acos, radians, sqrt

import numpy as np
import pytest
from scipy.optimize import linprog

from testbed.cmg.singularity import sphere_directions
from testbed.cmg.wheels import (
    Wheels,
    least_norm_allocation,
    minimax_allocation,
    momentum_envelope,
    wheel_axes,
    wheel_envelope_share,
    wheel_momentum,
    wheel_null_space,
)

ARRAYS = {
    "orthogonal": wheel_axes("orthogonal", 3, 0.0),
    "tetrahedron": wheel_axes("tetrahedron", 4, 0.0),
    "pyramid": wheel_axes("pyramid", 4, radians(54.74)),
    "six on a cone": wheel_axes("pyramid", 6, radians(40.0)),
    "three in a plane and one": np.array([[1.0, 0, 0], [0, 1.0, 0], [sqrt(0.5), sqrt(0.5), 0], [0, 0, 1.0]]),
    "any": np.array([[1.0, 0, 0], [0.6, 0.8, 0], [0, 0.6, -0.8], [0.48, 0.6, 0.64], [0, 0, 1.0]]),
}


@pytest.fixture(params=ARRAYS.values(), ids=ARRAYS)
def wheels(request) -> Wheels:
    count = len(request.param)
    limit = 0.01 * (1.0 + 0.2 * np.arange(count))
    return Wheels(axis_B=request.param, spin_inertia=np.full(count, 1e-5), momentum_limit=limit, torque_limit=limit)


def largest_share(wheels: Wheels, vector) -> float:
    """Least share of its limit of the most loaded wheel, by a linear program of x and the share."""
    count = len(wheels.axis_B)
    above = np.hstack([np.eye(count), -wheels.momentum_limit[:, None]])
    below = np.hstack([-np.eye(count), -wheels.momentum_limit[:, None]])
    solved = linprog(
        [0.0] * count + [1.0],
        A_ub=np.vstack([above, below]),
        b_ub=np.zeros(2 * count),
        A_eq=np.hstack([wheels.axis_B.T, np.zeros((3, 1))]),
        b_eq=vector,
        bounds=[(None, None)] * count + [(0.0, None)],
    )
    return float(solved.fun)


def vectors(count=40):
    return 0.01 * np.random.default_rng(3).standard_normal((count, 3))


def test_axes_are_unit_vectors_and_span_space(wheels):
    np.testing.assert_allclose(np.linalg.norm(wheels.axis_B, axis=1), 1.0, atol=1e-12)
    assert np.linalg.matrix_rank(wheels.axis_B) == 3


def test_a_tetrahedron_has_equal_angles():
    axes = wheel_axes("tetrahedron", 4, 0.0)
    angles = (axes @ axes.T)[np.triu_indices(4, 1)]
    np.testing.assert_allclose(angles, -1.0 / 3.0, atol=1e-12)
    assert acos(angles[0]) == pytest.approx(radians(109.4712206), abs=1e-9)


@pytest.mark.parametrize("allocation", ["least norm", "minimax"])
def test_shares_add_up_to_what_was_asked_for(wheels, allocation):
    asked = vectors()
    shares = least_norm_allocation(wheels, asked)
    if allocation == "minimax":
        shares = minimax_allocation(wheels, asked, wheels.momentum_limit)
    np.testing.assert_allclose(wheel_momentum(wheels, shares), asked, atol=1e-15)


def test_the_largest_share_is_the_linear_programs(wheels):
    asked = vectors()
    shares = minimax_allocation(wheels, asked, wheels.momentum_limit) / wheels.momentum_limit
    expected = [largest_share(wheels, vector) for vector in asked]
    np.testing.assert_allclose(np.abs(shares).max(axis=1), expected, rtol=1e-9)
    np.testing.assert_allclose(wheel_envelope_share(wheels, asked), expected, rtol=1e-9)


def test_least_norm_has_no_part_in_the_null_space(wheels):
    none = wheel_null_space(wheels)
    assert none.shape == (len(wheels.axis_B), len(wheels.axis_B) - 3)
    np.testing.assert_allclose(least_norm_allocation(wheels, vectors()) @ none, 0.0, atol=1e-15)
    np.testing.assert_allclose(none.T @ wheels.axis_B, 0.0, atol=1e-12)


def test_no_momenta_within_their_limits_leave_the_envelope(wheels):
    rng = np.random.default_rng(4)
    momenta = wheels.momentum_limit * rng.uniform(-1.0, 1.0, (500, len(wheels.axis_B)))
    held = wheel_momentum(wheels, momenta)
    directions = sphere_directions(200)
    assert (held @ directions.T <= momentum_envelope(wheels, directions) + 1e-15).all()
    assert wheel_envelope_share(wheels, held).max() <= 1.0 + 1e-12


def test_allocation_is_the_same_for_a_vector_alone(wheels):
    asked = vectors(5)
    together = minimax_allocation(wheels, asked, wheels.momentum_limit)
    np.testing.assert_array_equal(minimax_allocation(wheels, asked[2], wheels.momentum_limit), together[2])
