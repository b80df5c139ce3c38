"""A model fitted to runs: by maximum likelihood, from several starts, in the torque's noise, less the gyro's errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import exp, log

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import brentq

from testbed.arrays import Array, Flags, Theta
from testbed.diagnosis.belief import Belief
from testbed.diagnosis.data import Runs
from testbed.diagnosis.keeping import Content, array_from_content, array_to_content, part
from testbed.diagnosis.model import (
    MANY,
    UNDETERMINED,
    Fit,
    Hypothesis,
    bounds_of,
    chi_square_at,
    evaluated,
    moved,
    recurring,
)
from testbed.diagnosis.settings import SETTINGS
from testbed.errors import InputError
from testbed.estimation.torque_noise import torque_noise
from testbed.prediction.grid import Grid, with_late_angles
from testbed.prediction.gyro import lateness
from testbed.prediction.integration import Values
from testbed.prediction.prediction import (
    common_size,
    predicted_channels,
    without_gyro_errors,
)

_TRIALS = 16
"""Steps of a search: that for a mode that is there takes 4 to 8; for one that is not it wanders along its valley, 25
steps and more, until it is stopped. Of 126 fits of effects without a scan (cases 9 and 12 of 14 of seed 90817) none
takes more than four."""
ENOUGH = 1e-3
"""Gain in χ² that is no longer searched for; one standard error of a parameter is a gain of 1, so that 1e-3 is 3 % of
it. With 0.1, χ² ends up to 0.08 higher in the same fits."""
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


def fitted(
    runs: Runs, placed: Sequence[Hypothesis], theta: Theta, starts: Sequence[Array], near: Fit | None = None
) -> Fit:
    """Fit inertia, initial rates, trims where they are free, and effects by maximum likelihood.

    Args:
        runs: to fit.
        placed: the effects in the model.
        theta: to start from, shape (6,), kg·m².
        starts: of each effect's parameters, shapes (K,).
        near: another model of the same runs, with whose initial rates and trims to begin, if that leads straight on.

    Raises:
        InputError: the nominal motion leaves the finite numbers.
    """
    effects = [start[None] for start in starts]
    begun = (
        [theta]
        if runs.belief is None or not all(each.given for each in placed)
        else _inertia_starts(runs.belief, theta)
    )
    found: list[Fit] = []
    for number, each in enumerate(begun, start=1):
        try:
            first = _from_first_samples(runs, each[None], effects)
            close = None if near is None else _with_first_of(near.values, first)
            found.append(_search(runs, tuple(placed), first, near=close))
        except InputError:  # the motion runs away
            if number == len(begun) and not found:
                raise
    return min(found, key=lambda fit: fit.chi_square)


_INERTIA_STARTS = (1.0, 3.0, 10.0)
"""Times the inertia to start from, as far as it may go: a body that turns little from torques that are not known to
better than what turns it fits as if it were ever heavier."""


def _inertia_starts(belief: Belief, theta: Theta) -> list[Theta]:
    """Return the inertias from which to search, each once, shapes (6,), kg·m²."""
    reached = dict.fromkeys(min(np.log(factor), belief.reach) for factor in _INERTIA_STARTS)
    farther = [size for size in reached if size > SETTINGS.least_reference_scatter]
    return [theta, *(np.asarray(belief.moved(theta, np.expm1(size) * theta)) for size in farther)]


def starts_of(runs: Runs, given: Sequence[Hypothesis]) -> list[Array]:
    """Return the values that are believed of effects of the nominal model, shapes (K,)."""
    return [] if runs.belief is None else [runs.belief.effect(each.key)[0] for each in given]


def refit(runs: Runs, fit: Fit, enough: float = ENOUGH) -> Fit:
    """Return a model fitted to runs, from where another fit of it ended.

    Args:
        runs: to fit, as many as before.
        fit: of the model.
        enough: gain in χ² that is no longer searched for.
    """
    return _search(runs, fit.placed, fit.values, enough=enough)


def fitted_initial_rates(runs: Runs, fit: Fit) -> Fit:
    """Fit the initial rates alone, all else as another fit has it: for runs that were held out.

    Args:
        runs: held out.
        fit: of other runs; what does not recur stays with them.
    """
    fit = recurring(fit)
    values = _from_first_samples(runs, fit.values.theta, fit.values.effects)
    return _search(runs, fit.placed, values, only_initial=True)


def nominal_fit(runs: Runs, theta: Theta) -> Fit:
    """Fit the initial rates alone, without effects.

    Args:
        runs: to fit.
        theta: inertia parameters, shape (6,), kg·m².

    Raises:
        InputError: the motion leaves the finite numbers.
    """
    return _search(runs, (), _from_first_samples(runs, theta[None], []), only_initial=True)


def _from_first_samples(runs: Runs, theta: Array, effects: Sequence[Array]) -> Values:
    """Return a parameter set whose initial rates are as the gyro's first samples have them, or as they were found."""
    first = np.stack([rates[0] for rates in runs.measured]) if runs.found_rate is None else runs.found_rate
    # What keeps a platform from turning ever faster is that the mean torque is nearly zero, whatever telemetry says.
    trim = -runs.mean_torque if runs.trimmed else None
    turn = None if runs.first_turn_std is None else np.zeros((len(first), 1, 3))
    return Values(theta=theta, initial_rate=first[:, None], effects=tuple(effects), trim=trim, first_turn=turn)


