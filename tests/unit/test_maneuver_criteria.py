"""Criteria and their derivatives against numpy, complex steps and eigenvalues."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from support.maneuvers import CLUSTER, GYROS, INERTIA, design_problem
from testbed.cmg.cluster import cluster_momentum, inertia_change
from testbed.maneuver.cluster_motion import body_rate_function
from testbed.maneuver.criteria import criterion_terms, information_matrix
from testbed.maneuver.formulation import prefilter_of
from testbed.maneuver.information import filtered_regressor
from testbed.maneuver.program import Constraint, Program, solver
from testbed.maneuver.splines import basis_matrix

SAMPLING = prefilter_of(design_problem())
BASIS, SLOPES = (basis_matrix(5.0, 10, SAMPLING.fine_time, order) for order in (0, 1))
COSTS = {
    "D": lambda information: -np.log(np.linalg.det(information)),
    "A": lambda information: np.log(np.trace(np.linalg.inv(information))),
}
"""As the paper writes them; they take complex matrices."""


def body_rate_of_rates(points):
    return BASIS @ points


def body_rate_of_angles(points):
    angle, rate = BASIS @ points, SLOPES @ points
    inertia = INERTIA + inertia_change(CLUSTER, angle)
    return -np.linalg.solve(inertia, cluster_momentum(CLUSTER, angle, rate)[..., None])[..., 0]


def symbolic_body_rate(points):
    if points.shape[1] == 3:
        return ca.DM(BASIS) @ points
    rate = body_rate_function(GYROS, INERTIA).map(len(SAMPLING.fine_time))
    return rate((ca.DM(BASIS) @ points).T, (ca.DM(SLOPES) @ points).T, np.zeros((3, len(SAMPLING.fine_time)))).T


def numeric_cost(criterion, body_rate):
    regressor = filtered_regressor(SAMPLING, body_rate)
    return COSTS[criterion](regressor.T @ regressor)


@pytest.mark.parametrize("criterion", ["D", "A"])
@pytest.mark.parametrize("motion", [body_rate_of_rates, body_rate_of_angles], ids=["body rate", "gimbal"])
def test_cost_and_gradient_equal_numpys(criterion, motion):
    axes = 3 if motion is body_rate_of_rates else 6
    rng = np.random.default_rng(0)
    values = rng.uniform(-0.5, 0.5, (10, axes))
    points = ca.MX.sym("points", 10, axes)
    cost = criterion_terms(criterion, information_matrix(SAMPLING, symbolic_body_rate(points))).cost
    found_cost, found_gradient = ca.Function("cost", [points], [cost, ca.gradient(cost, points)])(values)
    assert float(found_cost) == pytest.approx(numeric_cost(criterion, motion(values)), rel=1e-10)
    for _ in range(5):
        direction = rng.standard_normal((10, axes))
        stepped = numeric_cost(criterion, motion(values + 1e-30j * direction))  # a complex step has no truncation error
        assert float(np.sum(found_gradient.full() * direction)) == pytest.approx(stepped.imag / 1e-30, rel=1e-9)


EIGENVALUES = np.array([2.0, 2.0, 5.0, 9.0, 50.0, 50.0])


@pytest.mark.parametrize("scale", [1e-3, 1.0])
@pytest.mark.parametrize(
    ("criterion", "expected"),
    [("E", -np.log(2.0)), ("condition", np.log(25.0) - 0.3 * np.log(EIGENVALUES).mean())],
)
def test_eigenvalue_bounds_are_exact(criterion, expected, scale):
    """For a fixed matrix the slack alone has to find its extreme eigenvalues, double ones included."""
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((6, 6)))[0]
    information = turn @ np.diag(scale * EIGENVALUES) @ turn.T
    expected = expected - np.log(scale) * (1.0 if criterion == "E" else 0.3)
    terms = criterion_terms(criterion, ca.MX(information))
    program = Program(
        variables=terms.slack,
        cost=terms.cost,
        constraints=(Constraint(name="criterion", expression=terms.equality, lower=0.0, upper=0.0),),
        completed=lambda _: terms.slack_start(information),
        hessian="exact",
    )
    solution = solver(program)(terms.slack_start(information))
    assert solution.cost == pytest.approx(expected, abs=2e-5)  # the solver's own tolerance is 1e-5


def test_half_the_motion_is_worse_by_every_criterion():
    """Although it has the same condition number."""
    for criterion in ("D", "A", "E", "condition"):
        assert cost_at(criterion, 1.0) < cost_at(criterion, 0.25)


def cost_at(criterion, scale):
    information = scale * np.diag([2.0, 3.0, 4.0, 5.0, 6.0, 8.0])
    terms = criterion_terms(criterion, ca.MX(information))
    return float(ca.Function("cost", [terms.slack], [terms.cost])(terms.slack_start(information)))
