"""Cluster momentum, Jacobian, envelope and null space, against MuJoCo and against what they must be."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from support.platforms import ROTOR_MOMENTUM, shipped
from testbed.cmg.cluster import cluster_momentum, inertia_change, momentum_jacobian, spin_momentum_and_jacobian
from testbed.cmg.singularity import (
    envelope_fraction,
    envelope_radius,
    null_space,
    singularity_measure,
    sphere_directions,
)
from testbed.plant.geometry import cluster_of, composite_inertia, total_momentum
from testbed.plant.layout import layout_of

MODEL = shipped()
CLUSTER = cluster_of(MODEL)
ANGLE = np.array([0.3, -1.1, 2.0, 0.7, -2.9, 1.4])


def momentum_of_mujoco(angle, rate=None):
    """MuJoCo's own angular momentum of the platform, bus at rest and aligned with N."""
    layout = layout_of(MODEL)
    qpos, qvel = np.zeros(MODEL.nq), np.zeros(MODEL.nv)
    qpos[layout.attitude] = [1.0, 0.0, 0.0, 0.0]
    qpos[layout.gimbal_angle] = angle
    qvel[layout.rotor_speed] = CLUSTER.rotor_momentum / CLUSTER.rotor_spin_inertia
    qvel[layout.gimbal_rate] = 0.0 if rate is None else rate
    return total_momentum(MODEL, qpos[None], qvel[None])[0]


def test_momentum_equals_mujocos():
    rate = np.array([1.0, -0.5, 0.3, 1.9, -1.2, 0.4])
    np.testing.assert_allclose(cluster_momentum(CLUSTER, ANGLE, rate), momentum_of_mujoco(ANGLE, rate), atol=1e-16)


def test_jacobian_equals_finite_differences_of_mujocos_momentum():
    step = 1e-5
    numeric = np.empty((3, 6))
    for unit in range(6):
        ahead, behind = ANGLE.copy(), ANGLE.copy()
        ahead[unit] += step
        behind[unit] -= step
        numeric[:, unit] = (momentum_of_mujoco(ahead) - momentum_of_mujoco(behind)) / (2.0 * step)
    # The truncation error is h0 step²/6 = 8e-14; rounding 1e-18 / step = 1e-13.
    np.testing.assert_allclose(momentum_jacobian(CLUSTER, ANGLE), numeric, atol=1e-12)


def test_inertia_change_equals_mujocos_composite():
    data = mujoco.MjData(MODEL)
    data.qpos[layout_of(MODEL).gimbal_angle] = ANGLE
    mujoco.mj_forward(MODEL, data)
    mass_matrix = np.zeros((MODEL.nv, MODEL.nv))
    mujoco.mj_fullM(MODEL, data, mass_matrix)
    np.testing.assert_allclose(
        composite_inertia(MODEL) + inertia_change(CLUSTER, ANGLE), mass_matrix[3:6, 3:6], atol=1e-16
    )


def test_the_pair_is_momentum_and_jacobian():
    momentum_B, jacobian = spin_momentum_and_jacobian(CLUSTER, ANGLE)
    np.testing.assert_allclose(momentum_B, cluster_momentum(CLUSTER, ANGLE, np.zeros(6)), atol=1e-18)
    np.testing.assert_allclose(jacobian, momentum_jacobian(CLUSTER, ANGLE), atol=1e-18)


def test_functions_broadcast_over_leading_axes():
    angles = np.random.default_rng(1).uniform(-3.0, 3.0, (4, 5, 6))
    stacked = momentum_jacobian(CLUSTER, angles)
    assert stacked.shape == (4, 5, 3, 6)
    np.testing.assert_array_equal(stacked[2, 3], momentum_jacobian(CLUSTER, angles[2, 3]))
    np.testing.assert_allclose(inertia_change(CLUSTER, angles)[1, 1], inertia_change(CLUSTER, angles[1, 1]), atol=1e-20)


def test_all_gimbals_at_zero_carry_no_momentum():
    assert np.abs(cluster_momentum(CLUSTER, np.zeros(6), np.zeros(6))).max() < 1e-17


def test_envelope_along_the_axes_is_the_papers():
    """0.0254 N·m·s along z and 0.0210 along x, eq. (31), from which the skew angle was inferred."""
    along_x, along_z = envelope_radius(CLUSTER, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    assert along_z == pytest.approx(0.0254, abs=2e-6)
    assert along_x == pytest.approx(0.0210, abs=1e-4)


def test_no_gimbal_angles_leave_the_envelope_and_some_reach_it():
    directions = sphere_directions(200)
    angles = np.random.default_rng(2).uniform(-np.pi, np.pi, (2000, 6))
    momentum_B = cluster_momentum(CLUSTER, angles, np.zeros(6))
    assert envelope_fraction(CLUSTER, momentum_B, directions).max() <= 1.0
    direction = directions[17]
    best = np.arctan2(CLUSTER.transverse_axis_B @ direction, CLUSTER.spin_axis_B @ direction)
    reached = cluster_momentum(CLUSTER, best, np.zeros(6)) @ direction
    assert reached == pytest.approx(float(envelope_radius(CLUSTER, direction)), rel=1e-12)
    saturated = momentum_jacobian(CLUSTER, best)
    assert singularity_measure(saturated, CLUSTER.rotor_momentum) < 1e-9, "the envelope is a singular surface"


def test_null_space_gives_no_torque():
    basis = null_space(CLUSTER, ANGLE)
    assert basis.shape == (6, 3)
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(momentum_jacobian(CLUSTER, ANGLE) @ basis, 0.0, atol=1e-17)


def test_singularity_measure_is_at_most_one():
    angles = np.random.default_rng(3).uniform(-np.pi, np.pi, (5000, 6))
    measure = singularity_measure(momentum_jacobian(CLUSTER, angles), CLUSTER.rotor_momentum)
    assert 0.9 < measure.max() <= 1.0
    assert measure.min() >= 0.0


def test_sphere_directions_are_unit_and_balanced():
    directions = sphere_directions(400)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(directions.T @ directions / 400, np.eye(3) / 3, atol=2e-3)


def test_rotor_momentum_is_nominal():
    np.testing.assert_allclose(CLUSTER.rotor_momentum, ROTOR_MOMENTUM, rtol=1e-12)
