"""What uncertain actuators and gyro do to an estimate: predicted, against estimators that are given wrong ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import (
    NOMINAL_THETA,
    TRUE_THETA,
    exact_telemetry,
    nominal_flight,
    sample_times,
    with_gimbals,
)
from testbed.cmg.misalignment import misaligned
from testbed.estimation.considered import considered_shifts
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.preparation import identifiable_part
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.uncertainty import EXACT, Uncertainty

TIMES = sample_times(16.0)
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
SIZE = 1e-3
"""rad, shares and, a tenth of it, rad/s: small enough that what is neglected, its square, is 0.1 % of the shift."""
STD = Uncertainty(
    rotor_momentum=SIZE,
    gimbal_zero=SIZE,
    gimbal_misalignment=SIZE,
    gyro_bias=0.1 * SIZE,
    gyro_scale=SIZE,
    gyro_misalignment=SIZE,
)
FLIGHTS = {
    "from rest": (np.zeros(3), "zero"),
    "momentum estimated": (np.zeros(3), "estimated"),
    "released with a spin": (np.array([0.003, -0.004, 0.006]), "estimated"),
}


def flown(name):
    momentum_B, assumed = FLIGHTS[name]
    return replace(exact_telemetry(nominal_flight(momentum_B), TIMES, TIMES, 1e-3), initial_momentum=assumed)


def believed_wrongly(telemetry):
    """Yield the telemetry with each quantity off by its standard deviation, in the order of the predicted shifts."""
    cluster = telemetry.gimbals.cluster
    for unit in range(6):
        for turn in range(2):
            turned = np.zeros((6, 2))
            turned[unit, turn] = -SIZE  # the flown unit stands that far off the one that is believed
            yield with_gimbals(telemetry, cluster=misaligned(cluster, turned))
        angle = telemetry.gimbals.angle.copy()
        angle[:, unit] += SIZE
        yield with_gimbals(telemetry, angle=angle)
        momentum = cluster.rotor_momentum.copy()
        momentum[unit] *= 1.0 - SIZE
        yield with_gimbals(telemetry, cluster=replace(cluster, rotor_momentum=momentum))
    rate = telemetry.body_rate
    for axis in range(3):
        yield replace(telemetry, body_rate=rate + 0.1 * SIZE * np.eye(3)[axis])
    for axis in range(3):
        yield replace(telemetry, body_rate=rate * (1.0 + SIZE * np.eye(3)[axis]))
    for turn in (1, 2):
        for axis in range(3):
            oblique = rate.copy()
            oblique[:, axis] += SIZE * rate[:, (axis + turn) % 3]
            yield replace(telemetry, body_rate=oblique)


@pytest.mark.parametrize("flight", FLIGHTS)
def test_shifts_are_those_of_estimators_that_believe_wrong_numbers(flight):
    telemetry = flown(flight)
    estimates = {name: estimator(telemetry, SETTINGS) for name, estimator in ESTIMATORS.items()}
    part = identifiable_part(telemetry, SETTINGS)
    influences = {name: estimate.influence for name, estimate in estimates.items()}
    predicted, kinds = considered_shifts(part, TRUE_THETA, STD, influences)
    axis = "gimbal_misalignment"
    gyro = [kind for kind in ("gyro_bias", "gyro_scale", "gyro_misalignment", "gyro_misalignment") for _ in range(3)]
    assert kinds == (*6 * (axis, axis, "gimbal_zero", "rotor_momentum"), *gyro)
    wrong = list(believed_wrongly(telemetry))
    for name, estimator in ESTIMATORS.items():
        shifts = np.array([estimator(each, SETTINGS).theta - estimates[name].theta for each in wrong]).T
        assert predicted[name].shape == shifts.shape == (6, 36)
        np.testing.assert_allclose(predicted[name], shifts, atol=4e-3 * np.abs(shifts).max())


def test_a_reported_momentum_is_uncertain_by_axis():
    gimbals = flown("from rest")
    flight = nominal_flight()
    momentum_B = TIMES[:, None] * 0.0 - flight.body_rate(TIMES) @ np.diag(TRUE_THETA[:3])
    telemetry = replace(gimbals, gimbals=None, cluster_momentum=momentum_B)
    estimate = ESTIMATORS["output_error"](telemetry, SETTINGS)
    part = identifiable_part(telemetry, SETTINGS)
    scale = Uncertainty(rotor_momentum=SIZE)
    by_name, kinds = considered_shifts(part, TRUE_THETA, scale, {"oe": estimate.influence})
    shifts = by_name["oe"]
    assert kinds == ("rotor_momentum",) * 3
    for axis in range(3):
        scaled = replace(telemetry, cluster_momentum=momentum_B * (1.0 - SIZE * np.eye(3)[axis]))
        shift = ESTIMATORS["output_error"](scaled, SETTINGS).theta - estimate.theta
        np.testing.assert_allclose(shifts[:, axis], shift, atol=5e-3 * np.abs(shift).max())


def test_nothing_uncertain_shifts_nothing():
    telemetry = flown("from rest")
    estimate = ESTIMATORS["iv"](telemetry, SETTINGS)
    part = identifiable_part(telemetry, SETTINGS)
    assert considered_shifts(part, TRUE_THETA, EXACT, {"iv": estimate.influence}).by_name["iv"].shape == (6, 0)


@pytest.mark.parametrize("name", ["iv_momentum", "output_error"])
def test_influence_makes_the_covariance(name):
    telemetry = flown("momentum estimated")
    noisy = replace(
        telemetry,
        body_rate=telemetry.body_rate + 1e-3 * np.random.default_rng(1).normal(size=telemetry.body_rate.shape),
    )
    estimate = ESTIMATORS[name](noisy, SETTINGS)
    made = estimate.residual_sigma**2 * estimate.influence @ estimate.influence.T
    np.testing.assert_allclose(made, estimate.covariance, rtol=1e-9)
