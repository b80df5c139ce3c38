"""The symbolic momentum balance against the numeric one and against MuJoCo's inverse dynamics."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from support.maneuvers import CLUSTER, GYROS, INERTIA, without_units
from support.platforms import shipped
from testbed.cmg.cluster import cluster_momentum, momentum_jacobian, platform_momentum
from testbed.cmg.singularity import envelope_fraction, singularity_measure, sphere_directions
from testbed.maneuver.cluster_motion import MOTION_OUTPUTS, body_rate_function, motion_function
from testbed.maneuver.envelope import envelope_share_function
from testbed.plant.layout import layout_of

RNG = np.random.default_rng(11)
ANGLE, RATE, ACCELERATION = RNG.uniform(-3, 3, 6), RNG.uniform(-2, 2, 6), RNG.uniform(-30, 30, 6)
TOTAL = np.array([0.004, -0.003, 0.006])


def motion(angle=ANGLE, rate=RATE, acceleration=ACCELERATION, total=TOTAL):
    outputs = motion_function(GYROS, INERTIA, np.zeros(0))(angle, rate, acceleration, total)
    return {name: output.full().ravel() for name, output in zip(MOTION_OUTPUTS, outputs, strict=True)}


def test_the_body_rate_conserves_momentum():
    body_rate = body_rate_function(GYROS, INERTIA)(ANGLE, RATE, TOTAL).full().ravel()
    np.testing.assert_allclose(platform_momentum(CLUSTER, INERTIA, body_rate, ANGLE, RATE), TOTAL, atol=1e-16)


def test_momentum_and_dexterity_equal_the_numeric_ones():
    found = motion()
    np.testing.assert_allclose(found["momentum"], cluster_momentum(CLUSTER, ANGLE, RATE), atol=1e-17)
    measure = singularity_measure(momentum_jacobian(CLUSTER, ANGLE), CLUSTER.rotor_momentum)
    assert np.sqrt(found["dexterity"][0]) == pytest.approx(measure, rel=1e-12)


def test_the_momentum_rate_is_the_derivative():
    def momentum(time):  # a complex step along the motion
        return cluster_momentum(CLUSTER, ANGLE + RATE * time, RATE + ACCELERATION * time)

    np.testing.assert_allclose(motion()["momentum_rate"], momentum(1e-30j).imag / 1e-30, atol=1e-16)


def test_gimbal_torques_equal_mujocos_inverse_dynamics():
    """MuJoCo is given the motion, and asked for the forces that make it: none on the bus, these on the gimbals."""
    model = shipped()
    layout, data, found = layout_of(model), mujoco.MjData(model), motion()
    data.qpos[layout.gimbal_angle] = ANGLE
    data.qvel[layout.gimbal_rate], data.qacc[layout.gimbal_rate] = RATE, ACCELERATION
    data.qvel[layout.rotor_speed] = CLUSTER.rotor_momentum / CLUSTER.rotor_spin_inertia
    data.qvel[layout.body_rate], data.qacc[layout.body_rate] = found["body_rate"], body_acceleration()
    mujoco.mj_inverse(model, data)
    np.testing.assert_allclose(data.qfrc_inverse[layout.body_rate], 0.0, atol=1e-12)
    np.testing.assert_allclose(data.qfrc_inverse[layout.gimbal_rate], found["gimbal_torque"], atol=1e-12)


def body_acceleration():
    """ω̇ by a complex step along the motion, L turning with the body."""
    body_rate = motion()["body_rate"]
    step = 1e-30j
    angle, rate = ANGLE + RATE * step, RATE + ACCELERATION * step
    total = TOTAL - np.cross(body_rate, TOTAL) * step
    zero = platform_momentum(CLUSTER, INERTIA, np.zeros(3), angle, rate)
    inertia = np.stack([platform_momentum(CLUSTER, INERTIA, axis, angle, rate) - zero for axis in np.eye(3)], axis=-1)
    return np.linalg.solve(inertia, total - zero).imag / 1e-30


@pytest.mark.parametrize("cluster", [CLUSTER, without_units(0), without_units(1, 4)], ids=["six", "five", "four"])
def test_the_envelope_share_is_right_within_a_percent(cluster):
    """Four units leave a flat envelope, where the repeated substitution is least exact."""
    directions = sphere_directions(300)
    exact = envelope_fraction(cluster, directions, sphere_directions(20000))
    share = envelope_share_function(cluster).map(300)
    on_envelope = directions / exact[:, None]
    np.testing.assert_allclose(share(on_envelope.T).full().ravel(), 1.0, atol=0.01 if cluster is CLUSTER else 0.03)


def test_the_envelope_of_parallel_gimbals_is_a_disc():
    """A scissored pair: its momentum is 2 h at most, normal to the gimbals; what these carry themselves is left out."""
    pair = replace(
        without_units(),
        **{
            name: getattr(CLUSTER, name)[:2]
            for name in ("rotor_momentum", "rotor_spin_inertia", "rotor_transverse_inertia", "gimbal_inertia")
        },
        gimbal_axis_B=np.array([[0.6, 0.0, 0.8], [-0.6, 0.0, -0.8]]),
        spin_axis_B=np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]),
    )
    share, most = envelope_share_function(pair), pair.rotor_momentum.sum()
    for within in ([0.0, 1.0, 0.0], [0.8, 0.0, -0.6], [0.8 / np.sqrt(2.0), 1.0 / np.sqrt(2.0), -0.6 / np.sqrt(2.0)]):
        momentum = 0.7 * most * np.array(within) + 1e-3 * most * np.array([0.6, 0.0, 0.8])
        assert float(share(momentum)) == pytest.approx(0.7, rel=1e-5)


def test_the_envelope_share_is_smooth_at_rest():
    share = envelope_share_function(CLUSTER)
    assert float(share(np.zeros(3))) == 0.0
    assert np.all(np.isfinite(share.jacobian()(np.zeros(3), 0.0).full()))
