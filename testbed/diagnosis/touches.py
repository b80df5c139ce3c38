"""Whether a touch is one: what happens once shows in one run, what a model lacks shows in most.

A torque of a law that no formula has leaves a residual in every run, and an impulse explains some of it wherever it is
put. So a touch gets no name where one explains as much in most other runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import scipy

from testbed.diagnosis.candidates import Candidate, Screening, accepted
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.signatures import signatures
from testbed.effects.contact import Contact
from testbed.estimation.contact import JUMP_CHANCE
from testbed.prediction.grid import run_at

_AS_MUCH = 1.0 / 3.0
"""Share of what a touch explains from which on another explains as much in its run.

Source: chosen: runs differ by a factor of three in what any effect explains of them."""


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
