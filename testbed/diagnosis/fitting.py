"""The search for the parameters with which a model fits runs best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Array, Flags, Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.keeping import Content, array_made, array_told, part
from testbed.diagnosis.model import Fit, Placed, bounds_of, evaluated, moved, recurring
from testbed.errors import InputError
from testbed.prediction.integration import Values
from testbed.prediction.prediction import common_size

_TRIALS = 16
"""A mode that is there takes 4 to 8; one that is not wanders along its valley until it is stopped."""
_ENOUGH = 1e-3
"""Gain in χ² that is no longer searched for; a standard error makes it 1."""
_DAMPING = (1e-6, 1e6)
"""Smallest and largest Levenberg-Marquardt damping, in shares of the normal matrix's diagonal."""
_FACTOR = 10.0
"""By which damping falls after a step that gains, and rises after one that does not; after the next, by its square."""


def fitted(runs: Runs, placed: Sequence[Placed], theta: Theta, starts: Sequence[Array]) -> Fit:
    """Fit inertia, initial rates and effects by maximum likelihood.

    Args:
        runs: to fit.
        placed: the effects in the model.
        theta: to start from, shape (6,), kg·m².
        starts: of each effect's parameters, shapes (K,).

    Raises:
        InputError: the nominal motion leaves the finite numbers.
    """
    return _search(runs, tuple(placed), _from_first_samples(runs, theta[None], [start[None] for start in starts]))


def refit(runs: Runs, fit: Fit) -> Fit:
    """Return a model fitted to runs, from where another fit of it ended."""
    return fitted(runs, fit.placed, fit.theta, [value[0] for value in fit.values.effects])


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
    """Return a parameter set whose initial rates are as the gyro's first samples have them."""
    first = np.stack([rates[0] for rates in runs.measured])[:, None]
    return Values(theta=theta, initial_rate=first, effects=tuple(effects))


def _search(runs: Runs, placed: tuple[Placed, ...], values: Values, *, only_initial: bool = False) -> Fit:
    return part(
        "search",
        (runs, [each.key for each in placed], values, only_initial),
        work=lambda: _searched(runs, placed, values, only_initial=only_initial),
        told=lambda fit: _told(fit.values),
        made=lambda content: evaluated(runs, placed, _made(content)),
    )


def _told(values: Values) -> Content:
    return {"values": [array_told(each) for each in (values.theta, values.initial_rate, *values.effects)]}


def _made(content: Content) -> Values:
    theta, initial_rate, *effects = map(array_made, content["values"])
    return Values(theta=theta, initial_rate=initial_rate, effects=tuple(effects))


def _searched(runs: Runs, placed: tuple[Placed, ...], values: Values, *, only_initial: bool) -> Fit:
    """Levenberg-Marquardt with the effects' bounds kept by projection."""
    fit, damping, rise = evaluated(runs, placed, values), _DAMPING[0], _FACTOR
    common = common_size(values.effects)
    free = np.arange(fit.jacobian.shape[1]) >= common if only_initial else np.ones(fit.jacobian.shape[1], dtype=bool)
    for _ in range(_TRIALS):
        step, expected = _step(fit, free, damping)
        if expected < _ENOUGH or damping > _DAMPING[1]:
            break
        trial = _better(runs, fit, moved(fit, step))
        if trial is None:
            damping, rise = damping * rise, rise * _FACTOR
        else:
            fit, damping, rise = trial, max(damping / _FACTOR, _DAMPING[0]), _FACTOR
    return fit


def _step(fit: Fit, free: Flags, damping: float) -> tuple[Array, float]:
    """Return the damped step of the free parameters, and the least that it gains if the model is linear."""
    slope = fit.jacobian.T @ fit.residual
    moving = free & ~pushing_out(fit, slope)
    step = np.zeros(len(slope))
    step[moving] = damped(fit.normal[np.ix_(moving, moving)], slope[moving], damping)
    return step, float(slope @ step)


def damped(normal: Array, slope: Array, damping: float = 0.0) -> Array:
    """Return the step that solves a normal matrix, damped by a share of its diagonal."""
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    scaled = normal / np.outer(scale, scale) + damping * np.eye(len(scale))
    return np.asarray(np.linalg.lstsq(scaled, slope / scale, rcond=1e-13)[0] / scale)


def pushing_out(fit: Fit, step: Array) -> Flags:
    """Return which parameters lie at a bound and would go beyond it with a step, or along a slope."""
    pushing = np.zeros(len(step), dtype=bool)
    lower, upper = bounds_of(fit.placed)
    own, values = slice(6, 6 + len(lower)), fit.effect_values
    pushing[own] = ((values <= lower) & (step[own] < 0.0)) | ((values >= upper) & (step[own] > 0.0))
    return pushing


def _better(runs: Runs, fit: Fit, values: Values) -> Fit | None:
    """Return the fit at other values if χ² is not larger there."""
    try:
        trial = evaluated(runs, fit.placed, values)
    except InputError:
        return None
    return trial if trial.chi_square <= fit.chi_square else None
