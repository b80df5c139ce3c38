"""What must hold for every spline, every motion and every platform."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from support.maneuvers import CLUSTER, INERTIA
from testbed.cmg.cluster import platform_momentum
from testbed.maneuver.gimbal_maneuver import body_rate_of
from testbed.maneuver.information import filtered_regressor, information_of, sampled_filter
from testbed.maneuver.splines import basis_matrix, clamped_spline, derivative_points_matrix

DURATION = 5.0
TIME = np.linspace(0.0, DURATION, 301)
SAMPLING = sampled_filter(DURATION, 16.0, 0.8)
BASIS = basis_matrix(DURATION, 12, SAMPLING.fine_time)
POINTS = st.integers(5, 24).flatmap(lambda count: arrays(np.float64, (count, 2), elements=st.floats(-1.0, 1.0)))
SEEDS = st.integers(0, 2**32 - 1)
CUBE = [
    np.diag(signs)[list(order)]
    for order in itertools.permutations(range(3))
    for signs in itertools.product((1.0, -1.0), repeat=3)
    if np.linalg.det(np.diag(signs)[list(order)]) > 0.0
]
"""The 24 rotations of a cube."""


def matrix_of(body_rate):
    regressor = filtered_regressor(SAMPLING, body_rate)
    return regressor.T @ regressor


def random_motion(seed):
    return BASIS @ np.random.default_rng(seed).uniform(-0.3, 0.3, (12, 3))


@given(points=POINTS, derivative=st.integers(0, 2))
@settings(deadline=None)
def test_a_spline_and_its_derivatives_stay_in_their_hulls(points, derivative):
    curve = clamped_spline(DURATION, points)(TIME, nu=derivative)
    hull = derivative_points_matrix(DURATION, len(points), derivative) @ points if derivative else points
    slack = 1e-9 * max(1.0, np.abs(hull).max())
    assert np.all(curve <= hull.max(axis=0) + slack)
    assert np.all(curve >= hull.min(axis=0) - slack)


@given(points=POINTS)
@settings(deadline=None)
def test_a_clamped_spline_meets_its_end_points(points):
    spline = clamped_spline(DURATION, points)
    np.testing.assert_allclose(spline(0.0), points[0], atol=1e-15)
    np.testing.assert_allclose(spline(DURATION), points[-1], atol=1e-15)


@given(seed=SEEDS, turn=st.sampled_from(CUBE))
@settings(deadline=None, max_examples=50)
def test_relabelling_the_axes_changes_no_figure(seed, turn):
    """A turn by quarter circles permutes θ and flips signs, which no figure of the information sees."""
    body_rate = random_motion(seed)
    found, turned = (information_of(matrix_of(motion)) for motion in (body_rate, body_rate @ turn.T))
    assert turned.min_eigenvalue == pytest.approx(found.min_eigenvalue, rel=1e-6)
    assert turned.trace_inverse == pytest.approx(found.trace_inverse, rel=1e-6)
    assert turned.determinant == pytest.approx(found.determinant, rel=1e-6)
    assert turned.condition_number == pytest.approx(found.condition_number, rel=1e-6)


@given(seed=SEEDS, weights=arrays(np.float64, 6, elements=st.floats(-1.0, 1.0)))
@settings(deadline=None, max_examples=50)
def test_information_is_never_negative(seed, weights):
    matrix = matrix_of(random_motion(seed))
    assert weights @ matrix @ weights >= -1e-12 * np.trace(matrix)


@given(seed=SEEDS)
@settings(deadline=None, max_examples=30)
def test_a_longer_flight_tells_more(seed):
    """Every sample adds to the information; no eigenvalue may fall."""
    regressor = filtered_regressor(SAMPLING, random_motion(seed))
    half = len(regressor) // 6 * 3
    shorter, longer = (np.linalg.eigvalsh(rows.T @ rows) for rows in (regressor[:half], regressor))
    assert np.all(longer >= shorter - 1e-12 * longer[-1])


@given(seed=SEEDS)
@settings(deadline=None, max_examples=15)
def test_whatever_the_gimbals_do_the_momentum_keeps_its_length(seed):
    rng = np.random.default_rng(seed)
    angle = clamped_spline(DURATION, rng.uniform(-2.0, 2.0, (8, 6)))
    total = rng.uniform(-0.01, 0.01, 3)
    body_rate = body_rate_of(angle, TIME, inertia=INERTIA, cluster=CLUSTER, total_momentum_B=total)
    momentum = platform_momentum(CLUSTER, INERTIA, body_rate, angle(TIME), angle(TIME, nu=1))
    np.testing.assert_allclose(np.linalg.norm(momentum, axis=1), np.linalg.norm(total), rtol=1e-7)
