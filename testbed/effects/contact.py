"""The platform touches something once: its momentum jumps."""

from __future__ import annotations

from typing import final

import numpy as np
from scipy.stats import chi2
from typing_extensions import override

from testbed.arrays import Array, Flags, Series
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.estimation.momentum_equation import momentum_equation
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario

SPREAD = 0.02
"""s, standard deviation in time of the touch: it fits between samples at 16 Hz, and the nearest still show its slope.

With 0.01 s half of the searches that began 0.03 s or less from the instant were led astray; with 0.02 s, none of 16.
"""
PAUSE = 1.0
"""s between the runs, laid end to end: fifty times the spread of a touch, so that none is in two runs, and an estimated
instant stays in its own."""
_STARTS = 8
"""Instants that are searched from, over all runs: as many as hypotheses are refitted; each costs a linearisation."""
_APART = 0.2
"""s; nearer instants of a run are the same touch: ten spreads, while a search that begins 0.03 s from an instant
arrives there."""
_CHANCE = 1e-3
"""p-value of a jump anywhere in a run, times its samples (Bonferroni), below which the run shows one, and is fitted
rather than held out: of the five runs of 200 sets one has it by chance."""
_DEPENDENT = 1e-9
"""Share of the largest singular value below which a direction of a jump is not seen, as `NEGLIGIBLE` in the
diagnosis."""


class _Touch(Hooks):
    @override
    def applied_torque(self, torque_B: Array, value: Array, grid: Grid) -> Array:
        """Add the impulse as a bell of torque; value holds its time, in the runs laid end to end, and its size."""
        late = (grid.time + begin_of_runs(grid)[:, None])[:, None] - value[:, :1]
        bell = np.exp(-0.5 * (late / SPREAD) ** 2) / (SPREAD * np.sqrt(2.0 * np.pi))
        return np.asarray(torque_B + bell[..., None] * value[:, None, 1:])


def begin_of_runs(grid: Grid) -> Series:
    """Return what has to be added to each run's times to lay the runs end to end, shape (R,), s; the first from 0."""
    spans = grid.time[:, -1] - grid.time[:, 0] + PAUSE
    return np.asarray(np.cumsum(spans) - spans - grid.time[:, 0])


@final
class Contact(Effect):
    """An impulse, body axes, at an instant counted in the runs laid end to end, a pause of a second between them."""

    id = "contact"
    components = ("platform",)
    parameters = (
        Parameter(name="time_s", unit="s", typical=0.8, lower=0.0, upper=1e4, absent=0.8, scanned=True),
        *(Parameter(name=f"impulse_{axis}_N_m_s", unit="N·m·s", typical=2e-4) for axis in "xyz"),
    )
    sentence = "The platform touched something once: its momentum jumped."
    look_alikes = ()
    confirm = "The camera's picture of that instant; the same maneuver again, in which it does not come back."
    flies = False
    recurs = False

    @override
    def hooks(self, component: str) -> Hooks:
        return _Touch()

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        """The instants at which the momentum equation of the measured rates likes a jump best."""
        found = [
            (score, instant + begin)
            for run, begin in zip(grid.runs, begin_of_runs(grid), strict=True)
            for score, instant in _likeliest(run)
        ]
        instants = [instant for _, instant in sorted(found, reverse=True)[:_STARTS]]
        return np.array([[instant, 0.0, 0.0, 0.0] for instant in instants])

    @override
    def places(self, component: str, grid: Grid) -> int:
        """An instant for every sample of the gyro."""
        return sum(len(run.gyro_time) for run in grid.runs)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        """Nothing: what is touched once does not belong to the platform, and the next flight need not touch it."""
        return Extension()


def shows_a_jump(run: Telemetry) -> bool:
    """Return whether a jump of the momentum explains more of a run than chance would at any of its samples."""
    found = _likeliest(run)
    return bool(found) and bool(len(run.gyro_time) * chi2.sf(found[0][0], 3) < _CHANCE)


def _likeliest(run: Telemetry) -> list[tuple[float, float]]:
    """Return the instants between samples at which a jump of the momentum explains the most, best first.

    Γ(ω) θ - Rᵀ (H₀ + ΔH after the instant) = Y is linear in θ, H₀ and ΔH. With each instant stands twice the logarithm
    of the likelihood ratio with and without the jump.
    """
    equation = momentum_equation(run, run.body_rate)
    rows = equation.regressor[..., :9].reshape(-1, 9)
    basis = np.linalg.qr(rows / np.linalg.norm(rows, axis=0))[0]
    response = equation.response.ravel()
    residual = response - basis @ (basis.T @ response)
    later = np.arange(len(run.gyro_time))
    scores = np.array([_explained(rows[:, 6:], later >= first, basis, residual) for first in later[1:]])
    share = np.clip(scores / max(float(residual @ residual), np.finfo(float).tiny), 0.0, 1.0 - np.finfo(float).eps)
    return _peaks(-len(residual) * np.log1p(-share), (run.gyro_time[1:] + run.gyro_time[:-1]) / 2.0)


def _explained(turned: Array, after: Flags, basis: Array, residual: Array) -> float:
    """Return by how much a jump lowers the sum of squares."""
    jump = turned * np.repeat(after, 3)[:, None]
    free = jump - basis @ (basis.T @ jump)
    step = np.linalg.lstsq(free, residual, rcond=_DEPENDENT)[0]
    return float(residual @ (free @ step))


def _peaks(scores: Series, instants: Series) -> list[tuple[float, float]]:
    """Return score and instant, best first, none near a better one."""
    kept: list[tuple[float, float]] = []
    for index in np.argsort(scores)[::-1]:
        if len(kept) < _STARTS and all(abs(instants[index] - instant) > _APART for _, instant in kept):
            kept.append((float(scores[index]), float(instants[index])))
    return kept
