"""Constant torques estimated jointly with the inertia, on motions integrated with them by an independent solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from support.synthetic_telemetry import NOMINAL_THETA, TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.cmg.cluster import cluster_momentum, inertia_change
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.rotation.quaternion import matrix_of

TIMES = sample_times(16.0)
FLIGHT = nominal_flight()
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
BODY = np.array([4e-5, -2e-5, 3e-5])
INERTIAL = np.array([-3e-5, 5e-5, 2e-5])
"""N·m; each moves a parameter of this flight by ten of its standard deviations at flight noise."""


def turned_by(body, inertial):
    """Telemetry of the nominal gimbal motion under a torque fixed in the body and one fixed in inertial axes."""

    def rate(time, momentum):
        angle, speed = FLIGHT.gimbals.angle(np.array([time])), FLIGHT.gimbals.rate(np.array([time]))
        inertia = inertia_of(TRUE_THETA) + inertia_change(FLIGHT.cluster, angle)[0]
        return np.linalg.solve(inertia, momentum - cluster_momentum(FLIGHT.cluster, angle, speed)[0])

    def slope(time, state):
        momentum, attitude = state[:3], state[3:]
        omega = rate(time, momentum)
        w, x, y, z = attitude
        p, q, r = omega
        turning = 0.5 * np.array(
            [-x * p - y * q - z * r, w * p + y * r - z * q, w * q - x * r + z * p, w * r + x * q - y * p]
        )
        torque = body + matrix_of(attitude / np.linalg.norm(attitude)).T @ inertial
        return np.concatenate([torque - np.cross(omega, momentum), turning])

    start = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    solved = solve_ivp(slope, (0.0, TIMES[-1]), start, method="DOP853", t_eval=TIMES, rtol=1e-11, atol=1e-14)
    rates = np.array([rate(time, state[:3]) for time, state in zip(TIMES, solved.y.T, strict=True)])
    return replace(exact_telemetry(FLIGHT, TIMES, TIMES, 1e-3), body_rate=rates)


@pytest.mark.parametrize(
    ("kind", "body", "inertial"),
    [("body", BODY, 0 * INERTIAL), ("inertial", 0 * BODY, INERTIAL), ("both", BODY, INERTIAL)],
)
@pytest.mark.parametrize("initial_momentum", ["zero", "estimated"])
def test_inertia_and_torque_are_recovered(kind, body, inertial, initial_momentum):
    telemetry = replace(turned_by(body, inertial), constant_torque=kind, initial_momentum=initial_momentum)
    expected = {"body": body, "inertial": inertial, "both": np.concatenate([body, inertial])}[kind]
    for name, estimator in ESTIMATORS.items():
        estimate = estimator(telemetry, SETTINGS)
        np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(estimate.constant_torque, expected, atol=3e-7, err_msg=name)


def test_a_torque_that_is_not_estimated_biases_the_inertia():
    telemetry = replace(turned_by(BODY, INERTIAL), initial_momentum="zero")
    error = ESTIMATORS["output_error"](telemetry, SETTINGS).theta - TRUE_THETA
    assert np.abs(error).max() > 1e-4


@pytest.mark.parametrize("name", ["iv_momentum", "output_error"])
def test_with_noise_the_bound_is_reached_and_the_torque_is_as_uncertain_as_stated(name):
    exact = replace(turned_by(0 * BODY, INERTIAL), constant_torque="inertial", initial_momentum="zero")
    bound = np.sqrt(np.diag(cramer_rao_bound(exact, TRUE_THETA, np.zeros(3))))
    without = np.sqrt(np.diag(cramer_rao_bound(replace(exact, constant_torque="none"), TRUE_THETA, np.zeros(3))))
    assert np.all(bound > without)
    answers = []
    for seed in range(200):
        noise = 1e-3 * np.random.default_rng(seed).standard_normal(exact.body_rate.shape)
        answers.append(ESTIMATORS[name](replace(exact, body_rate=exact.body_rate + noise), SETTINGS))
    scatter = np.std([each.theta for each in answers], axis=0, ddof=1)
    np.testing.assert_allclose(scatter, bound, rtol=0.2)  # four standard errors of 200 seeds
    errors = np.array([(each.constant_torque - INERTIAL) / each.constant_torque_std for each in answers])
    np.testing.assert_allclose(errors.std(axis=0), 1.0, atol=0.2)
