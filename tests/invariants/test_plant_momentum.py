"""What MuJoCo must conserve, and how fast its error falls."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from support.platforms import ROTOR_MOMENTUM, initial, plant, restless_torque, shipped
from testbed.plant.build import build
from testbed.plant.geometry import cluster_of, total_momentum
from testbed.plant.properties import PlatformProperties

CONTROL_PERIOD = 0.0125
SCALE = 6.0 * ROTOR_MOMENTUM


def fly_restlessly(step: float, rotors: str = "free"):
    """5 s, all six gimbals moving; returns the states at every control period."""
    model = build(PlatformProperties(step=step))
    flown = plant(model, initial(body_rate=np.array([0.1, -0.2, 0.15])), rotors=rotors)
    states = [(flown.qpos.copy(), flown.qvel.copy())]
    for tick in range(400):
        flown.advance(restless_torque(tick * CONTROL_PERIOD), round(CONTROL_PERIOD / step))
        states.append((flown.qpos.copy(), flown.qvel.copy()))
    return model, *map(np.array, zip(*states, strict=True))


@pytest.mark.parametrize("rotors", ["free", "constant_speed"])
def test_angular_momentum_drifts_less_than_1e_7(rotors):
    model, qpos, qvel = fly_restlessly(0.00125, rotors)
    momentum_N = total_momentum(model, qpos, qvel)
    assert np.abs(qvel[:, 6::2]).max(axis=0).min() > 0.3, "every gimbal has to move"
    assert np.linalg.norm(momentum_N - momentum_N[0], axis=1).max() / SCALE <= 1e-7


def test_order_of_convergence_is_four():
    _, _, reference = fly_restlessly(0.00125 / 2)
    errors = [np.abs(fly_restlessly(step)[2][:, 3:6] - reference[:, 3:6]).max() for step in (0.00625, 0.003125)]
    # The reference's own error is 10⁴ and 625 times smaller than these; 3.7 leaves room for the next order's share.
    order = np.log2(errors[0] / errors[1])
    assert 3.7 < order < 4.6
    assert errors[1] > 1e-12, "above rounding, or the order would say nothing"


def test_free_gimbals_conserve_energy():
    spec_model = shipped()
    spec_model.actuator_biasprm[:] = 0.0  # no tachometer loop: nothing does work
    spec_model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(spec_model)
    data.qvel[3:6] = [0.1, -0.2, 0.15]
    data.qvel[6::2] = [0.5, -0.4, 0.3, 0.2, -0.6, 0.1]
    data.qvel[7::2] = cluster_of(spec_model).rotor_momentum / 1e-5
    mujoco.mj_forward(spec_model, data)
    before = data.energy[1]
    mujoco.mj_step(spec_model, data, 4000)
    mujoco.mj_forward(spec_model, data)
    assert abs(data.energy[1] / before - 1.0) < 1e-9


def test_momentum_is_the_same_in_our_form_and_in_mujocos():
    """J(d) ω + h(d, ḋ, Ω), turned to N, against MuJoCo's own sum over bodies."""
    from scipy.spatial.transform import Rotation

    from testbed.cmg.cluster import cluster_momentum, inertia_change
    from testbed.plant.geometry import composite_inertia

    model, qpos, qvel = fly_restlessly(0.00125)
    cluster = cluster_of(model)
    angle, rate = qpos[:, 7::2], qvel[:, 6::2]
    momentum_B = cluster_momentum(cluster, angle, rate, cluster.rotor_spin_inertia * qvel[:, 7::2])
    inertia = composite_inertia(model) + inertia_change(cluster, angle)
    momentum_B = momentum_B + (inertia @ qvel[:, 3:6, None])[..., 0]
    momentum_N = Rotation.from_quat(qpos[:, 3:7], scalar_first=True).apply(momentum_B)
    assert np.abs(momentum_N - total_momentum(model, qpos, qvel)).max() / SCALE < 1e-12
