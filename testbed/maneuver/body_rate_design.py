"""The paper's design: cubic B-splines for the body rate, from rest to rest, within the cluster's limits."""

from __future__ import annotations

import time
from collections.abc import Callable

import casadi as ca
import numpy as np

from testbed.arrays import Array
from testbed.maneuver.budget import Budget, body_rate_budget
from testbed.maneuver.criteria import Criterion
from testbed.maneuver.design import BodyRateLimits, Design, DesignProblem, Search
from testbed.maneuver.formulation import SplinePoints, formulated, prefilter_of
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.multistart import best_of_starts, compiled_stages, finished_design
from testbed.maneuver.objective import design_information
from testbed.maneuver.penalty import Penalty, sixth_power
from testbed.maneuver.program import Constraint, Program, within
from testbed.maneuver.splines import basis_matrix, clamped_spline, derivative_points_matrix

_HELD_POINTS = 2
"""Control points held at each end, so that ω and ω̇ both stand still and the gimbal servos need not jump. It costs 3 %
of the A-optimal trace of the inverse against holding ω alone."""
_INSTANTS_PER_POINT = 10
"""Instants at which a given start is met as nearly as the control points allow, and at which a tilt is limited."""


def body_rate_design(
    problem: DesignProblem,
    limits: BodyRateLimits,
    search: Search,
    penalty: Penalty | None = None,
    initial: Maneuver | None = None,
) -> Design:
    """Design the body rate, from its initial value to rest.

    Args:
        problem: criterion, duration, platform.
        limits: of the cluster, of the body rate and of the tilt.
        search: starts and seed.
        penalty: weights of the paper's soft limits, where they replace hard ones; they are overshot by 1 to 2 %. A
            tilt's stays hard.
        initial: where the optimiser starts, as the paper does from its basic profile; None draws the starts at random.

    Raises:
        InfeasibleDesignError: the limits cannot be met.

    Source: paper eqs. (8), (24)-(29).
    """
    began = time.perf_counter()
    points = _held_points(problem) if penalty is None else _open_points(problem)
    budget = body_rate_budget(problem, limits)
    stages = compiled_stages(
        problem, lambda criterion: _program(problem, criterion, budget, points, penalty, limits.tilt)
    )
    setup_seconds = time.perf_counter() - began
    draw = _draw(budget, points) if initial is None else _given(problem, points, initial)
    best = best_of_starts(stages, draw, search)
    maneuver = Maneuver(
        name=problem.name,
        duration=problem.duration,
        body_rate=clamped_spline(problem.duration, points.values(best.variables)),
    )
    return finished_design(problem, "body_rate", maneuver, best, setup_seconds)


def _held_points(problem: DesignProblem) -> SplinePoints:
    free = ca.MX.sym("body_rate", problem.control_points - 2 * _HELD_POINTS, 3)
    start = np.tile(problem.initial_body_rate, (_HELD_POINTS, 1))
    return SplinePoints(free=ca.vec(free), rows=ca.vertcat(start, free, np.zeros((_HELD_POINTS, 3))))


def _open_points(problem: DesignProblem) -> SplinePoints:
    """Leave all points free: the penalty brings the ends to rest."""
    free = ca.MX.sym("body_rate", problem.control_points, 3)
    return SplinePoints(free=ca.vec(free), rows=free)


def _draw(budget: Budget, points: SplinePoints) -> Callable[[np.random.Generator], Array]:
    scale = np.repeat(budget.rate, points.free.numel() // 3)
    return lambda rng: rng.uniform(-scale, scale)


def _given(problem: DesignProblem, points: SplinePoints, initial: Maneuver) -> Callable[[np.random.Generator], Array]:
    """Start from the spline nearest to a maneuver, whatever control points that one has."""
    time = np.linspace(0.0, problem.duration, _INSTANTS_PER_POINT * problem.control_points)
    basis = basis_matrix(problem.duration, problem.control_points, time)
    nearest = np.linalg.lstsq(basis, initial.reference(time).body_rate)[0]
    held = (problem.control_points - points.free.numel() // 3) // 2  # at each end
    values = np.asarray(nearest[held : problem.control_points - held].ravel(order="F"))
    return lambda _: values


def _program(
    problem: DesignProblem,
    criterion: Criterion,
    budget: Budget,
    points: SplinePoints,
    penalty: Penalty | None,
    tilt: float,
) -> Program:
    sampling = prefilter_of(problem)
    basis = basis_matrix(problem.duration, problem.control_points, sampling.fine_time)
    limits = _limits(problem, budget, points.rows)
    return formulated(
        criterion,
        design_information(problem, sampling, ca.DM(basis) @ points.rows),
        points=points,
        limits=(*(limits if penalty is None else ()), *_tilt_limit(problem, tilt, points.rows)),
        hessian="exact",
        penalty=0.0 if penalty is None else _penalty(problem, budget, points.rows, limits, penalty),
    )


def _limits(problem: DesignProblem, budget: Budget, points: ca.MX) -> tuple[Constraint, ...]:
    """Bound the control points of ω, J ω and J ω̇, and so the curves. Source: paper section 3, eqs. (25), (26)."""
    slopes = ca.DM(derivative_points_matrix(problem.duration, problem.control_points, 1)) @ points
    inertia = ca.DM(problem.inertia)
    return (
        within("body rate", points, budget.rate),
        within("cluster momentum", points @ inertia, budget.momentum),  # eq. (26)
        within("cluster torque", slopes @ inertia, budget.torque),  # eq. (25)
    )


def _tilt_limit(problem: DesignProblem, limit: float, points: ca.MX) -> tuple[Constraint, ...]:
    """Bound the angle θ between the body z axis and the vertical: 1 - cos θ, in shares of that of the limit."""
    if np.isinf(limit):
        return ()
    time = np.linspace(0.0, problem.duration, _INSTANTS_PER_POINT * problem.control_points)
    grids = (time[:-1], 0.5 * (time[:-1] + time[1:]), time[1:])
    rates = [ca.DM(basis_matrix(problem.duration, problem.control_points, grid)) @ points for grid in grids]
    step = _vertical_step().mapaccum(len(time) - 1)
    up_B = step(problem.initial_up_B, *(rate.T for rate in rates), np.diff(time)[None])
    return (within("tilt", 1.0 - up_B[2, :].T, 1.0 - np.cos(limit)),)


def _vertical_step() -> ca.Function:
    """One classical Runge-Kutta step of the vertical in body axes, u̇ = -ω × u, given ω at its start, middle and end."""
    up_B, step = ca.SX.sym("up", 3), ca.SX.sym("step")
    start, middle, end = (ca.SX.sym(name, 3) for name in ("start", "middle", "end"))
    first = ca.cross(up_B, start)
    second = ca.cross(up_B + step / 2.0 * first, middle)
    third = ca.cross(up_B + step / 2.0 * second, middle)
    fourth = ca.cross(up_B + step * third, end)
    after = up_B + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return ca.Function("vertical", [up_B, start, middle, end, step], [after])


def _penalty(
    problem: DesignProblem, budget: Budget, points: ca.MX, limits: tuple[Constraint, ...], weights: Penalty
) -> ca.MX:
    """Return the paper's penalty. Source: paper eq. (28)."""
    rate, momentum, torque = (sixth_power(limit) for limit in limits)
    start = (points[0, :].T - problem.initial_body_rate) / budget.rate
    end = points[-1, :].T / budget.rate
    return (
        weights.ends * (ca.sumsqr(start**3) + ca.sumsqr(end**3))
        + weights.rate * (rate + momentum)
        + weights.torque * torque
    )  # eq. (28)
