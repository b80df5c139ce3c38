"""A model with its parameters: what it predicts of runs, linearised; what of it these show, and its residual."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress, pairwise, starmap
from math import sqrt
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from testbed.arrays import Array, Flags, Theta
from testbed.diagnosis.belief import Belief
from testbed.diagnosis.believed import believed
from testbed.diagnosis.data import Runs
from testbed.effects.contract import TYPICAL_INERTIA, Effect
from testbed.effects.direction import slowest_mode
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values
from testbed.prediction.prediction import (
    common_size,
    predicted_channels,
    predicted_with_derivatives,
)

NEGLIGIBLE = 1e-9
"""Share of a column's length that has to remain for its direction to count: above the rounding of columns that depend
on each other, 1e-12 of 1e4 samples, and far below what any effect shows. With 1e-7, 126 fits of effects without a scan
are the same (cases 9 and 12 of 14 of seed 90817)."""
UNDETERMINED = 1e-13
"""Share of the largest singular value of a scaled normal matrix below which a direction is not solved for: just above
rounding, which a Jacobian of condition 3e6 reaches."""


def orthonormal(matrix: Array) -> Array:
    """Return an orthonormal basis of what a matrix's columns span, whatever their scales, shape (N, rank)."""
    scale = np.maximum(np.linalg.norm(matrix, axis=0), np.finfo(float).tiny)
    if matrix.shape[1] > MANY:
        basis, triangle, _ = qr(matrix / scale, mode="economic", pivoting=True)
        return np.asarray(basis[:, np.abs(np.diag(triangle)) > NEGLIGIBLE])
    left, strength, _ = np.linalg.svd(matrix / scale, full_matrices=False)
    return np.asarray(left[:, strength > NEGLIGIBLE])


DEPENDENT = 1e-12
"""Of the largest eigenvalue of a normal matrix with ones on its diagonal, below which an eigenvector is no direction
of its own: a thousand times the rounding of its entries, and of columns whose difference is 1e-6 of them."""


