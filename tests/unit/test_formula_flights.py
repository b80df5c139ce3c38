"""Formulas fly on platforms of every environment, and side by side."""

import numpy as np
import pytest

from testbed.dynamics.environment import Orbiting
from testbed.formulas.parser import parsed
from testbed.formulas.torque import Torque
from testbed.plant.build import build
from testbed.plant.plant import Plant
from testbed.plant.properties import AirBearing, InitialState, PlatformProperties

INERTIA = np.diag([0.022, 0.024, 0.027])
PRODUCT = Torque(law=parsed("w_x*w_y"), coefficient=np.array([0.0, 0.0, 2e-2]))
LAGGED = Torque(law=parsed("lag(w_z, 0.2)"), coefficient=np.array([5e-3, 0.0, 0.0]), frame="N")


def plant(torques, *, bearing=None, orbit_torque=None, platforms=1, rate=(0.4, -0.3, 0.5)):
    properties = PlatformProperties(units=0, inertia=INERTIA, mass=4.0, step=1e-3, air_bearing=bearing)
    starts = [
        InitialState(
            body_rate=(1.0 + 0.1 * number) * np.array(rate),
            attitude=np.array([1.0, 0.0, 0.0, 0.0]),
            position=np.zeros(3),
            velocity=np.zeros(3),
            gimbal_angle=np.zeros(0),
        )
        for number in range(platforms)
    ]
    return Plant(
        [build(properties)] * platforms,
        initial=starts,
        rotor_momentum=np.zeros((platforms, 0)),
        orbit_torque=orbit_torque,
        torques=torques,
    )


def flown(*arguments, **more):
    flying = plant(*arguments, **more)
    flying.advance(np.zeros((len(flying.models), 0)), 500)
    assert not flying.divergence
    return flying.body_rate.copy()


NOTHING = Torque(law=parsed("1"), coefficient=np.zeros(3))


@pytest.mark.parametrize("bearing", [None, AirBearing(center_of_mass_B=np.array([0.0, 1e-4, -1e-3]), gravity=9.81)])
def test_stages_taken_one_by_one_are_those_of_mujoco(bearing):
    np.testing.assert_allclose(flown([NOTHING], bearing=bearing), flown([], bearing=bearing), atol=1e-12)


def test_an_orbits_torque_is_taken_at_every_stage_too():
    orbit = Orbiting(
        rate=1e-3, field_L=np.array([3e-5, 0.0, 0.0]), torque_L=np.zeros(3), dipole_B=np.array([0, 0, 0.1])
    )

    def torque(_, matrix_NB):
        return np.cross(orbit.dipole_B, np.swapaxes(matrix_NB, -1, -2) @ orbit.field_L)

    at_stages, once = flown([NOTHING], orbit_torque=torque), flown([], orbit_torque=torque)
    np.testing.assert_allclose(at_stages, once, atol=1e-9)  # else it is that of the middle of a step, extrapolated
    assert np.abs(at_stages - flown([])).max() > 1e-5


def test_a_platform_flies_alike_alone_and_beside_others():
    beside = flown([PRODUCT, LAGGED], platforms=3)
    np.testing.assert_array_equal(beside[:1], flown([PRODUCT, LAGGED]))
    assert np.abs(beside[0] - flown([])[0]).max() > 1e-3


def test_a_product_of_rates_turns_a_body_by_its_coefficient():
    """J ω̇ = k ω_x ω_y about z over one short step, beside the gyroscopic torque."""
    rate = np.array([0.4, -0.3, 0.5])
    with_it, without = (plant(torques) for torques in ([PRODUCT], []))
    for each in (with_it, without):
        each.advance(np.zeros((1, 0)), 1)
    change = (with_it.body_rate - without.body_rate)[0]
    np.testing.assert_allclose(
        change, [0.0, 0.0, 2e-2 * rate[0] * rate[1] / INERTIA[2, 2] * 1e-3], rtol=1e-3, atol=1e-8
    )
