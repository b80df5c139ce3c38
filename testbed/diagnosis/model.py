"""The nominal model with the effects that the diagnosis has added so far, and how well it fits runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress, pairwise, starmap
from math import sqrt
from typing import Protocol

import numpy as np

from testbed.arrays import Array, Flags, Theta
from testbed.diagnosis.data import Runs
from testbed.effects.contract import Effect
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values
from testbed.prediction.prediction import common_size, predicted_channels, predicted_with_derivatives


@dataclass(frozen=True, kw_only=True)
class Placed:
    """An effect at a component: one hypothesis.

    Attributes:
        effect: which.
        component: where.
    """

    effect: Effect
    component: str

    @property
    def hooks(self) -> Hooks:
        """How it enters the prediction."""
        return self.effect.hooks(self.component)

    @property
    def size(self) -> int:
        """Number of parameters."""
        return len(self.effect.parameters)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest values, each of shape (K,)."""
        return self.effect.bounds

    @property
    def key(self) -> str:
        """Unique name, e.g. `rotor_speed:cmg3`."""
        return f"{self.effect.id}:{self.component}"


class _WithPlaced(Protocol):
    @property
    def placed(self) -> Placed: ...


class AtPlace:
    """What is said of one hypothesis, under the names of effects on the noise (`Scatter`)."""

    @property
    def effect(self: _WithPlaced) -> Effect:
        """Which effect."""
        return self.placed.effect

    @property
    def component(self: _WithPlaced) -> str:
        """Where it is."""
        return self.placed.component

    @property
    def key(self: _WithPlaced) -> str:
        """Unique name, e.g. `rotor_speed:cmg3`."""
        return self.placed.key


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A model fitted to runs.

    Attributes:
        placed: the effects in the model.
        values: of all parameters, P = 1.
        residual: whitened, shape (samples,).
        jacobian: whitened ∂prediction/∂(θ, effects, ω₀ of every run), shape (samples, C + 3 R).
        at_bound: which effect parameters lie at a bound, shape (C - 6,).
    """

    placed: tuple[Placed, ...]
    values: Values
    residual: Array
    jacobian: Array
    at_bound: Flags

    @property
    def chi_square(self) -> float:
        """Sum of the squared whitened residuals."""
        return float(self.residual @ self.residual)

    @property
    def root_mean_square(self) -> float:
        """Of the whitened residual: 1 is the noise floor."""
        return sqrt(self.chi_square / len(self.residual))

    @property
    def freedom(self) -> int:
        """Samples less parameters."""
        return len(self.residual) - int(self.jacobian.shape[1])

    @property
    def theta(self) -> Theta:
        """Inertia parameters, shape (6,), kg·m²."""
        return np.asarray(self.values.theta[0])

    @property
    def effect_values(self) -> Array:
        """Parameters of all effects, one after the other, shape (C - 6,)."""
        return np.concatenate([np.zeros(0), *(value[0] for value in self.values.effects)])

    def own(self, placed: Placed) -> slice:
        """Return where the parameters of an effect in the model stand in `effect_values`."""
        keys = [each.key for each in self.placed]
        first = sum(each.size for each in self.placed[: keys.index(placed.key)])
        return slice(first, first + placed.size)

    @cached_property
    def normal(self) -> Array:
        """Normal matrix of all parameters, shape (C + 3 R, C + 3 R)."""
        return np.asarray(self.jacobian.T @ self.jacobian)

    @property
    def covariance(self) -> Array:
        """Of (θ, effects), the initial rates marginalised, shape (C, C)."""
        common = 6 + len(self.effect_values)
        return np.asarray(np.linalg.inv(self.normal)[:common, :common])


def recurring(fit: Fit) -> Fit:
    """Return a fit less the effects that belong to the fitted runs alone, such as a touch."""
    kept = [each.effect.recurs for each in fit.placed]
    if all(kept):
        return fit
    columns = np.concatenate([np.full(each.size, each.effect.recurs) for each in fit.placed])
    others = np.ones(fit.jacobian.shape[1] - 6 - len(columns), dtype=bool)
    return replace(
        fit,
        placed=tuple(compress(fit.placed, kept)),
        values=replace(fit.values, effects=tuple(compress(fit.values.effects, kept))),
        jacobian=fit.jacobian[:, np.concatenate([np.ones(6, dtype=bool), columns, others])],
        at_bound=fit.at_bound[columns],
    )


def evaluated(runs: Runs, placed: tuple[Placed, ...], values: Values) -> Fit:
    """Return residual and Jacobian at given parameters."""
    hooks = [each.hooks for each in placed]
    samples, derivatives = predicted_with_derivatives(runs.grid, hooks, values, predict=predicted_channels)
    return Fit(
        placed=placed,
        values=values,
        residual=runs.whitened(samples),
        jacobian=stacked(runs, derivatives, common_size(values.effects)),
        at_bound=_at_bound(placed, values),
    )


def stacked(runs: Runs, derivatives: Sequence[Array], common: int) -> Array:
    """Put the whitened derivatives of all blocks below each other, every run's initial rate in columns of its own.

    Args:
        runs: with their sigma.
        derivatives: of each block, shape (N, 3 or 6, common + 3).
        common: columns that all runs share.
    """
    number, blocks = len(runs.names), runs.whitened_columns(derivatives)
    edges = np.cumsum([0, *map(len, blocks)]).tolist()
    matrix = np.zeros((edges[-1], common + 3 * number))
    for index, (block, rows) in enumerate(zip(blocks, starmap(slice, pairwise(edges)), strict=True)):
        own = common + 3 * (index % number)
        matrix[rows, :common] = block[:, :common]
        matrix[rows, own : own + 3] = block[:, common:]
    return matrix


def moved(fit: Fit, step: Array) -> Values:
    """Return a fit's parameters after a step, the effects' kept inside their bounds.

    Args:
        fit: to start from.
        step: of (θ, effects, ω₀ of every run), shape (C + 3 R,).
    """
    lower, upper = bounds_of(fit.placed)
    common = 6 + len(lower)
    effects = np.clip(fit.effect_values + step[6:common], lower, upper)
    sizes = np.cumsum([value.shape[1] for value in fit.values.effects])[:-1]
    return Values(
        theta=fit.values.theta + step[:6],
        initial_rate=fit.values.initial_rate + step[common:].reshape(-1, 1, 3),
        effects=tuple(part[None] for part in np.split(effects, sizes)) if len(fit.placed) else (),
    )


def bounds_of(placed: Sequence[Placed]) -> tuple[Array, Array]:
    """Return the least and greatest values of all effects' parameters, each of shape (C - 6,)."""
    lower = [each.bounds[0] for each in placed]
    upper = [each.bounds[1] for each in placed]
    return np.concatenate([np.zeros(0), *lower]), np.concatenate([np.zeros(0), *upper])


def _at_bound(placed: Sequence[Placed], values: Values) -> Flags:
    lower, upper = bounds_of(placed)
    effects = np.concatenate([np.zeros(0), *(value[0] for value in values.effects)])
    return np.asarray((effects <= lower) | (effects >= upper))
