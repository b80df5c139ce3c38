"""Gimbal-space designs, checked by numpy alone on a grid ten times finer than the design's."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from support.maneuvers import CLUSTER, INERTIA, TORQUE_LIMIT, design_problem, gimbal_limits, without_units
from testbed.cmg.cluster import cluster_momentum, momentum_jacobian, platform_momentum, spin_axes, transverse_axes
from testbed.cmg.singularity import envelope_fraction, singularity_measure, sphere_directions
from testbed.errors import InfeasibleDesignError
from testbed.maneuver.design import Search
from testbed.maneuver.gimbal_design import _held_points, gimbal_design
from testbed.maneuver.gimbal_limits import hull_limits
from testbed.maneuver.gimbal_maneuver import body_rate_of

FINE = np.linspace(0.0, 5.0, 1601)  # the design's own grid has 161 instants
BETWEEN = 1.02
"""Limits without a convex hull are kept at 12 instants a second; in between they bend by up to 2 %."""


def designed(criterion="D", limits=None, starts=1, **changes):
    limits = gimbal_limits() if limits is None else limits
    return gimbal_design(design_problem(criterion, **changes), limits, Search(starts=starts, seed=2))


@pytest.fixture(scope="module")
def design():
    return designed(starts=2)


def test_gimbals_start_as_given_and_rest_at_both_ends(design):
    reference = design.maneuver.reference(FINE)
    np.testing.assert_array_equal(reference.gimbal_angle[0], 0.0)
    np.testing.assert_allclose(reference.gimbal_rate[[0, -1]], 0.0, atol=1e-12)
    np.testing.assert_allclose(reference.body_rate[[0, -1]], 0.0, atol=1e-7)


def test_hull_limits_are_kept_everywhere(design):
    angle = design.maneuver.gimbal_angle
    assert np.abs(angle(FINE, nu=1)).max() <= 1.9 * (1 + 1e-6)
    assert np.abs(angle(FINE, nu=2)).max() <= 10.0 * (1 + 1e-6)
    assert np.abs(angle(FINE, nu=1)).max() > 0.97 * 1.9  # the limit is used


def test_the_cluster_keeps_its_limits(design):
    reference = design.maneuver.reference(FINE)
    jacobian = momentum_jacobian(CLUSTER, reference.gimbal_angle)
    momentum = cluster_momentum(CLUSTER, reference.gimbal_angle, reference.gimbal_rate)
    acceleration = design.maneuver.gimbal_angle(FINE, nu=2)
    torque = (jacobian @ reference.gimbal_rate[..., None])[..., 0]
    torque += (CLUSTER.gimbal_axis_inertia * acceleration) @ CLUSTER.gimbal_axis_B
    assert np.all(np.abs(torque) <= BETWEEN * TORQUE_LIMIT)
    assert envelope_fraction(CLUSTER, momentum, sphere_directions(2000)).max() <= BETWEEN * 0.95
    assert singularity_measure(jacobian, CLUSTER.rotor_momentum).min() >= 0.3 / 1.1  # a narrow dip between instants


def test_gimbal_motors_are_strong_enough(design):
    reference = design.maneuver.reference(FINE)
    spin, transverse = (axes(CLUSTER, reference.gimbal_angle) for axes in (spin_axes, transverse_axes))
    rate, turning = reference.body_rate, design.maneuver.gimbal_angle(FINE, nu=2)
    turning = turning + reference.body_acceleration @ CLUSTER.gimbal_axis_B.T
    asymmetry = CLUSTER.rotor_spin_inertia - CLUSTER.rotor_transverse_inertia
    carried = CLUSTER.rotor_momentum + asymmetry * np.einsum("nmi,ni->nm", spin, rate)
    torque = CLUSTER.gimbal_axis_inertia * turning - carried * np.einsum("nmi,ni->nm", transverse, rate)
    assert np.abs(torque).max() <= 0.015


def test_the_spline_follows_the_exact_body_rate(design):
    odd = np.sort(np.random.default_rng(0).uniform(0.0, 5.0, 2000))
    exact = body_rate_of(
        design.maneuver.gimbal_angle, odd, inertia=INERTIA, cluster=CLUSTER, total_momentum_B=np.zeros(3)
    )
    np.testing.assert_allclose(design.maneuver.body_rate(odd), exact, atol=1e-7)


def test_momentum_stays_zero(design):
    assert np.abs(total_momentum(design.maneuver)).max() < 3e-9  # 1e-7 rad/s of the spline times 0.027 kg·m²


def total_momentum(maneuver):
    reference = maneuver.reference(FINE)
    return platform_momentum(CLUSTER, INERTIA, reference.body_rate, reference.gimbal_angle, reference.gimbal_rate)


def test_a_bias_momentum_is_conserved_in_inertial_axes():
    """Attitude from the designed rate by rotation vectors: what the design did without."""
    initial = np.array([0.18, -0.12, 0.21])
    design = designed(initial_body_rate=initial)
    np.testing.assert_allclose(design.maneuver.body_rate(0.0), initial, atol=1e-12)
    np.testing.assert_allclose(design.maneuver.body_rate(5.0), 0.0, atol=1e-6)
    total_B = total_momentum(design.maneuver)
    attitude, step = Rotation.identity(), FINE[1]
    turned = [total_B[0]]
    for middle, total in zip(FINE[:-1] + step / 2, total_B[1:], strict=True):
        attitude = attitude * Rotation.from_rotvec(step * design.maneuver.body_rate(middle))
        turned.append(attitude.apply(total))
    # The midpoint rule leaves 5 s · (3e-3 s)²/24 · |ω × ω̇|, 3e-6 of the momentum of 0.007 N·m·s.
    np.testing.assert_allclose(turned, np.tile(total_B[0], (len(FINE), 1)), atol=1e-7)


def test_failed_units_stay_where_they_are():
    home = np.array([0.0, -0.2835297, -0.7814272, 0.0, 0.7814272, 0.2835297])  # carries no momentum without unit 1
    limits = gimbal_limits(min_singularity_measure=0.2)
    design = designed(limits=limits, starts=2, cluster=without_units(0), initial_gimbal_angle=home)
    reference = design.maneuver.reference(FINE)
    np.testing.assert_array_equal(reference.gimbal_angle[:, 0], 0.0)
    np.testing.assert_allclose(reference.gimbal_angle[0], home, atol=1e-15)
    assert np.abs(reference.gimbal_rate[:, 1:]).max(axis=0).min() > 0.5  # the other five all work


QUICK = {"control_points": 9, "sample_rate": 8.0}


@pytest.mark.parametrize("criterion", ["A", "E", "condition"])
def test_every_criterion_improves_on_the_d_design_in_its_own_figure(criterion):
    found, reference = designed(criterion, **QUICK).information, designed("D", **QUICK).information
    figures = {"A": "trace_inverse", "E": "min_eigenvalue", "condition": "condition_number"}
    better = getattr(found, figures[criterion]) / getattr(reference, figures[criterion])
    assert better > 1.0 if criterion == "E" else better < 1.0


def test_the_same_seed_gives_the_same_design(design):
    np.testing.assert_array_equal(designed(starts=2).maneuver.gimbal_angle.c, design.maneuver.gimbal_angle.c)


def test_limits_that_conflict_are_named():
    with pytest.raises(InfeasibleDesignError, match=r"singularity measure, squared, by 0\.\d+ of its limit"):
        designed(limits=gimbal_limits(min_singularity_measure=0.9), **QUICK)


def test_the_body_rate_can_be_limited_too():
    design = designed(limits=gimbal_limits(body_rate=0.3))
    assert np.abs(design.maneuver.body_rate(FINE)).max() <= BETWEEN * 0.3


def test_limits_of_a_rate_depend_on_two_neighbouring_points_of_one_gimbal():
    """Dense matrices of zeros made the Jacobian of a long maneuver four times as slow."""
    problem, points = design_problem(), _held_points(design_problem())
    rate, acceleration = (
        ca.jacobian_sparsity(limit.expression, points.free)
        for limit in hull_limits(problem, gimbal_limits(), points.rows)
    )
    assert rate.nnz() <= 2 * rate.size1()
    assert acceleration.nnz() <= 3 * acceleration.size1()
