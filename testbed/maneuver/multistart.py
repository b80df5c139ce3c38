"""Many seeded starts of one program; the best of them is the design."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array
from testbed.errors import InfeasibleDesignError
from testbed.maneuver.criteria import Criterion
from testbed.maneuver.design import Design, DesignProblem, Parametrization, Search, Start
from testbed.maneuver.information import maneuver_information
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.program import Program, Solution, Solver, solver

_LEADING: Criterion = "D"


class Best(NamedTuple):
    """The best of the starts.

    Attributes:
        variables: of the last stage's program.
        starts: all of them, in order.
        winner: index of the best.
    """

    variables: Array
    starts: tuple[Start, ...]
    winner: int


def compiled_stages(problem: DesignProblem, program_of: Callable[[Criterion], Program]) -> tuple[Solver, ...]:
    """Return the D criterion and then the problem's own, which starts from what D found.

    The determinant is smooth everywhere and forgives a poor start. From random motions the other criteria take up to
    five times as long and end in worse optima than D's, even by their own figure.

    Args:
        problem: with the criterion.
        program_of: formulates the problem for a criterion.
    """
    return tuple(solver(program_of(criterion)) for criterion in dict.fromkeys((_LEADING, problem.criterion)))


def best_of_starts(stages: tuple[Solver, ...], draw: Callable[[np.random.Generator], Array], search: Search) -> Best:
    """Solve from random starts and keep the best that stays within the limits.

    Args:
        stages: solved one after the other.
        draw: initial values of the motion's free parameters.
        search: how many starts, from which seed.

    Raises:
        InfeasibleDesignError: no start kept all limits; the message names those missed, and by how much.
    """
    solutions: list[Solution] = []
    starts: list[Start] = []
    for index, seed in enumerate(np.random.SeedSequence(search.seed).spawn(search.starts)):
        began = time.perf_counter()
        solution = _solved(stages, draw(np.random.default_rng(seed)))
        seconds = time.perf_counter() - began
        start = Start(index=index, cost=_usable_cost(solution), seconds=seconds, status=solution.status)
        solutions.append(solution)
        starts.append(start)
        search.progress(start)
    best = min(range(search.starts), key=lambda index: starts[index].cost)
    if not isfinite(starts[best].cost):
        raise InfeasibleDesignError(_complaint(solutions))
    return Best(variables=solutions[best].variables, starts=tuple(starts), winner=best)


def _solved(stages: tuple[Solver, ...], values: Array) -> Solution:
    """Solve one stage after the other; what the first cannot keep within the limits, no later one can."""
    count = len(values)
    for solve in stages:
        solution = solve(values[:count])
        if not isfinite(_usable_cost(solution)):
            break
        values = solution.variables
    return solution


def _usable_cost(solution: Solution) -> float:
    return solution.cost if not solution.excess and isfinite(solution.cost) else inf


def finished_design(
    problem: DesignProblem, parametrization: Parametrization, maneuver: Maneuver, best: Best, setup_seconds: float
) -> Design:
    """Return a maneuver with its figures and how it was found.

    Args:
        problem: what was asked for.
        parametrization: what its splines describe.
        maneuver: the best start's.
        best: all starts.
        setup_seconds: time before the first start, s.
    """
    return Design(
        maneuver=maneuver,
        criterion=problem.criterion,
        parametrization=parametrization,
        information=maneuver_information(maneuver, problem.sample_rate, problem.prefilter_time_constant),
        starts=best.starts,
        best=best.winner,
        setup_seconds=setup_seconds,
    )


def _complaint(solutions: list[Solution]) -> str:
    """Name the limits that the start nearest to feasible could not keep together."""
    nearest = min(solutions, key=lambda solution: max(solution.excess.values(), default=inf))
    missed = "; ".join(f"{name} by {excess:.2g} of its limit" for name, excess in nearest.excess.items())
    return (
        f"none of {len(solutions)} starts kept all limits together. The nearest misses "
        f"{missed or 'none, but diverged'} (optimiser: {nearest.status}). "
        "Relax one of these, lengthen the maneuver, or use more control points"
    )
