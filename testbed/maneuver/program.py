"""A nonlinear program with named limits, and IPOPT to solve it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from testbed.arrays import Array
from testbed.interrupts import raised_interrupts

_TOLERANCE = 1e-6
"""Largest overshoot of a limit, as a share of it: far below any margin, above what IPOPT's own slack leaves (1e-8)."""


@dataclass(frozen=True, kw_only=True)
class Constraint:
    """lower ≤ expression ≤ upper, in shares of a limit so that all limits weigh alike.

    Attributes:
        name: of the limit, as in "gimbal rate".
        expression: a column.
        lower: of every row.
        upper: of every row.
        jacobian: of the rows with regard to the first of the program's variables, where there is a cheaper way to it
            than CasADi's own; None leaves it to CasADi.
    """

    name: str
    expression: ca.MX
    lower: float
    upper: float
    jacobian: ca.MX | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bound of each row."""
        rows = self.expression.numel()
        return np.full(rows, self.lower), np.full(rows, self.upper)


@dataclass(frozen=True, kw_only=True)
class Program:
    """What to minimise, over what, within which limits.

    Attributes:
        variables: a column.
        cost: a scalar.
        constraints: the limits, at least one.
        completed: free parameters of a motion to variables, the criterion's own included.
        hessian: exact second derivatives, or IPOPT's limited-memory approximation.
    """

    variables: ca.MX
    cost: ca.MX
    constraints: tuple[Constraint, ...]
    completed: Callable[[Array], Array]
    hessian: Literal["exact", "limited-memory"]


class Solution(NamedTuple):
    """Where one start ended.

    Attributes:
        variables: shape (n,).
        cost: there.
        status: the optimiser's own word.
        excess: largest overshoot of each named limit, as a share of it; empty where all are kept.
    """

    variables: Array
    cost: float
    status: str
    excess: dict[str, float]


Solver: TypeAlias = Callable[[Array], Solution]
"""Solves a program from given free parameters of a motion."""


def within(name: str, expression: ca.MX, limit: ArrayLike) -> Constraint:
    """Return |expression| ≤ limit; the limit has the expression's rows, or one entry for each of its columns.

    Args:
        name: of the limit.
        expression: shape (N, C).
        limit: positive scalar, or shape (C,).
    """
    scale = np.broadcast_to(limit, (expression.shape[1],))
    return Constraint(name=name, expression=ca.vec(expression @ ca.diag(ca.DM(1.0 / scale))), lower=-1.0, upper=1.0)


def solver(program: Program) -> Solver:
    """Compile a program."""
    limits = ca.vertcat(*(constraint.expression for constraint in program.constraints))
    bounds = [constraint.bounds for constraint in program.constraints]
    lower = np.concatenate([low for low, _ in bounds])
    upper = np.concatenate([high for _, high in bounds])
    problem: dict[str, Any] = {"x": program.variables, "f": program.cost, "g": limits}
    slopes = ca.vertcat(*(_jacobian(constraint, program.variables) for constraint in program.constraints))
    ipopt = ca.nlpsol(
        "ipopt", "ipopt", problem, {**_options(program.hessian), "jac_g": _jacobian_function(problem, slopes)}
    )
    # What a failed solve reports as cost and limits may be empty; the point itself is never.
    evaluate = ca.Function("evaluate", [program.variables], [program.cost, limits])

    def solve(start: Array) -> Solution:
        with raised_interrupts():  # any call of CasADi may be that which comes upon what another one kept
            variables = ipopt(x0=program.completed(start), lbg=lower, ubg=upper)["x"]
            cost, values = (output.full().ravel() for output in evaluate(variables))
        return Solution(
            variables=variables.full().ravel(),
            cost=float(cost[0]),
            status=str(ipopt.stats()["return_status"]),
            excess=_excess(program.constraints, np.maximum(lower - values, values - upper)),
        )

    return solve


def _jacobian(constraint: Constraint, variables: ca.MX) -> ca.MX:
    """Return the derivatives of a limit's rows by all variables."""
    if constraint.jacobian is None:
        return ca.jacobian(constraint.expression, variables)
    rows, columns = constraint.jacobian.shape
    return ca.horzcat(constraint.jacobian, ca.MX(rows, variables.numel() - columns))


def _jacobian_function(problem: dict[str, Any], jacobian: ca.MX) -> ca.Function:
    """Return the function that CasADi would make of a problem itself, its names and its parameters, none, included."""
    names = ["x", "p"], ["g", "jac_g_x"]
    return ca.Function("nlp_jac_g", [problem["x"], ca.MX.sym("p", 0)], [problem["g"], jacobian], *names)


def _options(hessian: str) -> dict[str, Any]:
    return {
        "print_time": False,
        "show_eval_warnings": False,  # a trial step may leave the criterion's domain; IPOPT shortens it
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.hessian_approximation": hessian,
        "ipopt.nlp_scaling_method": "none",  # all is in shares of limits, and costs are logarithms
        # For the same reason the linear solver need not scale and permute for large pivots: with its quickest ordering,
        # and the approximate Hessian kept out of what it factorises, an iteration takes three quarters of the time.
        "ipopt.mumps_scaling": 0,
        "ipopt.mumps_permuting_scaling": 0,
        "ipopt.mumps_pivot_order": 0,
        "ipopt.limited_memory_aug_solver": "extended",
        "ipopt.max_iter": 500,
        "ipopt.tol": 1e-6,  # the barrier then costs a criterion less than 1e-5 of itself
        "ipopt.constr_viol_tol": 1e-8,
    }


def _excess(constraints: tuple[Constraint, ...], overshoot: Array) -> dict[str, float]:
    """Largest overshoot of each name, where it matters; NaN matters."""
    rows = np.cumsum([constraint.expression.numel() for constraint in constraints])[:-1]
    worst = {
        constraint.name: float(part.max(initial=0.0))
        for constraint, part in zip(constraints, np.split(overshoot, rows), strict=True)
    }
    return {name: value for name, value in worst.items() if not value <= _TOLERANCE}
