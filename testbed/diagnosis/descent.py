"""The descent of one search to the least χ²: steps, how long they may be, and which of them gain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import exp, log

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import brentq

from testbed.arrays import Array, Flags
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import MANY, UNDETERMINED, Fit, Hypothesis, bounds_of, chi_square_at, evaluated, moved
from testbed.errors import InputError
from testbed.prediction.integration import Values

_TRIALS = 16
"""Steps of a search: that for a mode that is there takes 4 to 8; for one that is not it wanders along its valley, 25
steps and more, until it is stopped. Of 126 fits of effects without a scan (cases 9 and 12 of 14 of seed 90817) none
takes more than four."""
ENOUGH = 1e-3
"""Gain in χ² that is no longer searched for; one standard error of a parameter is a gain of 1, so that 1e-3 is 3 % of
it. With 0.1, χ² ends up to 0.08 higher in the same fits."""
ROUGHLY = 0.05
"""The same of fits that another one follows, or that are compared: of hypotheses, between rounds of estimating noise.

Source: chosen; classes differ by 6, and rounds end at 0.5. In the valley of a mode that is not there, the steps from
here on were half of all."""
_DAMPING = (1e-6, 1e6)
"""Smallest and largest Levenberg-Marquardt damping, in shares of the normal matrix's diagonal: the least bends a step
by a millionth where a direction is known, the greatest makes steps of a millionth of the slope's. With a least damping
of 1e-3, χ² ends up to 0.007 higher in the fits above."""
_SHORTER = 0.25
"""Of a step that does not gain, how long the next one is at most.

Source: half of the least and the greatest of Moré (1978), 0.1 and 0.5, which he chooses between by χ² there."""
_POOR, _GOOD = 0.25, 0.75
"""Share of the gain that the linearised model has, below which the next step is half as long, and above which it may
be twice as long.

Source: Moré (1978)."""
_NEAR_RADIUS = 0.2
"""Relative error of the damping by which a step is as long as it may be: a step's length differs by less.

