"""Touches: when they may have been, and whether one is one, as what happens once shows in one run.

Jumps of the momentum along the measured motion say when: of a platform with a large drag it changes without a touch,
and the residual of a model that has the drag says it better. A torque of a law that no formula has leaves a residual in
every run, and an impulse explains some of it wherever it is put: no touch has a name where one explains as much in most
runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import scipy

from testbed.diagnosis.candidates import Candidate, Screening, accepted
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, Hypothesis, squares_within
from testbed.diagnosis.signatures import signatures
from testbed.diagnosis.torque_shapes import shape_knots
from testbed.diagnosis.torque_space import normal, torque_space
from testbed.effects.contact import STARTS, Contact
from testbed.estimation.contact import JUMP_CHANCE, peaks
from testbed.prediction.grid import begin_of_runs, run_at

_AS_MUCH = 1.0 / 3.0
"""Share of what a touch explains from which on another explains as much in its run.

Source: chosen: runs differ by a factor of three in what any effect explains of them."""

_MOST_KNOTS = 600
"""Of all runs together, up to which impulses at each are tried: 288 take 0.15 s. The jumps say when in longer ones."""


def touching_by_residual(runs: Runs, fit: Fit, hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return hypotheses, touches searched from where impulses explain the most of the residual of a model with effects.

    Args:
        runs: that are fitted.
        fit: the present model.
        hypotheses: effects that are not in it.
    """
    number = shape_knots(runs) * len(runs.names)
    touched = any(isinstance(each.effect, Contact) for each in hypotheses)
    if all(each.given for each in fit.placed) or not touched or number > _MOST_KNOTS:
        return list(hypotheses)
    instants = _likeliest_impulses(runs, fit)
    return [
        replace(each, effect=Contact(instants)) if isinstance(each.effect, Contact) else each for each in hypotheses
    ]


def _likeliest_impulses(runs: Runs, fit: Fit) -> list[float]:
    """Return the instants, in the runs laid end to end, at which an impulse explains the most, the best first."""
    knots, found = shape_knots(runs), list[tuple[float, float]]()
    of_runs = zip(runs.grid.runs, torque_space(runs, fit, knots).at_knots(), begin_of_runs(runs.grid), strict=True)
    for run, moved, begin in of_runs:
        gains, _ = squares_within(*normal([moved]))
        found += peaks(gains, np.linspace(run.gyro_time[0], run.gyro_time[-1], knots) + begin, STARTS)
    return [instant for _, instant in sorted(found, reverse=True)[:STARTS]]


def without_common_touch(runs: Runs, fit: Fit, screening: Screening) -> Screening:
    """Return a screening without a touch that would be named, if touches explain as much in most other runs.

    Args:
        runs: that are fitted.
        fit: the present model.
        screening: against it.
    """
    chosen = accepted(screening)
    if chosen is None or not isinstance(chosen.effect, Contact) or not _is_common(runs, fit, chosen):
        return screening
    kept = tuple(each for each in screening.candidates if not isinstance(each.effect, Contact))
    return replace(screening, candidates=kept)


def _is_common(runs: Runs, fit: Fit, chosen: Candidate) -> bool:
    others = sorted(_explained_elsewhere(runs, fit, chosen))
    if not others:
        return False
    in_most = others[(len(others) - 1) // 2]  # of two both, as one may have a touch of its own
    samples = sum(len(run.gyro_time) for run in runs.grid.runs) / len(runs.grid.runs)
    by_chance = float(scipy.stats.chi2.isf(JUMP_CHANCE / samples, 3))
    return in_most > max(by_chance, _AS_MUCH * chosen.chi_square_reduction)


def _explained_elsewhere(runs: Runs, fit: Fit, chosen: Candidate) -> Iterator[float]:
    """Yield by how much the best touch in every other run lowers χ², linearised."""
    (instant, *_) = chosen.fit.effect_values[chosen.fit.own(chosen.placed)]
    own = run_at(runs.grid, float(instant))
    for run in range(len(runs.grid.runs)):
        if run != own:
            touch = replace(chosen.placed, effect=Contact.within(runs.grid, run))
            yield max((each.score for each in signatures(runs, fit, [touch])), default=0.0)
