"""Table 1: the basic profile and four criteria, designed as the paper did it, as this project does, in gimbal space."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from testbed.assembly.maneuver import body_rate_limits, design_problem, gimbal_limits
from testbed.assembly.platform import nominal_platform
from testbed.maneuver.body_rate_design import body_rate_design
from testbed.maneuver.criteria import Criterion
from testbed.maneuver.design import Design, DesignProblem, Search
from testbed.maneuver.gimbal_design import gimbal_design
from testbed.maneuver.information import Information, maneuver_information
from testbed.maneuver.maneuver import Maneuver
from testbed.maneuver.penalty import Penalty
from testbed.maneuver.profiles import basic_profile
from testbed.reproduction.progress import Progress, silent
from testbed.reproduction.scenarios import paper_scenario
from testbed.scenario.maneuver import BodyRateDesign, GimbalDesign

Way: TypeAlias = Literal["given", "paper", "hard", "gimbal"]
"""How a maneuver came about: not designed; penalty and one start from the basic profile; hard limits and many starts;
the same in gimbal space."""
CRITERIA: tuple[Criterion, ...] = ("A", "D", "E", "condition")
"""In the order of the paper's rows."""
HARD_POINTS = 20
"""Control points of the designs with hard limits: more gain under 5 % of the trace of the inverse."""

_INSTANTS = 501
"""At which a peak is looked for; between them a spline of 20 points gains less than 1e-4 of it."""


@dataclass(frozen=True, kw_only=True)
class PaperRow:
    """A row of the paper's Table 1.

    Attributes:
        min_eigenvalue: of Ψ_fᵀΨ_f, as are the next two.
        trace_inverse: trace of the inverse.
        determinant: product of the eigenvalues.
        regressor_condition_number: of Ψ_f itself, not of Ψ_fᵀΨ_f: the only reading that fits the other columns.
    """

    min_eigenvalue: float
    trace_inverse: float
    determinant: float
    regressor_condition_number: float


def _paper(*figures: float) -> PaperRow:
    return PaperRow(
        min_eigenvalue=figures[0],
        trace_inverse=figures[1],
        determinant=figures[2],
        regressor_condition_number=figures[3],
    )


PAPER: Mapping[str, PaperRow] = {
    "basic": _paper(0.099, 21.27, 0.0036, 3.271),
    "A": _paper(1.663, 2.431, 330.6, 1.546),
    "D": _paper(1.683, 2.434, 331.3, 1.568),
    "E": _paper(1.746, 2.528, 253.8, 1.465),
    "condition": _paper(1.532, 2.883, 115.3, 1.426),
}
"""By maneuver. Source: paper Table 1."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One maneuver of Table 1; numbers and words only.

    Attributes:
        name: "basic", or the criterion.
        way: how it came about.
        min_eigenvalue: of Ψ_fᵀΨ_f at 16 Hz, as are the next two.
        trace_inverse: trace of the inverse.
        determinant: product of the eigenvalues.
        regressor_condition_number: of Ψ_f, as in the paper's table.
        condition_number: of Ψ_fᵀΨ_f, its square.
        peak_rate: largest body rate about any axis, rad/s.
        control_points: of each spline; 0 for what is not designed.
        starts: of the optimiser; 0 likewise.
        seconds: for all of them, the set-up included.
        paper: the paper's row of this name.
    """

    name: str
    way: Way
    min_eigenvalue: float
    trace_inverse: float
    determinant: float
    regressor_condition_number: float
    condition_number: float
    peak_rate: float
    control_points: int
    starts: int
    seconds: float
    paper: PaperRow


@dataclass(frozen=True, kw_only=True)
class Table1:
    """All rows, and the maneuvers behind them.

    Attributes:
        rows: basic first, then way by way in the paper's order.
        maneuvers: by way and name, as in ("paper", "D"), the paper's figure 2, and ("given", "basic"), its figure 1.
    """

    rows: tuple[Row, ...]
    maneuvers: Mapping[tuple[Way, str], Maneuver]


class _Task(NamedTuple):
    """One design to be made."""

    way: Way
    criterion: Criterion
    problem: DesignProblem
    starts: int
    design: Callable[[DesignProblem, Search], Design]