Source: Moré (1978) stops at a tenth of the length."""


def straight(runs: Runs, placed: tuple[Hypothesis, ...], values: Values, enough: float) -> Fit | None:
    """Return where whole steps lead from given values; None where one of them does not gain, or they do not end.

    Args:
        runs: to fit.
        placed: the effects in the model.
        values: to start from.
        enough: gain in χ² that is no longer searched for.
    """
    try:
        fit = evaluated(runs, placed, values)
    except InputError:
        return None
    for _ in range(_TRIALS):
        around = _Around.of(fit, np.ones(fit.jacobian.shape[1], dtype=bool))
        step = around.step(_DAMPING[0])
        if around.slope @ step < enough:
            return fit
        trial = _better(runs, fit, moved(fit, around.own(step)))
        if trial is None:
            return None
        fit = trial
    return None


def descended(runs: Runs, fit: Fit, free: Flags, enough: float) -> Fit:
    """Return where a search leads: Levenberg-Marquardt within a trust region, bounds kept by projection.

    Args:
        runs: to fit.
        fit: to start from.
        free: which parameters move, shape (C + what is each run's own,).
        enough: gain in χ² that is no longer searched for.

    Source: Moré, "The Levenberg-Marquardt algorithm: implementation and theory", Numerical Analysis (1978).
    """
    radius = np.inf
    for _ in range(_TRIALS):
        around = _Around.of(fit, free)
        damping, step = around.step_within(radius)
        if around.slope @ step < enough:
            break
        trial, length = _better(runs, fit, moved(fit, around.own(step))), around.length(step)
        if trial is None:
            radius = _SHORTER * length
            continue
        share = (fit.chi_square - trial.chi_square) / (around.slope @ step + damping * length**2)
        if share < _POOR:
            radius = 0.5 * length
        elif share > _GOOD or damping == _DAMPING[0]:
            radius = max(radius, 2.0 * length)
        fit = trial
    return fit


@dataclass(frozen=True, kw_only=True, eq=False)
class _Around:
    """χ² near a fit, linearised, in coordinates of which some are free to move.

    Attributes:
        slope: half of that along which χ² falls, shape (C,).
        normal: shape (C, C).
        moving: which move, shape (C,).
        ways: from coordinates to inertia parameters, shape (6, 6); None where they are these.
    """

    slope: Array
    normal: Array
    moving: Flags
    ways: Array | None

    @staticmethod
    def of(fit: Fit, free: Flags) -> _Around:
        """Return that of a fit, of whose parameters some are free."""
        slope, normal = fit.jacobian.T @ fit.residual, fit.normal
        moving = free & ~pushing_out(fit, slope)
        if fit.belief is None:
            return _Around(slope=slope, normal=normal, moving=moving, ways=None)
        ways, limits = fit.belief.ways(fit.theta)
        slope, normal = slope.copy(), normal.copy()
        slope[:6], normal[:6] = ways.T @ slope[:6], ways.T @ normal[:6]
        normal[:, :6] = normal[:, :6] @ ways
        moving[:6] &= (limits * slope[:6] <= 0.0) & (fit.belief.log_ratio_std > 0.0)
        return _Around(slope=slope, normal=normal, moving=moving, ways=ways)

    def step_within(self, radius: float) -> tuple[float, Array]:
        """Return the least damping whose step is no longer than a radius, and that step."""
        step = self.step(_DAMPING[0])
        if self.length(step) <= radius:
            return _DAMPING[0], step
        shortest = self.step(_DAMPING[1])
        if self.length(shortest) >= radius:
            return _DAMPING[1], shortest
        found = brentq(
            lambda each: log(self.length(self.step(exp(each))) / radius), *np.log(_DAMPING), xtol=_NEAR_RADIUS
        )
        return exp(found), self.step(exp(found))

    def step(self, damping: float) -> Array:
        """Return the damped step, zero where nothing moves."""
        step = np.zeros(len(self.slope))
        step[self.moving] = self._steps(damping)
        return step

    @cached_property
    def _steps(self) -> Callable[[float], Array]:
        """Steps of what moves, by their damping: of one slope there are several."""
        return steps_of(self.normal[np.ix_(self.moving, self.moving)], self.slope[self.moving])

    def length(self, step: Array) -> float:
        """Return the length of a step in standard deviations, as if each coordinate were the only one."""
        return float(np.sqrt(np.diag(self.normal) @ step**2))

    def own(self, step: Array) -> Array:
        """Return a step in the parameters themselves."""
        return step if self.ways is None else np.concatenate([self.ways @ step[:6], step[6:]])


def damped(normal: Array, slope: Array, damping: float = 0.0) -> Array:
    """Return the step that solves a normal matrix, damped by a share of its diagonal; none along what nothing shows."""
    return steps_of(normal, slope)(damping)


def steps_of(normal: Array, slope: Array) -> Callable[[float], Array]:
    """Return such steps by their damping."""
    shown = np.flatnonzero(np.diag(normal) > 0.0)
    normal = normal[np.ix_(shown, shown)]
    scale = np.sqrt(np.diag(normal))
    scaled, wanted = normal / np.outer(scale, scale), slope[shown] / scale
    solved = _by_factors(scaled, wanted) if len(shown) > MANY else _by_directions(scaled, wanted)

    def step(damping: float) -> Array:
        whole = np.zeros(len(slope))
        whole[shown] = solved(damping) / scale
        return whole

    return step


def _by_directions(matrix: Array, wanted: Array) -> Callable[[float], Array]:
    """Return what solves a symmetric matrix plus a damping, but for directions that nothing determines."""
    strength, axes = np.linalg.eigh(matrix)
    along = axes.T @ wanted

    def solved(damping: float) -> Array:
        damped_strength = strength + damping
        own = np.abs(damped_strength) > UNDETERMINED * np.abs(damped_strength).max(initial=0.0)
        return np.asarray(axes[:, own] @ (along[own] / damped_strength[own]))

    return solved


def _by_factors(matrix: Array, wanted: Array) -> Callable[[float], Array]:
    """Return the same of a large matrix, whose directions take longer to find than a few factors."""

    def solved(damping: float) -> Array:
        try:
            return np.asarray(cho_solve(cho_factor(matrix + damping * np.eye(len(matrix))), wanted))
        except LinAlgError:  # singular
            return _by_directions(matrix, wanted)(damping)

    return solved


def pushing_out(fit: Fit, step: Array) -> Flags:
    """Return which parameters lie at a bound and would go beyond it with a step, or along a slope."""
    pushing = np.zeros(len(step), dtype=bool)
    lower, upper = bounds_of(fit.placed)
    own, values = slice(6, 6 + len(lower)), fit.effect_values
    pushing[own] = ((values <= lower) & (step[own] < 0.0)) | ((values >= upper) & (step[own] > 0.0))
    return pushing


def _better(runs: Runs, fit: Fit, values: Values) -> Fit | None:
    """Return the fit at other values if χ² is not larger there.

    The samples come first: derivatives cost twice as much as the motion, and in a valley every third trial fails.
    """
    try:
        larger = chi_square_at(runs, fit.placed, values) > fit.chi_square
        return None if larger else evaluated(runs, fit.placed, values)
    except InputError:
        return None
