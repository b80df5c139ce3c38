"""From a parametrised motion and a criterion to the program that optimises it."""

from __future__ import annotations

from typing import Literal, NamedTuple

import casadi as ca
import numpy as np

from testbed.arrays import Array
from testbed.maneuver.criteria import Criterion, criterion_terms
from testbed.maneuver.design import DesignProblem
from testbed.maneuver.information import SampledFilter, sampled_filter
from testbed.maneuver.program import Constraint, Program


class SplinePoints(NamedTuple):
    """Control points as expressions of those of their entries that are free.

    Attributes:
        free: a column.
        rows: shape (n, axes).
    """

    free: ca.MX
    rows: ca.MX

    def values(self, variables: Array) -> Array:
        """Return the control points of a solution, whose first variables are the free entries."""
        evaluate = ca.Function("points", [self.free], [self.rows])
        return np.asarray(evaluate(variables[: self.free.numel()]).full())


def prefilter_of(problem: DesignProblem) -> SampledFilter:
    """Return the prefilter and the grids of a problem."""
    return sampled_filter(problem.duration, problem.sample_rate, problem.prefilter_time_constant)


def formulated(
    criterion: Criterion,
    information: ca.MX,
    *,
    points: SplinePoints,
    limits: tuple[Constraint, ...],
    hessian: Literal["exact", "limited-memory"],
    penalty: ca.MX | float = 0.0,
) -> Program:
    """Return the program that optimises a motion.

    Args:
        criterion: what is optimised.
        information: the motion's, shape (6, 6), an expression of the points.
        points: the motion's parameters.
        limits: what the motion has to keep.
        hessian: exact second derivatives, or the optimiser's approximation.
        penalty: added to the criterion, eq. (27).

    Source: paper eq. (27).
    """
    terms = criterion_terms(criterion, information)
    information_at = ca.Function("information", [points.free], [information])
    equality = Constraint(name="criterion", expression=terms.equality, lower=0.0, upper=0.0)

    def completed(values: Array) -> Array:
        return np.concatenate([values, terms.slack_start(information_at(values).full())])

    return Program(
        variables=ca.vertcat(points.free, terms.slack),
        cost=terms.cost + penalty,  # eq. (27)
        constraints=(*limits, equality),
        completed=completed,
        hessian=hessian,
    )
