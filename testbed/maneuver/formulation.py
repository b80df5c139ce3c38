"""From a parametrised motion and a criterion to the program that optimises it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import casadi as ca
import numpy as np

from testbed.arrays import Array
from testbed.maneuver.criteria import criterion_terms, information_matrix
from testbed.maneuver.design import DesignProblem
from testbed.maneuver.information import SampledFilter, sampled_filter
from testbed.maneuver.program import Constraint, Program


def prefilter_of(problem: DesignProblem) -> SampledFilter:
    """Return the prefilter and the grids of a problem."""
    return sampled_filter(problem.duration, problem.sample_rate, problem.prefilter_time_constant)


def formulated(
    problem: DesignProblem,
    *,
    free: ca.MX,
    fine_body_rate: ca.MX,
    limits: tuple[Constraint, ...],
    draw: Callable[[np.random.Generator], Array],
    hessian: Literal["exact", "limited-memory"],
    penalty: ca.MX | float = 0.0,
) -> Program:
    """Return the program that optimises a motion.

    Args:
        problem: criterion and prefilter.
        free: the motion's free parameters, a column.
        fine_body_rate: ω on the prefilter's fine grid as their expression, shape (M, 3), rad/s.
        limits: what the motion has to keep.
        draw: initial values of the free parameters.
        hessian: exact second derivatives, or the optimiser's approximation.
        penalty: added to the criterion, eq. (27).

    Source: paper eq. (27).
    """
    information = information_matrix(prefilter_of(problem), fine_body_rate)
    terms = criterion_terms(problem.criterion, information)
    information_at = ca.Function("information", [free], [information])
    equality = Constraint(name="criterion", expression=terms.equality, lower=0.0, upper=0.0)

    def random_start(rng: np.random.Generator) -> Array:
        values = draw(rng)
        return np.concatenate([values, terms.slack_start(information_at(values).full())])

    return Program(
        variables=ca.vertcat(free, terms.slack),
        cost=terms.cost + penalty,  # eq. (27)
        constraints=(*limits, equality),
        random_start=random_start,
        hessian=hessian,
    )