def squares_within(information: Array, slope: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the squared length of what columns C can explain of a vector v, and their rank, shapes (...).

    Args:
        information: CᵀC, shape (..., K, K), whatever the columns' scales.
        slope: Cᵀv, shape (..., K).
    """
    strength, along, own, _ = _directions(information, slope)
    return (along**2 / np.where(own, strength, np.inf)).sum(axis=-1), own.sum(axis=-1)


def independent(information: Array, slope: Array) -> tuple[Array, Array]:
    """Return what columns can explain by the directions alone that they span; arguments as `squares_within`.

    Of the others rounding leaves an information below zero, by which the evidence of a slope has no bound.
    """
    strength, along, own, axes = _directions(information, slope)
    kept = np.where(own, strength, 0.0)[..., None, :]
    slopes = (axes @ np.where(own, along, 0.0)[..., None])[..., 0]
    return np.asarray((axes * kept) @ np.swapaxes(axes, -1, -2)), np.asarray(slopes)


def _directions(information: Array, slope: Array) -> tuple[Array, Array, Flags, Array]:
    """Return the strength of columns along directions and the slope there, which they span, and the directions.

    These are of columns of length one: their axes, shape (..., K, K), are in units of the columns' own.
    """
    scale = np.sqrt(np.maximum(np.diagonal(information, axis1=-2, axis2=-1), np.finfo(float).tiny))
    strength, axes = np.linalg.eigh(information / (scale[..., :, None] * scale[..., None, :]))
    along = (np.swapaxes(axes, -1, -2) @ (slope / scale)[..., None])[..., 0]
    own = strength > DEPENDENT * strength[..., -1:]
    return strength, along, own, axes * scale[..., :, None]


def projected_out(values: Array, basis: Array) -> Array:
    """Return what of a vector or of columns lies outside of what a basis spans.

    Args:
        values: shape (N,) or (N, C).
        basis: orthonormal, shape (N, rank).
    """
    return np.asarray(values - basis @ (basis.T @ values))


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """An effect at a component: one hypothesis.

    Attributes:
        effect: which.
        component: where.
        given: whether it is part of the nominal model, and no explanation of what that lacks.
        moment: mean moment of inertia of the platform, kg·m²: masses and inertias are searched as far as it goes.
        longest: how long the longest run lasts, s: modes are searched as slow as it shows; 0 where nobody has said.
    """

    effect: Effect
    component: str
    given: bool = False
    moment: float = TYPICAL_INERTIA
    longest: float = 0.0

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
        return self._grown(self.effect.bounds)

    def reach(self, start: Array) -> tuple[Array, Array]:
        """Return the least and greatest values that a search from a start, shape (K,), can come to, shapes (K,)."""
        return self._grown(self.effect.reach(start))

    def _grown(self, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
        growth = np.array([each.growth_on(self.moment) for each in self.effect.parameters])
        lower, upper = bounds[0] * growth, bounds[1] * growth
        if self.effect.scans_frequencies:
            lower[0] = min(lower[0], slowest_mode(self.longest))
        return lower, upper

    @property
    def key(self) -> str:
        """Unique name, e.g. `rotor_speed:cmg3`."""
        return f"{self.effect.id}:{self.component}"


class _WithHypothesis(Protocol):
    @property
    def placed(self) -> Hypothesis: ...


class AtComponent:
    """What is said of one hypothesis, under the names of effects on the noise (`NoiseHypothesis`)."""

    @property
    def effect(self: _WithHypothesis) -> Effect:
        """Which effect."""
        return self.placed.effect

    @property
    def component(self: _WithHypothesis) -> str:
        """Where it is."""
        return self.placed.component

    @property
    def key(self: _WithHypothesis) -> str:
        """Unique name, e.g. `rotor_speed:cmg3`."""
        return self.placed.key


MANY = 150
"""Parameters, initial rates included, from which on normal matrices are built in parts and solved by the method of
Cholesky, as those of 50 windows are: 10 to 50 times faster, the same to rounding."""
_ROWS = 256
"""Of a Jacobian in one part: of two or three windows, whose columns are a tenth of all. With 128 or 512, as fast."""


def _normal_of_windows(jacobian: Array) -> Array:
    """Return the normal matrix of a Jacobian that is nearly all zero, as initial rates are each window's own."""
    normal = np.zeros((jacobian.shape[1],) * 2)
    for first in range(0, len(jacobian), _ROWS):
        part = jacobian[first : first + _ROWS]
        own = np.flatnonzero(part.any(axis=0))
        normal[np.ix_(own, own)] += part[:, own].T @ part[:, own]
    return normal


_LEARNT = 0.05
"""Share of a belief's variance that samples take away, below which they say nothing of it.

Source: chosen: samples that take away one twentieth know a parameter four times worse than the belief does."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A model fitted to runs.

    Attributes:
        placed: the effects in the model.
        values: of all parameters, P = 1.
        residual: whitened, shape (samples,), and behind it how far parameters lie from what is believed of them.
        jacobian: whitened ∂prediction/∂(θ, effects, ω₀ of every run and, where it is free, the turn of its first
            attitude, trim of every record), shape (samples, C + 3 R) without turns and trims; a row for each number
            that is believed.
        at_bound: which effect parameters lie at a bound, shape (C - 6,).
        believed: number of rows that are beliefs.
        trim_of: of every run, which trim it has, shape (R,).
        belief: as the runs have it.
        torque_noise: in which the residual is whitened, as `Runs` has it.
        noise_deviance: twice the logarithm of what the density of the samples is divided by in this noise.
    """

    placed: tuple[Hypothesis, ...]
    values: Values
    residual: Array
    jacobian: Array
    at_bound: Flags
    believed: int = 0
    trim_of: NDArray[np.intp]
    belief: Belief | None = None
    torque_noise: Array | None = None
    noise_deviance: float = 0.0

    @property
    def chi_square(self) -> float:
        """Sum of the squared whitened residuals."""
        return float(self.residual @ self.residual)

    @property
    def deviance(self) -> float:
        """-2 log likelihood, up to what all models share: χ², and what the noise that goes with the model costs."""
        return self.chi_square + self.noise_deviance

    @property
    def trims(self) -> Array:
        """Every trim, shape (trims, 3), N·m; none where they are not free."""
        if self.values.trim is None:
            return np.zeros((0, 3))
        return np.asarray(self.values.trim[np.unique(self.trim_of, return_index=True)[1], 0])

    @property
    def root_mean_square(self) -> float:
        """Of the whitened residual: 1 is the noise floor."""
        return sqrt(float(self.measured @ self.measured) / len(self.measured))

    @property
    def measured(self) -> Array:
        """The whitened residual of the samples, without what is believed, shape (samples,)."""
        return self.residual[: len(self.residual) - self.believed]

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

    def own(self, placed: Hypothesis) -> slice:
        """Return where the parameters of an effect in the model stand in `effect_values`."""
        keys = [each.key for each in self.placed]
        first = sum(each.size for each in self.placed[: keys.index(placed.key)])
        return slice(first, first + placed.size)

    def contribution(self, placed: Hypothesis) -> Array:
        """Return what an effect of its size makes of the samples, linearised, whitened, shape (samples,)."""
        own, parameters = self.own(placed), placed.effect.parameters
        absent = np.array([each.absent for each in parameters])
        size = np.where([each.scanned for each in parameters], 0.0, self.effect_values[own] - absent)
        return np.asarray(self.jacobian[:, 6 + own.start : 6 + own.stop] @ size)

    @cached_property
    def normal(self) -> Array:
        """Normal matrix of all parameters, shape (C + 3 R, C + 3 R)."""
        if self.jacobian.shape[1] > MANY:
            return _normal_of_windows(self.jacobian)
        return np.asarray(self.jacobian.T @ self.jacobian)

    @property
    def covariance(self) -> Array:
        """Of (θ, effects), the initial rates marginalised, shape (C, C); infinite where no sample shows a parameter.

        With the error that what is believed has in common with other records.
        """
        own = 6 + len(self.effect_values)
        return self._covariance[:own, :own]

    @property
    def trim_std(self) -> Array:
        """Standard deviation of every trim, shape (trims, 3), N·m; infinite about axes that no sample shows."""
        trims = self.trims
        return np.asarray(np.sqrt(np.diag(self._covariance)[len(self.normal) - trims.size :]).reshape(trims.shape))

    @property
    def _covariance(self) -> Array:
        """Of all parameters, as `covariance`, shape (C + 3 R, C + 3 R)."""
        covariance = self._as_believed
        if self.belief is not None and self.belief.common is not None:
            shown, known = np.diag(self.normal) > 0.0, self.belief.known_std
            rows = self.jacobian[len(self.residual) - self.believed :][: len(known), shown]
            moved = covariance[np.ix_(shown, shown)] @ rows.T / known  # by what is believed of each number
            covariance[np.ix_(shown, shown)] += moved @ self.belief.common @ moved.T
        return covariance

    @property
    def _as_believed(self) -> Array:
        """The same without the error that what is believed has in common with other records."""
        shown = np.diag(self.normal) > 0.0
        covariance = np.diag(np.where(shown, 0.0, np.inf))
        covariance[np.ix_(shown, shown)] = np.linalg.inv(self.normal[np.ix_(shown, shown)])
        return covariance

    def surprise(self, placed: Hypothesis) -> tuple[float, int]:
        """Return χ² by which the samples shift an effect from what is believed of it, and of how many directions.

        A shift d of a belief with the covariance S₀ to one with S has the covariance S₀ - S if the belief is right.
        Directions of which the samples say next to nothing are left out.
        """
        assert self.belief is not None
        mean, std = self.belief.effect(placed.key)
        own = np.arange(6, 6 + len(self.effect_values))[self.own(placed)]
        shift = (self.effect_values[self.own(placed)] - mean) / std
        learnt, axes = np.linalg.eigh(np.eye(len(std)) - self._as_believed[np.ix_(own, own)] / np.outer(std, std))
        some = learnt > _LEARNT
        return float(((axes.T @ shift)[some] ** 2 / learnt[some]).sum()), int(some.sum())

    def signature_of(self, placed: Hypothesis) -> Array:
        """Return the Jacobian's columns of an effect's parameters, all others projected out, shape (samples, K)."""
        own = np.arange(6, 6 + len(self.effect_values))[self.own(placed)]
        nuisance = orthonormal(np.delete(self.jacobian, own, axis=1))
        return projected_out(self.jacobian[:, own], nuisance)

    @property
    def shown(self) -> Flags:
        """Which of (θ, effects) any sample shows, shape (C,): not what belongs to axes that a bearing holds.

        What is believed of a parameter is no sample.
        """
        count = len(self.residual) - self.believed
        return np.asarray(np.any(self.jacobian[:count, : 6 + len(self.effect_values)], axis=0))


def recurring(fit: Fit) -> Fit:
    """Return a fit without the effects that act in single runs only, such as a contact."""
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


def chi_square_at(runs: Runs, placed: Sequence[Hypothesis], values: Values) -> float:
    """Return χ² at given parameters if its motion is near the measured one; `evaluated` then begins from that motion.

    Args:
        runs: whose samples are predicted.
        placed: the effects in the model.
        values: one parameter set, P = 1.

    Raises:
        InputError: the motion is not found from the measured one, or leaves the finite numbers.
    """
    hooks, tried = [each.hooks for each in placed], replace(values, as_trial=True)
    # With one derivative: numbers without any round otherwise, and the motion would be searched for again.
    samples, _ = predicted_with_derivatives(runs.grid, hooks, tried, range(1), predicted_channels)
    residual, _ = _residual_and_beliefs(runs, placed, values, samples)
    return float(residual @ residual)


def evaluated(runs: Runs, placed: tuple[Hypothesis, ...], values: Values, *, as_trial: bool = False) -> Fit:
    """Return residual and Jacobian at given parameters.

    Args:
        runs: whose samples are predicted.
        placed: the effects in the model.
        values: one parameter set, P = 1.
        as_trial: whether it counts only if its motion is near the measured one.

    Raises:
        InputError: the motion leaves the finite numbers or, of a trial, is not found from the measured one.
    """
    hooks, tried = [each.hooks for each in placed], replace(values, as_trial=as_trial)
    samples, derivatives = predicted_with_derivatives(runs.grid, hooks, tried, predict=predicted_channels)
    residual, slopes = _residual_and_beliefs(runs, placed, values, samples)
    return Fit(
        placed=placed,
        values=values,
        residual=residual,
        jacobian=stacked(runs, derivatives, common_size(values.effects), slopes),
        at_bound=_at_bound(placed, values),
        believed=len(slopes),
        trim_of=runs.trim_of,
        belief=runs.belief,
        torque_noise=runs.torque_noise,
        noise_deviance=float(runs.noise_deviance.sum()),
    )


def _residual_and_beliefs(
    runs: Runs, placed: Sequence[Hypothesis], values: Values, samples: Sequence[Array]
) -> tuple[Array, Array]:
    """Return the whitened residual of samples and of what is believed, and the slopes of the latter by all columns."""
    residual, columns = runs.whitened(samples), common_size(values.effects) + parameters_of_runs(runs)
    away, slopes = believed(runs, [each.key for each in placed], values, columns)
    return np.concatenate([residual, away]) if len(away) else residual, slopes


def parameters_of_runs(runs: Runs) -> int:
    """Return the number of parameters that runs or records have of their own, those of records last."""
    return runs.own_size * len(runs.names) + (3 * len(runs.trim_names) if runs.trimmed else 0)


def stacked(runs: Runs, derivatives: Sequence[Array], common: int, beliefs: Array) -> Array:
    """Put the whitened derivatives of all blocks below each other, what is a run's or a record's own in own columns.

    Args:
        runs: with their sigma.
        derivatives: of each block, shape (N, 3 or 6, common + what is a run's own, and a trim where it is free).
        common: columns that all runs share.
        beliefs: rows that stand below, shape (B, columns).
    """
    number, blocks, trims, size = len(runs.names), runs.whitened_columns(derivatives), runs.trimmed, runs.own_size
    edges = np.cumsum([0, *map(len, blocks)]).tolist()
    matrix = np.zeros((edges[-1] + len(beliefs), beliefs.shape[1]))
    matrix[edges[-1] :] = beliefs
    for index, (block, rows) in enumerate(zip(blocks, starmap(slice, pairwise(edges)), strict=True)):
        own = common + size * (index % number)
        matrix[rows, :common] = block[:, :common]
        matrix[rows, own : own + size] = block[:, common : common + size]
        if trims:
            trim = common + size * number + 3 * int(runs.trim_of[index % number])
            matrix[rows, trim : trim + 3] = block[:, common + size :]
    return matrix


def moved(fit: Fit, step: Array) -> Values:
    """Return a fit's parameters after a step, the effects' kept inside their bounds.

    Args:
        fit: to start from.
        step: of all that the Jacobian's columns are of.
    """
    lower, upper = bounds_of(fit.placed)
    common, rates, trim, turn = 6 + len(lower), fit.values.initial_rate, fit.values.trim, fit.values.first_turn
    effects = np.clip(fit.effect_values + step[6:common], lower, upper)
    sizes = np.cumsum([value.shape[1] for value in fit.values.effects])[:-1]
    of_runs, of_records = np.split(step[common:], [len(rates) * (3 if turn is None else 6)])
    own = of_runs.reshape(len(rates), 1, -1)
    return Values(
        theta=fit.values.theta + step[:6] if fit.belief is None else fit.belief.moved(fit.theta, step[:6])[None],
        initial_rate=rates + own[..., :3],
        effects=tuple(part[None] for part in np.split(effects, sizes)) if len(fit.placed) else (),
        trim=None if trim is None else trim + of_records.reshape(-1, 1, 3)[fit.trim_of],
        first_turn=None if turn is None else turn + own[..., 3:],
    )


def bounds_of(placed: Sequence[Hypothesis]) -> tuple[Array, Array]:
    """Return the least and greatest values of all effects' parameters, each of shape (C - 6,)."""
    lower = [each.bounds[0] for each in placed]
    upper = [each.bounds[1] for each in placed]
    return np.concatenate([np.zeros(0), *lower]), np.concatenate([np.zeros(0), *upper])


def _at_bound(placed: Sequence[Hypothesis], values: Values) -> Flags:
    lower, upper = bounds_of(placed)
    effects = np.concatenate([np.zeros(0), *(value[0] for value in values.effects)])
    return np.asarray((effects <= lower) | (effects >= upper))