def _with_first_of(near: Values, values: Values) -> Values:
    return replace(values, initial_rate=near.initial_rate, trim=near.trim, first_turn=near.first_turn)


def _search(
    runs: Runs,
    placed: tuple[Hypothesis, ...],
    values: Values,
    *,
    near: Values | None = None,
    only_initial: bool = False,
    enough: float = ENOUGH,
) -> Fit:
    return part(
        "search",
        (runs, [each.key for each in placed], values, near, only_initial, enough),
        work=lambda: _searched(runs, placed, values, near, only_initial=only_initial, enough=enough),
        to_content=lambda fit: _to_content(fit.values),
        from_content=lambda content: evaluated(runs, placed, _from_content(content)),
    )


def _to_content(values: Values) -> Content:
    named = {"trim": values.trim, "first_turn": values.first_turn}
    own = {name: array_to_content(each) for name, each in named.items() if each is not None}
    return own | {"values": [array_to_content(each) for each in (values.theta, values.initial_rate, *values.effects)]}


def _from_content(content: Content) -> Values:
    theta, initial_rate, *effects = map(array_from_content, content["values"])
    trim, turn = (array_from_content(content[name]) if name in content else None for name in ("trim", "first_turn"))
    return Values(theta=theta, initial_rate=initial_rate, effects=tuple(effects), trim=trim, first_turn=turn)


def _searched(
    runs: Runs,
    placed: tuple[Hypothesis, ...],
    values: Values,
    near: Values | None,
    *,
    only_initial: bool,
    enough: float,
) -> Fit:
    """Search from values, unless from those near by every step gains: then few lead to the end."""
    if near is not None:
        straight = _straight(runs, placed, near, enough)
        if straight is not None:
            return straight
    fit = evaluated(runs, placed, values)
    columns = np.arange(fit.jacobian.shape[1])
    return _descended(runs, fit, columns >= (common_size(values.effects) if only_initial else 0), enough)


def _straight(runs: Runs, placed: tuple[Hypothesis, ...], values: Values, enough: float) -> Fit | None:
    """Return where whole steps lead from given values; None where one of them does not gain, or they do not end."""
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


