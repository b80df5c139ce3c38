"""The search over starts, on a program whose optima are known."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from testbed.errors import InfeasibleDesignError
from testbed.maneuver.design import Search
from testbed.maneuver.multistart import best_of_starts
from testbed.maneuver.program import Constraint, Program, solver, within


def stage(*limits, cost=lambda x: (x**2 - 1.0) ** 2 + 0.3 * x):
    """A quartic with a good optimum near -1 and a poor one near +1."""
    x = ca.MX.sym("x")
    constraints = tuple(limit(x) for limit in limits or (lambda x: within("range", x, 3.0),))
    program = Program(
        variables=x, cost=cost(x), constraints=constraints, completed=lambda values: values, hessian="exact"
    )
    return solver(program)


def draw(rng):
    return rng.uniform(-1.5, 1.5, 1)


def test_the_best_of_the_starts_wins():
    best = best_of_starts((stage(),), draw, Search(starts=6, seed=0))
    costs = [start.cost for start in best.starts]
    assert len({round(cost, 3) for cost in costs}) == 2  # both optima are found
    assert costs[best.winner] == min(costs)
    assert best.variables[0] == pytest.approx(-1.036, abs=1e-3)


def test_each_start_is_reported_as_it_ends():
    reported = []
    best = best_of_starts((stage(),), draw, Search(starts=3, seed=0, progress=reported.append))
    assert tuple(reported) == best.starts
    assert [start.index for start in reported] == [0, 1, 2]
    assert all(start.status == "Solve_Succeeded" and start.seconds > 0.0 for start in reported)


def test_a_later_stage_starts_from_the_earlier_ones_optimum():
    """The second cost is flat between its optima at ±1; only the first stage leads away from the start."""
    lead = stage(cost=lambda x: (x - 1.0) ** 2)
    best = best_of_starts((lead, stage()), lambda _: np.array([-1.2]), Search(starts=1, seed=0))
    assert best.variables[0] == pytest.approx(0.960, abs=1e-3)


def test_starts_depend_on_the_seed_alone():
    def costs(starts, seed):
        return [start.cost for start in best_of_starts((stage(),), draw, Search(starts=starts, seed=seed)).starts]

    assert costs(2, 7) == costs(4, 7)[:2]


def test_an_infeasible_start_is_passed_over():
    """x² ≥ 0.01 cannot be left from x = 0, where it is flat, as its gradient does not say where to go."""
    drawn = iter([np.array([0.0]), np.array([0.5])])
    limit = stage(lambda x: Constraint(name="distance", expression=x**2, lower=0.01, upper=4.0), cost=lambda x: x**2)
    best = best_of_starts((limit,), lambda _: next(drawn), Search(starts=2, seed=0))
    assert best.winner == 1
    assert best.starts[0].cost == np.inf


def test_conflicting_limits_are_named_with_how_much():
    conflict = stage(lambda x: within("left", x + 1.0, 0.5), lambda x: within("right", x - 1.0, 0.5))
    with pytest.raises(InfeasibleDesignError) as caught:
        best_of_starts((conflict,), draw, Search(starts=2, seed=0))
    message = str(caught.value)
    assert "none of 2 starts" in message
    assert "left by" in message
    assert "right by" in message


def test_limits_are_shares_of_each_axis():
    x = ca.MX.sym("x", 2, 3)
    constraint = within("rate", x, np.array([1.0, 2.0, 4.0]))
    values = ca.Function("share", [x], [constraint.expression])(np.array([[1.0, 2.0, 4.0], [-1.0, -2.0, -4.0]]))
    np.testing.assert_array_equal(np.abs(values.full()), 1.0)
    np.testing.assert_array_equal(constraint.bounds[0], -1.0)
