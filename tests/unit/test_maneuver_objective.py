"""The information that a criterion is taken of: the momentum metric is the Cramér-Rao bound, targets are weights."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from support.maneuvers import CLUSTER, INERTIA, design_problem, gimbal_limits
from testbed.dynamics.inertia import theta_of
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry
from testbed.maneuver.criteria import criterion_terms, information_matrix
from testbed.maneuver.design import Search
from testbed.maneuver.formulation import prefilter_of
from testbed.maneuver.gimbal_design import gimbal_design
from testbed.maneuver.gimbal_maneuver import gimbal_maneuver
from testbed.maneuver.objective import design_information
from testbed.maneuver.splines import clamped_spline

NOISE = 0.025
TARGET = 1e-3 * np.array([0.19, 0.165, 0.175, 0.115, 0.12, 0.14])
SAMPLING = prefilter_of(design_problem())


def bound_std(maneuver):
    """Of the motion as designed, by the estimators' own analytic sensitivities, 400 actuator samples."""
    gyro_time, actuator_time = np.arange(81) / 16.0, np.linspace(0.0, 5.0, 401)
    telemetry = Telemetry(
        gyro_time=gyro_time,
        body_rate=maneuver.reference(gyro_time).body_rate,
        gyro_noise=NOISE,
        actuator_time=actuator_time,
        gimbals=GimbalTelemetry(cluster=CLUSTER, angle=maneuver.reference(actuator_time).gimbal_angle),
        initial_momentum="zero",
    )
    return np.sqrt(np.diag(cramer_rao_bound(telemetry, theta_of(INERTIA), np.zeros(3))))


def random_maneuver():
    angle = np.random.default_rng(4).uniform(-1.0, 1.0, (10, 6))
    angle[:2], angle[-1] = 0.0, angle[-2]
    spline = clamped_spline(5.0, angle)
    return gimbal_maneuver("random", spline, inertia=INERTIA, cluster=CLUSTER, total_momentum_B=np.zeros(3))


def information(body_rate, **changes):
    problem = design_problem("A", **changes)
    return ca.evalf(design_information(problem, SAMPLING, ca.MX(ca.DM(body_rate)))).full()


def test_the_momentum_metric_is_the_cramer_rao_bound():
    maneuver = random_maneuver()
    found = information(maneuver.body_rate(SAMPLING.fine_time), metric="momentum")
    std = NOISE * np.trace(INERTIA) / 3.0 * np.sqrt(np.diag(np.linalg.inv(found)))
    # The gimbals change J by up to 28e-6 of 22e-3 kg·m², which the metric leaves out.
    np.testing.assert_allclose(std, bound_std(maneuver), rtol=2e-3)


def test_the_papers_metric_is_left_as_it_was():
    body_rate = random_maneuver().body_rate(SAMPLING.fine_time)
    np.testing.assert_array_equal(
        information(body_rate), ca.evalf(information_matrix(SAMPLING, ca.DM(body_rate))).full()
    )


@pytest.mark.parametrize("metric", ["torque", "momentum"])
def test_a_sums_squared_shares_of_the_targets(metric):
    body_rate = random_maneuver().body_rate(SAMPLING.fine_time)
    variance = np.diag(np.linalg.inv(information(body_rate, metric=metric)))
    weighted = information(body_rate, metric=metric, target_std=TARGET)
    cost = float(ca.evalf(criterion_terms("A", ca.MX(ca.DM(weighted))).cost))
    assert cost == pytest.approx(np.log(np.sum(variance / (TARGET / TARGET.mean()) ** 2)), rel=1e-10)


def test_the_weighted_design_gives_every_parameter_its_share():
    """One start of 12 points: shares of 0.71 to 0.91 unweighted, 0.72 to 0.89 weighted."""
    problem = replace(design_problem("A"), metric="momentum")
    plain, weighted = (
        bound_std(gimbal_design(each, gimbal_limits(), Search(starts=1, seed=2)).maneuver) / TARGET
        for each in (problem, replace(problem, target_std=TARGET))
    )
    assert weighted.max() < plain.max()
    assert np.ptp(weighted) < np.ptp(plain)