def _descended(runs: Runs, fit: Fit, free: Flags, enough: float) -> Fit:
    """Levenberg-Marquardt within a trust region, the effects' bounds kept by projection.

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
        step[self.moving] = damped(self.normal[np.ix_(self.moving, self.moving)], self.slope[self.moving], damping)
        return step

    def length(self, step: Array) -> float:
        """Return the length of a step in standard deviations, as if each coordinate were the only one."""
        return float(np.sqrt(np.diag(self.normal) @ step**2))

    def own(self, step: Array) -> Array:
        """Return a step in the parameters themselves."""
        return step if self.ways is None else np.concatenate([self.ways @ step[:6], step[6:]])


def damped(normal: Array, slope: Array, damping: float = 0.0) -> Array:
    """Return the step that solves a normal matrix, damped by a share of its diagonal; none along what nothing shows."""
    shown = np.diag(normal) > 0.0
    if not shown.all():
        step = np.zeros(len(slope))
        step[shown] = damped(normal[np.ix_(shown, shown)], slope[shown], damping) if shown.any() else 0.0
        return step
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    scaled = normal / np.outer(scale, scale) + damping * np.eye(len(scale))
    if len(scale) > MANY:
        try:
            return np.asarray(cho_solve(cho_factor(scaled), slope / scale) / scale)
        except LinAlgError:  # singular: directions that nothing determines are not stepped along
            pass
    return np.asarray(np.linalg.lstsq(scaled, slope / scale, rcond=UNDETERMINED)[0] / scale)


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


_NOISE_ROUNDS = 8
"""Of estimating the torque's noise from a fit's residual, and fitting again in that noise. From the noise of the static
torque, the lag and delay of the quadcopter of data/crazyflie take six to a hundredth of their deviance."""
_NOISE_FOUND = 0.5
"""Change of the deviance after which no further round follows; 6 are what decides between hypotheses."""
_ROUGHLY = 0.05
"""Gain in χ² that is no longer searched for between such rounds, a tenth of that change."""


def in_torque_noise(runs: Runs, heldout: Runs | None, fit: Fit) -> tuple[Runs, Runs | None, Fit]:
    """Return runs in the noise of sample and torque that a model leaves, and the model fitted again in it.

    Only windows of platforms under applied torque have it: over them it is known in part, and what it is not known by
    would otherwise pass for whatever effect is nearest. All others are returned as they are.

    Args:
        runs: fitted, in the noise in which the model was fitted.
        heldout: not fitted; they are whitened alike.
        fit: of the model to the former.
    """
    if not runs.known_in_part:
        return runs, heldout, fit
    deviance, noise = np.inf, None
    least = None if runs.belief is None else runs.belief.torque_noise
    times = [run.gyro_time for run in runs.grid.runs]
    for _ in range(_NOISE_ROUNDS):
        noise = torque_noise(times, runs.gyro_residual(fit.residual), least, noise)
        runs = replace(runs, torque_noise=noise)
        fit = refit(runs, fit, _ROUGHLY)
        if abs(deviance - fit.deviance) < _NOISE_FOUND:
            break
        deviance = fit.deviance
    fit = refit(runs, fit)
    freedom = min(runs.noise_freedom, _freedom_of_scatter(runs, fit))
    runs = replace(runs, noise_freedom=freedom)
    return runs, heldout and replace(heldout, torque_noise=noise, noise_freedom=freedom), fit


_LEAST_FREEDOM = 3.0
"""Degrees of freedom with which records agree on their noise, at least; two records that scatter widely have no more.

Source: formula: with 2 or fewer, the mean of an F distribution does not exist, and no misfit has an expected size."""


def _freedom_of_scatter(runs: Runs, fit: Fit) -> float:
    """Return the degrees of freedom with which records agree on their noise: a variance of ν has the variance 2/ν."""
    squares = np.array([float(np.mean(part**2)) for part in runs.by_run(fit.residual)])
    counts = np.bincount(runs.record_of)
    if len(counts) == 1:
        return np.inf
    scatter = np.var(np.bincount(runs.record_of, squares) / counts, ddof=1)
    return max(2.0 / max(float(scatter), np.finfo(float).tiny), float(len(counts)), _LEAST_FREEDOM)


def corrected(runs: Runs, fit: Fit) -> Runs:
    """Return runs whose gyro's errors are those of a model; the same object where nothing changes.

    Args:
        runs: fitted or held out.
        fit: of the model to them, or of their initial rates alone.
    """
    hooks = [placed.hooks for placed in fit.placed]
    grid = without_gyro_errors(runs.grid, hooks, fit.values)
    if grid.gimbals is not None and runs.inner:
        grid = with_late_angles(grid, 0.0)
        if late := lateness(hooks, fit.values.effects):
            # All channels of the actuators are late, or their angles alone: whichever suits the torques better.
            both = (grid, with_late_angles(grid, late))
            grid = min(both, key=lambda each: _inner_misfit(runs, each, fit.values))
    return runs if grid is runs.grid else replace(runs, grid=grid)


def _inner_misfit(runs: Runs, grid: Grid, values: Values) -> float:
    """Return χ² of the channels of gimbals and wheels, without effects, by the body's motion that a grid has."""
    found = predicted_channels(grid, [], replace(values, effects=()))[len(runs.names) :]
    blocks = zip(runs.inner, found, runs.inner_noise, strict=True)
    return sum(float(np.square(noise.whitened(measured - predicted[0])).sum()) for measured, predicted, noise in blocks)


def all_corrected(runs: Runs, heldout: Runs | None, fit: Fit) -> tuple[Runs, Runs | None]:
    """Return fitted and held-out runs whose gyro's errors are those of a model; the same objects where nothing changes.

    Args:
        runs: fitted.
        heldout: not fitted; None where there are none.
        fit: of the model to the former.
    """
    corrected_runs = corrected(runs, fit)
    if heldout is None or corrected_runs is runs:
        return corrected_runs, heldout
    seen = fitted_initial_rates(heldout, fit)
    return corrected_runs, replace(corrected(heldout, seen), found_rate=seen.values.initial_rate[:, 0])
