"""Units turned out of their places, in the equations and in MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from support.platforms import shipped
from testbed.cmg.cluster import cluster_momentum
from testbed.cmg.misalignment import misaligned, turning_axes
from testbed.plant.build import build
from testbed.plant.geometry import cluster_of, composite_inertia, total_momentum
from testbed.plant.layout import layout_of
from testbed.plant.properties import PlatformProperties

CLUSTER = cluster_of(shipped())
MISALIGNMENT = np.random.default_rng(3).normal(0.0, 0.3, (6, 2))
"""rad; twenty times what is real, so that a wrong order of turns shows."""


def frames(cluster):
    return np.stack([cluster.spin_axis_B, cluster.transverse_axis_B, cluster.gimbal_axis_B], axis=2)


def test_a_unit_is_turned_about_its_own_spin_axis_and_then_about_its_transverse_axis():
    expected = frames(CLUSTER) @ Rotation.from_euler("XY", MISALIGNMENT).as_matrix()
    np.testing.assert_allclose(frames(misaligned(CLUSTER, MISALIGNMENT)), expected, atol=1e-15)


@pytest.mark.parametrize("angle", [0, 1])
def test_the_turning_axes_are_the_rates_of_change(angle):
    step = np.zeros((6, 2))
    step[:, angle] = 1e-6
    ahead, behind = (frames(misaligned(CLUSTER, MISALIGNMENT + sign * step)) for sign in (1.0, -1.0))
    axis = turning_axes(CLUSTER, MISALIGNMENT)[angle]
    turning = np.cross(axis[:, :, None], frames(misaligned(CLUSTER, MISALIGNMENT)), axis=1)
    np.testing.assert_allclose(turning, (ahead - behind) / 2e-6, atol=1e-9)  # rounding, 1e-16 / 1e-6


def test_the_compiled_platform_has_the_same_axes_and_keeps_its_inertia():
    inertia = composite_inertia(shipped())
    model = build(PlatformProperties(misalignment=MISALIGNMENT, inertia=inertia))
    np.testing.assert_allclose(frames(cluster_of(model)), frames(misaligned(CLUSTER, MISALIGNMENT)), atol=1e-12)
    np.testing.assert_allclose(composite_inertia(model), inertia, atol=1e-12)


def test_mujocos_own_momentum_is_the_turned_clusters():
    """An authority that knows nothing of the formula: MuJoCo's sum over all bodies, bus at rest, gimbals moving."""
    rng = np.random.default_rng(4)
    model = build(PlatformProperties(misalignment=MISALIGNMENT))
    layout = layout_of(model)
    angle, rate, speed = rng.normal(0.0, 1.0, 6), rng.normal(0.0, 1.0, 6), rng.normal(470.0, 20.0, 6)
    qpos, qvel = np.zeros((1, model.nq)), np.zeros((1, model.nv))
    qpos[:, layout.attitude] = [1.0, 0.0, 0.0, 0.0]
    qpos[:, layout.gimbal_angle], qvel[:, layout.gimbal_rate], qvel[:, layout.rotor_speed] = angle, rate, speed
    turned = replace(misaligned(CLUSTER, MISALIGNMENT), rotor_momentum=CLUSTER.rotor_spin_inertia * speed)
    expected = cluster_momentum(turned, angle, rate)
    np.testing.assert_allclose(total_momentum(model, qpos, qvel)[0], expected, atol=1e-14)  # of 0.02 N·m·s
