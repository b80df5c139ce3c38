"""Inertias that a body can have, and the one among them that is nearest to an estimate."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.estimation.body import is_body, nearest_body, second_moments

PLATE = np.array([0.020, 0.025, 0.045, 0.0, 0.0, 0.001])
"""kg·m²; J33 = J11 + J22, as of a flat plate in the plane of x and y."""
STD = 1e-4 * np.array([1.3, 1.2, 1.6, 1.0, 1.0, 0.9])


def masses(rng):
    """Point masses anywhere: the inertia of a body by its definition."""
    place = rng.normal(size=(rng.integers(3, 9), 3))
    moments = place.T @ place
    return theta_of(np.trace(moments) * np.eye(3) - moments)


@given(st.integers(0, 10_000))
def test_masses_make_a_body(seed):
    assert is_body(masses(np.random.default_rng(seed)))


@pytest.mark.parametrize(
    "theta",
    [
        [0.02, 0.02, 0.05, 0.0, 0.0, 0.0],  # J33 > J11 + J22
        [0.02, 0.02, -0.01, 0.0, 0.0, 0.0],
        [0.02, 0.02, 0.02, 0.021, 0.0, 0.0],  # not positive definite
    ],
)
def test_what_no_body_has(theta):
    assert not is_body(np.array(theta))


def test_a_plate_written_with_rounded_digits_is_a_body():
    assert is_body(np.round(PLATE * np.array([1.0, 1.0, 1.0 + 5e-11, 1.0, 1.0, 1.0]), 12))


def test_an_estimate_that_is_a_bodys_is_not_moved():
    theta = PLATE - np.array([0, 0, 1e-3, 0, 0, 0])
    assert nearest_body(theta, np.diag(STD**2)) is theta


@pytest.mark.parametrize("correlation", [0.0, 0.6])
def test_the_nearest_body_is_one_and_no_other_is_nearer(correlation):
    covariance = np.outer(STD, STD) * (np.eye(6) * (1.0 - correlation) + correlation)
    inverse, rng = np.linalg.inv(covariance), np.random.default_rng(4)
    for _ in range(20):
        theta = PLATE + np.linalg.cholesky(covariance) @ rng.standard_normal(6)
        if is_body(theta):
            continue
        nearest = nearest_body(theta, covariance)
        assert np.linalg.eigvalsh(second_moments(nearest))[0] > -1e-12

        def distance(other, theta=theta):
            return float((other - theta) @ inverse @ (other - theta))

        def search(inside, distance=distance):
            return minimize(
                distance,
                PLATE - np.array([0, 0, inside, 0, 0, 0]),
                constraints={"type": "ineq", "fun": lambda other: 1e3 * np.linalg.eigvalsh(second_moments(other))[0]},
                method="SLSQP",
                options={"ftol": 1e-12, "maxiter": 500},
            )

        # Rounding decides from which start its line search comes to an end; else what it returns may be no body.
        found = next(each for each in map(search, (1e-3, 5e-4, 2e-3, 1e-4, 3e-3, 5e-3)) if each.success)
        assert distance(nearest) < distance(found.x) * (1.0 + 1e-3) + 1e-6


def test_second_moments_are_those_of_the_masses():
    place = np.random.default_rng(1).normal(size=(5, 3))
    moments = place.T @ place
    theta = theta_of(np.trace(moments) * np.eye(3) - moments)
    np.testing.assert_allclose(second_moments(theta), moments, atol=1e-12)
    np.testing.assert_allclose(np.trace(second_moments(theta)), np.trace(inertia_of(theta)) / 2.0)


def test_an_estimate_without_any_inertia_has_a_nearest_body_too():
    """Its search began at the root of a negative number, and ended in a traceback."""
    theta = np.array([-0.02, -0.02, -0.03, 0.0, 0.0, 0.0])
    assert is_body(nearest_body(theta, 1e-6 * np.eye(6)))
