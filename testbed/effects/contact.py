"""The platform touches something once: its momentum jumps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.estimation.contact import likeliest_jumps
from testbed.prediction.grid import Grid, begin_of_runs
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario

SPREAD = 0.02
"""s, standard deviation in time of the touch: it fits between samples at 16 Hz, and the nearest still show its slope.

With 0.01 s half of the searches that began 0.03 s or less from the instant were led astray; with 0.02 s, none of 16.
"""
_OF_INTERVAL = 0.4
"""The same in intervals of a faster gyro, which shows a shorter touch: at 50 Hz a bell of 0.02 s was 9 σ off.

Source: chosen: 0.02 s are a third of one at 16 Hz; 0.25 to 0.4 suit a touch of 20 ms at 50 and 100 Hz alike."""
_OF_STEP = 0.5
"""The same in steps of the integration, below which its rule misses a part of the bell.

Source: formula: Simpson's rule then misses 2/3 exp(-π²/2) of a bell at most, 0.5 % (Poisson's sum over whole steps)."""
STARTS = 8
"""Instants that are searched from, over all runs: as many as hypotheses are refitted; each costs a linearisation."""


def _of_jumps(grid: Grid, run: int | None = None) -> list[float]:
    """Return the instants of the likeliest jumps in all runs laid end to end, or in one of them."""
    found = [
        (score, instant + begin)
        for number, (own, begin) in enumerate(zip(grid.runs, begin_of_runs(grid), strict=True))
        if run in (None, number)
        for score, instant in likeliest_jumps(own, STARTS)
    ]
    return [instant for _, instant in sorted(found, reverse=True)[:STARTS]]


class _Touch(Hooks):
    @override
    def applied_torque(self, torque_B: Array, value: Array, grid: Grid) -> Array:
        """Add the impulse as a bell of torque; value holds its time, in the runs laid end to end, and its size."""
        late = (grid.time + begin_of_runs(grid)[:, None])[:, None] - value[:, :1]
        spread = np.clip(_OF_INTERVAL * grid.gyro_interval, _OF_STEP * grid.step, SPREAD)[:, None, None]
        bell = np.exp(-0.5 * (late / spread) ** 2) / (spread * np.sqrt(2.0 * np.pi))
        return np.asarray(torque_B + bell[..., None] * value[:, None, 1:])


@final
class Contact(Effect):
    """An impulse, body axes, at an instant counted in the runs laid end to end, a pause of a second between them."""

    id = "contact"
    components = ("platform",)
    parameters = (
        Parameter(
            name="time_s", unit="s", typical=0.8, lower=0.0, upper=1e4, absent=0.8, scanned=True, plausible=(0.0, 1e4)
        ),
        *(Parameter(name=f"impulse_{axis}_N_m_s", unit="N·m·s", typical=2e-4) for axis in "xyz"),
    )
    sentence = "The platform touched something once: its momentum jumped."
    look_alikes = ()
    confirm = "The camera's picture of that instant; the same maneuver again, in which it does not come back."
    flies = False
    recurs = False
    instant = "time_s"

    def __init__(self, instants: Sequence[float] = ()) -> None:
        """Take the instants to search from, s, in the runs laid end to end; where none, those of jumps in them."""
        self._instants = tuple(instants)

    @classmethod
    def within(cls, grid: Grid, run: int) -> Contact:
        """Return a touch in one run."""
        return cls(_of_jumps(grid, run))

    @override
    def hooks(self, component: str) -> Hooks:
        return _Touch()

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        """The instants at which a jump of the momentum explains most of the measured rates."""
        instants = self._instants or _of_jumps(grid)
        return np.array([[instant, 0.0, 0.0, 0.0] for instant in instants])

    @override
    def unresolved(self, grid: Grid) -> Array:
        """When between two samples of the gyro: an impulse is shorter than the bell, which fits in their middle."""
        interval = float(np.median(np.concatenate([np.diff(run.gyro_time) for run in grid.runs])))
        return np.array([interval / np.sqrt(12.0), 0.0, 0.0, 0.0])

    @override
    def scan_count(self, component: str, grid: Grid) -> int:
        """An instant for every sample of the gyro."""
        return sum(len(run.gyro_time) for run in grid.runs)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        """Nothing: what is touched once does not belong to the platform, and the next flight need not touch it."""
        return Extension()
