"""The gravity-gradient torque against the pull on each of many points."""

from __future__ import annotations

import numpy as np

from testbed.dynamics.gravity_gradient import gravity_gradient_torque

MU, RADIUS = 3.986004418e14, 6.778e6


def test_it_is_the_torque_of_newtons_law_on_each_point_of_a_body():
    rng = np.random.default_rng(5)
    mass, place = rng.uniform(0.5, 1.5, 40), rng.uniform(-30.0, 30.0, (40, 3))
    place -= mass @ place / mass.sum()
    inertia = (mass * (place**2).sum(axis=1)).sum() * np.eye(3) - (mass * place.T) @ place
    outward = np.array([0.48, -0.6, 0.64])
    from_center = RADIUS * outward + place
    pull = -MU * mass[:, None] * from_center / np.linalg.norm(from_center, axis=1, keepdims=True) ** 3
    torque = np.cross(place, pull).sum(axis=0)
    found = gravity_gradient_torque(inertia, outward, np.sqrt(MU / RADIUS**3))
    neglected = 5.0 * np.linalg.norm(place, axis=1).max() / RADIUS  # the series' next term, of a lopsided body
    np.testing.assert_allclose(found, torque, rtol=0, atol=neglected * np.abs(torque).max())


def test_directions_are_taken_one_by_one():
    outward = np.eye(3)
    inertia = np.array([[3.0, 0.1, 0.2], [0.1, 4.0, 0.3], [0.2, 0.3, 5.0]])
    expected = [gravity_gradient_torque(inertia, each, 1e-3) for each in outward]
    np.testing.assert_array_equal(gravity_gradient_torque(inertia, outward, 1e-3), expected)
