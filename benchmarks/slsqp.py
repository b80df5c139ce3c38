"""The body-rate design against SciPy's SLSQP on the same program from the same starts.

Run with `python -m benchmarks design`. Both sides get the same splines, limits and compiled cost; what differs is the
optimiser and the derivatives that it is given.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.optimize import Bounds, LinearConstraint, minimize

from benchmarks.ratios import Ratio
from testbed.arrays import Array
from testbed.maneuver import body_rate_design as design
from testbed.maneuver.budget import body_rate_budget
from testbed.maneuver.design import BodyRateLimits, DesignProblem
from testbed.maneuver.program import Program, solver

STARTS, SEED, MOST_ITERATIONS = 6, 1, 500
_MOST_STARTS = 1000
COMMAND = "python -m benchmarks design"


@dataclass(frozen=True, kw_only=True)
class Solved:
    """Where the starts of one optimiser ended.

    Attributes:
        seconds: of each start.
        costs: -log det Ψ_fᵀΨ_f at the end of each.
        excess: largest overshoot of a limit in any start, as a share of it.
    """

    seconds: Array
    costs: Array
    excess: float


def slsqp_ratios(problem: DesignProblem, limits: BodyRateLimits) -> list[Ratio]:
    """Return a row for each kind of gradient, all solved in turn from the same starts."""
    points = design._held_points(problem)  # the very program of the design, not a copy of it
    budget = body_rate_budget(problem, limits)
    program = design._program(problem, problem.criterion, budget, points, None, limits.tilt)
    draw = design._draw(budget, points)
    starts = [draw(np.random.default_rng(seed)) for seed in np.random.SeedSequence(SEED).spawn(STARTS)]
    ours: list[tuple[float, Array]] = []
    exact: list[tuple[float, Array]] = []
    differences: list[tuple[float, Array]] = []
    solve = solver(program)
    for start in starts:
        ours.append(_timed(lambda start=start: solve(start).variables))
        exact.append(_timed(lambda start=start: slsqp(program, start, exact_gradient=True)))
        differences.append(_timed(lambda start=start: slsqp(program, start, exact_gradient=False)))
    mine = _solved(program, ours)
    seeds = iter(np.random.SeedSequence(SEED).spawn(_MOST_STARTS))
    many: list[tuple[float, Array]] = []
    while sum(seconds for seconds, _ in many) < mine.seconds.sum():
        start = draw(np.random.default_rng(next(seeds)))
        many.append(_timed(lambda start=start: slsqp(program, start, exact_gradient=True)))
    return [
        _row(mine, _solved(program, exact), "our exact gradient"),
        _row(mine, _solved(program, differences), "finite differences"),
        _equal_time_row(mine, _solved(program, many)),
    ]


def slsqp(program: Program, start: Array, *, exact_gradient: bool) -> Array:
    """Return where SLSQP ends; the limits are linear, and their matrix is given to it either way."""
    cost = ca.Function("cost", [program.variables], [program.cost])
    gradient = ca.Function("gradient", [program.variables], [ca.gradient(program.cost, program.variables)])
    limits = ca.vertcat(*(limit.expression for limit in program.constraints))
    linear = ca.Function("linear", [program.variables], [limits, ca.jacobian(limits, program.variables)])
    offset, matrix = (part.full() for part in linear(np.zeros(len(start))))
    lower, upper = (np.concatenate(side) for side in zip(*(limit.bounds for limit in program.constraints), strict=True))
    return np.asarray(
        minimize(
            lambda values: float(cost(values)),
            start,
            method="SLSQP",
            jac=(lambda values: gradient(values).full().ravel()) if exact_gradient else "2-point",
            constraints=LinearConstraint(matrix, lower - offset.ravel(), upper - offset.ravel()),
            bounds=Bounds(-np.inf, np.inf),
            options={"maxiter": MOST_ITERATIONS, "ftol": 1e-6},  # of the cost; IPOPT's tolerance is 1e-6 too
        ).x
    )


def _timed(solve: Callable[[], Array]) -> tuple[float, Array]:
    began = time.perf_counter()
    values = solve()
    return time.perf_counter() - began, values


def _solved(program: Program, ended: list[tuple[float, Array]]) -> Solved:
    limits = ca.vertcat(*(limit.expression for limit in program.constraints))
    figures = ca.Function("figures", [program.variables], [program.cost, limits])
    costs, values = zip(*(figures(variables) for _, variables in ended), strict=True)
    lower, upper = (np.concatenate(side) for side in zip(*(limit.bounds for limit in program.constraints), strict=True))
    reached = np.array([value.full().ravel() for value in values])
    return Solved(
        seconds=np.array([seconds for seconds, _ in ended]),
        costs=np.array([float(cost) for cost in costs]),
        excess=float(np.maximum(lower - reached, reached - upper).max(initial=0.0)),
    )


def _equal_time_row(ours: Solved, theirs: Solved) -> Ratio:
    return Ratio(
        what="the same, best determinant in equal time, SLSQP with our exact gradient",
        ours=f"{np.exp(-ours.costs.min()):.3g}, best of {len(ours.costs)} starts",
        theirs=f"SLSQP {np.exp(-theirs.costs.min()):.3g}, best of {len(theirs.costs)}",
        ratio=float(np.exp(theirs.costs.min() - ours.costs.min())),
        target="",
        command=COMMAND,
        note=f"determinant of Ψ_fᵀΨ_f; {ours.seconds.sum():.1f} s each",
    )


def _row(ours: Solved, theirs: Solved, gradient: str) -> Ratio:
    share = np.exp(ours.costs - theirs.costs)  # of determinants
    return Ratio(
        what=f"body-rate D design, 24 points, against SciPy's SLSQP with {gradient}",
        ours=f"{np.median(ours.seconds):.2f} s a start",
        theirs=f"SLSQP {np.median(theirs.seconds):.2f} s a start",
        ratio=float(np.median(theirs.seconds / ours.seconds)),
        target="",
        command=COMMAND,
        note=f"medians of {STARTS} starts in turn; best determinant theirs / ours "
        f"{np.exp(ours.costs.min() - theirs.costs.min()):.3f}, start by start {share.min():.3f} to {share.max():.3f}; "
        f"limits overshot by {ours.excess:.0e} (ours), {theirs.excess:.0e}",
    )
