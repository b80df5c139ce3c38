"""What acts from outside, in the prediction: as the dynamics have it, with derivatives by what it depends on alone."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from testbed.dynamics.environment import Orbiting, Pivoted, local_axes, outside_torque
from testbed.dynamics.inertia import inertia_of
from testbed.effects.registry import EFFECTS
from testbed.prediction.environment import OrbitHooks
from testbed.prediction.hooks import Instant

THETA = np.array([0.1, 0.2, 0.3, 0.01, -0.02, 0.03])
ORBIT = Orbiting(
    rate=1.1e-3,
    field_L=np.array([2e-5, -1e-5, 3e-5]),
    torque_L=np.array([1e-7, 2e-7, -1e-7]),
    dipole_B=np.array([0.01, 0.02, -0.03]),
    gradient=1.3,
)
PIVOT = Pivoted(mass=20.0, gravity=9.81, offset_B=np.array([1e-5, -2e-5, 3e-5]))


def instant(environment, count=6, seed=1):
    rng = np.random.default_rng(seed)
    first, turned = (Rotation.random(count, random_state=seed + step).as_matrix()[:, None] for step in (1, 2))
    return Instant(
        time=np.linspace(0.0, 500.0, count)[:, None],
        body_rate=rng.standard_normal((count, 1, 3)),
        attitude=turned,
        state=np.zeros((count, 1, 0)),
        first_NB=first,
        surroundings=SimpleNamespace(environment=environment, inertia=inertia_of(THETA)),
    )


def test_the_torques_of_an_orbit_are_those_of_the_dynamics():
    at = instant(ORBIT)
    found = OrbitHooks(ORBIT).torque(THETA[None], at)[:, 0]
    matrix_NB = (at.first_NB @ at.attitude)[:, 0]
    whole = outside_torque(ORBIT, inertia_of(THETA), at.time[:, 0], matrix_NB, at.body_rate[:, 0])
    np.testing.assert_allclose(found, whole, rtol=1e-12, atol=1e-19)
    assert not np.allclose(local_axes(ORBIT, at.time[-1, 0]), np.eye(3)), "the orbit has turned by then"


def test_complex_steps_pass_through_them():
    at, step = instant(ORBIT), 1e-20
    disturbed = THETA[None] + 1j * step * np.eye(6)[:2]
    slope = OrbitHooks(ORBIT).torque(disturbed, at).imag / step
    plain = OrbitHooks(ORBIT)
    for which in range(2):
        larger, smaller = (plain.torque(THETA[None] + sign * 0.05 * np.eye(6)[which], at)[:, 0] for sign in (1, -1))
        np.testing.assert_allclose(slope[:, which], (larger - smaller) / 0.1, rtol=1e-9, atol=1e-18)


STILL = [each for each in EFFECTS.values() if not each.hooks(each.components[0]).needs_rate]


def test_some_effects_say_that_they_do_not_follow_the_rate():
    assert {"body_torque", "magnetic_dipole", "center_of_mass_offset"} <= {each.id for each in STILL}


@pytest.mark.parametrize("effect", [pytest.param(each, id=each.id) for each in STILL])
def test_they_do_not(effect):
    """Derivatives by ω are not taken of them."""
    hooks = effect.hooks(effect.components[0])
    at = instant(PIVOT if effect.environment == "air_bearing" else ORBIT)
    faster = replace(at, body_rate=3.0 * at.body_rate + 0.5)
    value = np.linspace(1.0, 2.0, len(effect.parameters))[None]
    torque = hooks.torque(value, at)
    assert np.any(torque)
    np.testing.assert_array_equal(torque, hooks.torque(value, faster))
