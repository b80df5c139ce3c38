"""The information that null motion is designed for is that of the estimator, and the design makes it large."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from support.maneuvers import CLUSTER, INERTIA, design_problem, gimbal_limits, without_units
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.estimation.alignment_model import alignment_of, held_momentum, sampled_gimbals
from testbed.estimation.identifiability import without_momentum
from testbed.estimation.motion import simulate
from testbed.estimation.sensitivity import rate_sensitivity
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry
from testbed.maneuver.alignment_information import alignment_information, relative_scales
from testbed.maneuver.design import Search
from testbed.maneuver.formulation import prefilter_of
from testbed.maneuver.gimbal_design import gimbal_design
from testbed.maneuver.gimbal_maneuver import gimbal_maneuver
from testbed.maneuver.splines import clamped_spline

PROBLEM = design_problem(metric="momentum", parameters="alignments")
SAMPLING = prefilter_of(PROBLEM)


def random_maneuver(cluster=CLUSTER, span=1.5):
    angle = np.random.default_rng(4).uniform(-span, span, (10, 6)) * (cluster.rotor_momentum != 0.0)
    angle[:2], angle[-1] = 0.0, angle[-2]
    spline = clamped_spline(5.0, angle)
    return gimbal_maneuver("random", spline, inertia=INERTIA, cluster=cluster, total_momentum_B=np.zeros(3))


LIGHT = replace(
    CLUSTER,
    gimbal_inertia=np.zeros(6),
    rotor_spin_inertia=np.full(6, 1e-12),
    rotor_transverse_inertia=np.full(6, 1e-12),
)
"""Gimbals and rotors that weigh nothing, so that the information leaves nothing out."""


def designed_for(maneuver, cluster=CLUSTER):
    angle = maneuver.gimbal_angle(SAMPLING.fine_time).T
    body_rate = maneuver.body_rate(SAMPLING.fine_time)
    expression = alignment_information(cluster, INERTIA, SAMPLING, ca.MX(ca.DM(angle)), ca.MX(ca.DM(body_rate)))
    return ca.evalf(expression).full()


def estimators_own(maneuver, cluster=CLUSTER):
    """SᵀS of the exact sensitivities in the design's parameters, 400 actuator samples."""
    actuator_time = np.linspace(0.0, 5.0, 401)
    telemetry = Telemetry(
        gyro_time=SAMPLING.fine_time[SAMPLING.samples],
        body_rate=maneuver.body_rate(SAMPLING.fine_time[SAMPLING.samples]),
        gyro_noise=1.0,
        actuator_time=actuator_time,
        gimbals=GimbalTelemetry(cluster=cluster, angle=maneuver.gimbal_angle(actuator_time)),
    )
    record, aligned = sampled_gimbals(telemetry), alignment_of(np.zeros(24))
    motion = simulate(record.nominal, theta_of(INERTIA), np.zeros(3))
    columns = rate_sensitivity(record.nominal, motion, held_momentum(record, aligned, motion)).reshape(-1, 33)
    working = np.flatnonzero(cluster.rotor_momentum)
    inertia, angles, scales = columns[:, :6], columns[:, 6:24].reshape(-1, 3, 6), columns[:, 24:30]
    kept = [
        inertia * np.trace(INERTIA) / 3.0,
        angles[:, :, working].reshape(len(columns), -1),
        scales[:, working] @ relative_scales(len(working)),
    ]
    whole = without_momentum(np.hstack([*kept, columns[:, 30:]]), unknowns=sum(part.shape[1] for part in kept))
    return whole.T @ whole


# Of the shipped units the gimbals' own turning is left out, up to 0.4 % of a rotor's momentum; that moves the standard
# deviations of the weakest directions the most, by 2.8 %. Of weightless ones nothing is left out.
@pytest.mark.parametrize(
    ("cluster", "tolerance"),
    [(CLUSTER, 0.05), (without_units(2), 0.05), (LIGHT, 1e-4)],
    ids=["whole", "failed", "weightless"],
)
def test_it_is_the_information_of_the_estimators_exact_sensitivities(cluster, tolerance):
    maneuver = random_maneuver(cluster)
    std_designed, std_exact = (
        np.sqrt(np.diag(np.linalg.inv(matrix)))
        for matrix in (designed_for(maneuver, cluster), estimators_own(maneuver, cluster))
    )
    working = np.count_nonzero(cluster.rotor_momentum)
    assert std_designed.shape == (6 + 3 * working + working - 1,)
    np.testing.assert_allclose(std_designed, std_exact, rtol=tolerance)


def test_the_scales_that_are_kept_have_no_mean():
    basis = relative_scales(6)
    np.testing.assert_allclose(basis.sum(axis=0), 0.0, atol=1e-15)
    np.testing.assert_allclose(basis.T @ basis, np.eye(5), atol=1e-15)


def test_a_design_makes_it_large():
    problem = replace(PROBLEM, control_points=10)
    design = gimbal_design(problem, gimbal_limits(body_rate=0.4), Search(starts=1, seed=1))
    assert design.starts[0].status == "Solve_Succeeded"
    _, designed = np.linalg.slogdet(designed_for(design.maneuver))
    _, random = np.linalg.slogdet(designed_for(random_maneuver(span=1.0)))
    assert design.starts[0].cost == pytest.approx(-designed, abs=0.01)  # the program's own cost, evaluated afresh
    assert designed > random + 29 * np.log(2.0)  # standard deviations are smaller by sqrt(2) at the least, on average


def test_a_start_with_momentum_is_refused():
    moving = replace(PROBLEM, control_points=10, initial_body_rate=np.array([0.1, 0.0, 0.0]))
    with pytest.raises(InputError, match="starts without momentum"):
        gimbal_design(moving, gimbal_limits(), Search(starts=1, seed=1))
