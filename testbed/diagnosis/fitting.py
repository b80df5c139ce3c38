"""A model fitted to runs: by maximum likelihood, from several starts, in the torque's noise, less the gyro's errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbed.arrays import Array, Theta
from testbed.diagnosis.belief import Belief
from testbed.diagnosis.data import Runs
from testbed.diagnosis.descent import ENOUGH, ROUGHLY, descended, straight
from testbed.diagnosis.keeping import Content, array_from_content, array_to_content, part
from testbed.diagnosis.model import Fit, Hypothesis, evaluated, recurring
from testbed.diagnosis.settings import SETTINGS
from testbed.errors import InputError
from testbed.estimation.torque_noise import torque_noise
from testbed.prediction.grid import Grid, with_late_angles
from testbed.prediction.gyro import lateness
from testbed.prediction.integration import Values, torque_of_actuators
from testbed.prediction.prediction import (
    common_size,
    predicted_channels,
    without_gyro_errors,
)


def fitted(
    runs: Runs,
    placed: Sequence[Hypothesis],
    theta: Theta,
    starts: Sequence[Array],
    near: Fit | None = None,
    enough: float = ENOUGH,
) -> Fit:
    """Fit inertia, initial rates, trims where they are free, and effects by maximum likelihood.

    Args:
        runs: to fit.
        placed: the effects in the model.
        theta: to start from, shape (6,), kg·m².
        starts: of each effect's parameters, shapes (K,).
        near: another model of the same runs, with whose initial rates and trims to begin, if that leads straight on.
        enough: gain in χ² that is no longer searched for.

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
            first = _from_first_samples(runs, placed, each[None], effects)
            close = None if near is None else _with_first_of(near.values, first)
            found.append(_search(runs, tuple(placed), first, near=close, enough=enough))
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
    values = _from_first_samples(runs, fit.placed, fit.values.theta, fit.values.effects)
    return _search(runs, fit.placed, values, only_initial=True)


def nominal_fit(runs: Runs, theta: Theta) -> Fit:
    """Fit the initial rates alone, without effects.

    Args:
        runs: to fit.
        theta: inertia parameters, shape (6,), kg·m².

    Raises:
        InputError: the motion leaves the finite numbers.
    """
    return _search(runs, (), _from_first_samples(runs, (), theta[None], []), only_initial=True)


def _from_first_samples(runs: Runs, placed: Sequence[Hypothesis], theta: Array, effects: Sequence[Array]) -> Values:
    """Return a parameter set whose initial rates are as the gyro's first samples have them, or as they were found.

    What keeps a platform from turning ever faster is that its mean torque is nearly zero: that of what its actuators
    really give, which an effect may change. With the mean of what they were asked for, the motion of a flight behind
    which a weight was found beside the centre was searched where it turned thousands of times too fast.
    """
    first = np.stack([rates[0] for rates in runs.measured]) if runs.found_rate is None else runs.found_rate
    turn = None if runs.first_turn_std is None else np.zeros((len(first), 1, 3))
    values = Values(theta=theta, initial_rate=first[:, None], effects=tuple(effects), first_turn=turn)
    if not runs.trimmed:
        return values
    given_B = torque_of_actuators(runs.grid, [each.hooks for each in placed], values)
    return replace(values, trim=-runs.mean_of_trims(given_B))


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
        found = straight(runs, placed, near, enough)
        if found is not None:
            return found
    fit = evaluated(runs, placed, values)
    columns = np.arange(fit.jacobian.shape[1])
    return descended(runs, fit, columns >= (common_size(values.effects) if only_initial else 0), enough)


_NOISE_ROUNDS = 8
"""Of estimating the torque's noise from a fit's residual, and fitting again in that noise. From the noise of the static
torque, the lag and delay of the quadcopter of data/crazyflie take six to a hundredth of their deviance."""
_NOISE_FOUND = 0.5
"""Change of the deviance after which no further round follows; 6 are what decides between hypotheses."""


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
        fit = refit(runs, fit, ROUGHLY)
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
