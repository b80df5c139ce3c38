"""Many seeded starts of one program; the best of them is the design."""

from __future__ import annotations

import time
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array
from testbed.errors import InfeasibleDesignError
from testbed.maneuver.design import Design, DesignProblem, Parametrization, Search, Start
from testbed.maneuver.information import maneuver_information
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.program import Program, Solution, Solver


class Best(NamedTuple):
    """The best of the starts.

    Attributes:
        variables: of the program.
        starts: all of them, in order.
        winner: index of the best.
    """

    variables: Array
    starts: tuple[Start, ...]
    winner: int


def best_of_starts(program: Program, solve: Solver, search: Search) -> Best:
    """Solve a program from random starts and keep the best that stays within the limits.

    Args:
        program: what to solve.
        solve: its compiled solver.
        search: how many starts, from which seed.

    Raises:
        InfeasibleDesignError: no start kept all limits; the message names those missed, and by how much.
    """
    solutions: list[Solution] = []
    starts: list[Start] = []
    for index, seed in enumerate(np.random.SeedSequence(search.seed).spawn(search.starts)):
        solution, start = _timed(solve, program.random_start(np.random.default_rng(seed)), index)
        solutions.append(solution)
        starts.append(start)
        search.progress(start)
    best = min(range(search.starts), key=lambda index: starts[index].cost)
    if not isfinite(starts[best].cost):
        raise InfeasibleDesignError(_complaint(solutions))
    return Best(variables=solutions[best].variables, starts=tuple(starts), winner=best)


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


def _timed(solve: Solver, initial: Array, index: int) -> tuple[Solution, Start]:
    began = time.perf_counter()
    solution = solve(initial)
    seconds = time.perf_counter() - began
    usable = not solution.excess and isfinite(solution.cost)
    cost = solution.cost if usable else inf
    return solution, Start(index=index, cost=cost, seconds=seconds, status=solution.status)


def _complaint(solutions: list[Solution]) -> str:
    """Name the limits that the start nearest to feasible could not keep together."""
    nearest = min(solutions, key=lambda solution: max(solution.excess.values(), default=inf))
    missed = "; ".join(f"{name} by {excess:.2g} of its limit" for name, excess in nearest.excess.items())
    return (
        f"none of {len(solutions)} starts kept all limits together. The nearest misses "
        f"{missed or 'none, but diverged'} (optimiser: {nearest.status}). "
        "Relax one of these, lengthen the maneuver, or use more control points"
    )