class _Entry(NamedTuple):
    row: Row
    maneuver: Maneuver


def table1(progress: Progress = silent, *, quick: bool = False) -> Table1:
    """Design all maneuvers of Table 1 on the shipped platform.

    Args:
        progress: called with each design as it ends.
        quick: one start each.

    Source: paper section 5.1, Table 1.
    """
    tasks = [*_body_rate_tasks(1 if quick else 4), *_gimbal_tasks(quick)]
    advance = progress("Table 1, designs", len(tasks))
    entries = [_basic_entry(tasks[0].problem)]
    for task in tasks:
        entries.append(_entry(task))
        advance(1)
    return Table1(
        rows=tuple(entry.row for entry in entries),
        maneuvers={(entry.row.way, entry.row.name): entry.maneuver for entry in entries},
    )


def _body_rate_tasks(starts: int) -> list[_Task]:
    scenario = paper_scenario("paper_d_optimal")
    section = scenario.maneuver
    assert isinstance(section, BodyRateDesign)
    problem, limits = design_problem(scenario, section, nominal_platform(scenario)), body_rate_limits(scenario, section)
    basic = basic_profile(duration=problem.duration)

    def as_the_paper(asked: DesignProblem, search: Search) -> Design:
        return body_rate_design(asked, limits, search, Penalty(), initial=basic)  # eqs. (27)-(29)

    def as_this_project(asked: DesignProblem, search: Search) -> Design:
        return body_rate_design(asked, limits, search)

    return [
        *_tasks("paper", problem, dict.fromkeys(CRITERIA, 1), as_the_paper),
        *_tasks("hard", replace(problem, control_points=HARD_POINTS), dict.fromkeys(CRITERIA, starts), as_this_project),
    ]


def _gimbal_tasks(quick: bool) -> list[_Task]:
    scenario = paper_scenario("gimbal_d_optimal")
    section = scenario.maneuver
    assert isinstance(section, GimbalDesign)
    limits = gimbal_limits(scenario, section)
    smooth = 1 if quick else 3
    starts: Mapping[Criterion, int] = {"A": smooth, "D": smooth, "E": 1, "condition": 1}  # these take 6 and 19 s each
    problem = design_problem(scenario, section, nominal_platform(scenario))
    return _tasks("gimbal", problem, starts, lambda asked, search: gimbal_design(asked, limits, search))


def _tasks(
    way: Way,
    problem: DesignProblem,
    starts: Mapping[Criterion, int],
    design: Callable[[DesignProblem, Search], Design],
) -> list[_Task]:
    return [
        _Task(
            way, criterion, replace(problem, criterion=criterion, name=f"{criterion}, {way}"), starts[criterion], design
        )
        for criterion in CRITERIA
    ]


def _basic_entry(problem: DesignProblem) -> _Entry:
    maneuver = basic_profile(duration=problem.duration)
    information = maneuver_information(maneuver, problem.sample_rate, problem.prefilter_time_constant)
    return _Entry(_row("basic", "given", information, maneuver, control_points=0, starts=0, seconds=0.0), maneuver)


def _entry(task: _Task) -> _Entry:
    began = time.perf_counter()
    design = task.design(task.problem, Search(starts=task.starts, seed=1))
    row = _row(
        task.criterion,
        task.way,
        design.information,
        design.maneuver,
        control_points=task.problem.control_points,
        starts=task.starts,
        seconds=time.perf_counter() - began,
    )
    return _Entry(row, design.maneuver)


def _row(
    name: str,
    way: Way,
    information: Information,
    maneuver: Maneuver,
    *,
    control_points: int,
    starts: int,
    seconds: float,
) -> Row:
    return Row(
        name=name,
        way=way,
        min_eigenvalue=information.min_eigenvalue,
        trace_inverse=information.trace_inverse,
        determinant=information.determinant,
        regressor_condition_number=information.regressor_condition_number,
        condition_number=information.condition_number,
        peak_rate=_peak_rate(maneuver),
        control_points=control_points,
        starts=starts,
        seconds=seconds,
        paper=PAPER[name],
    )


def _peak_rate(maneuver: Maneuver) -> float:
    return float(np.abs(maneuver.reference(np.linspace(0.0, maneuver.duration, _INSTANTS)).body_rate).max())
