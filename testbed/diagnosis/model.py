"""A model with its parameters: predicted, linearised and fitted to runs; what it says of the gyro's errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress, pairwise, starmap
from math import sqrt
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve, qr
from scipy.sparse import csr_array

from testbed.arrays import Array, Flags, Theta
from testbed.diagnosis.data import Belief, Runs
from testbed.diagnosis.keeping import Content, array_from_content, array_to_content, part
from testbed.diagnosis.settings import SETTINGS
from testbed.dynamics.inertia import slopes_of_log_ratio
from testbed.effects.contract import TYPICAL_INERTIA, Effect
from testbed.errors import InputError
from testbed.estimation.torque_noise import torque_noise
from testbed.prediction.grid import Grid, with_late_angles
from testbed.prediction.gyro import lateness
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values
from testbed.prediction.prediction import (
    common_size,
    predicted_channels,
    predicted_with_derivatives,
    without_gyro_errors,
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
    if matrix.shape[1] > _MANY:
        basis, triangle, _ = qr(matrix / scale, mode="economic", pivoting=True)
        return np.asarray(basis[:, np.abs(np.diag(triangle)) > NEGLIGIBLE])
    left, strength, _ = np.linalg.svd(matrix / scale, full_matrices=False)
    return np.asarray(left[:, strength > NEGLIGIBLE])


_DEPENDENT = 1e-12
"""Of the largest eigenvalue of a normal matrix with ones on its diagonal, below which an eigenvector is no direction
of its own: a thousand times the rounding of its entries, and of columns whose difference is 1e-6 of them."""


def squares_within(information: Array, slope: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the squared length of what columns C can explain of a vector v, and their rank, shapes (...).

    Args:
        information: CᵀC, shape (..., K, K), whatever the columns' scales.
        slope: Cᵀv, shape (..., K).
    """
    scale = np.sqrt(np.maximum(np.diagonal(information, axis1=-2, axis2=-1), np.finfo(float).tiny))
    strength, axes = np.linalg.eigh(information / (scale[..., :, None] * scale[..., None, :]))
    along = (np.swapaxes(axes, -1, -2) @ (slope / scale)[..., None])[..., 0]
    own = strength > _DEPENDENT * strength[..., -1:]
    return (along**2 / np.where(own, strength, np.inf)).sum(axis=-1), own.sum(axis=-1)


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
    """

    effect: Effect
    component: str
    given: bool = False
    moment: float = TYPICAL_INERTIA

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
        return bounds[0] * growth, bounds[1] * growth

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


_MANY = 150
"""Parameters, initial rates included, from which on normal matrices are sparse and solved by the method of Cholesky,
as those of 50 windows are: 10 to 50 times faster, the same to rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A model fitted to runs.

    Attributes:
        placed: the effects in the model.
        values: of all parameters, P = 1.
        residual: whitened, shape (samples,), and behind it how far parameters lie from what is believed of them.
        jacobian: whitened ∂prediction/∂(θ, effects, ω₀ of every run, trim of every record), shape (samples, C + 3 R)
            without trims, with a row for each number that is believed.
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
        measured = self.residual[: len(self.residual) - self.believed]
        return sqrt(float(measured @ measured) / len(measured))

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

    @cached_property
    def normal(self) -> Array:
        """Normal matrix of all parameters, shape (C + 3 R, C + 3 R)."""
        if self.jacobian.shape[1] > _MANY:  # nearly all of it is zero: initial rates are each window's own
            columns = csr_array(self.jacobian)
            return np.asarray((columns.T @ columns).toarray())
        return np.asarray(self.jacobian.T @ self.jacobian)

    @property
    def covariance(self) -> Array:
        """Of (θ, effects), the initial rates marginalised, shape (C, C); infinite where no sample shows a parameter."""
        common = 6 + len(self.effect_values)
        shown = np.diag(self.normal) > 0.0
        covariance = np.diag(np.where(shown, 0.0, np.inf))
        covariance[np.ix_(shown, shown)] = np.linalg.inv(self.normal[np.ix_(shown, shown)])
        return np.asarray(covariance[:common, :common])

    def signature_of(self, placed: Hypothesis) -> Array:
        """Return the Jacobian's columns of an effect's parameters, all others projected out, shape (samples, K)."""
        own = np.arange(6, 6 + len(self.effect_values))[self.own(placed)]
        nuisance = orthonormal(np.delete(self.jacobian, own, axis=1))
        return projected_out(self.jacobian[:, own], nuisance)

    @property
    def shown(self) -> Flags:
        """Which of (θ, effects) any sample shows, shape (C,): not what belongs to axes that a bearing holds."""
        return np.asarray(np.diag(self.normal)[: 6 + len(self.effect_values)] > 0.0)


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


def evaluated(runs: Runs, placed: tuple[Hypothesis, ...], values: Values) -> Fit:
    """Return residual and Jacobian at given parameters."""
    hooks = [each.hooks for each in placed]
    samples, derivatives = predicted_with_derivatives(runs.grid, hooks, values, predict=predicted_channels)
    residual, common = runs.whitened(samples), common_size(values.effects)
    away, slopes = _believed(runs, placed, values, common + parameters_of_runs(runs))
    return Fit(
        placed=placed,
        values=values,
        residual=np.concatenate([residual, away]) if len(away) else residual,
        jacobian=stacked(runs, derivatives, common, slopes),
        at_bound=_at_bound(placed, values),
        believed=len(away),
        trim_of=runs.trim_of,
        belief=runs.belief,
        torque_noise=runs.torque_noise,
        noise_deviance=float(runs.noise_deviance.sum()),
    )


def parameters_of_runs(runs: Runs) -> int:
    """Return the number of parameters that runs or records have of their own: initial rates, and trims if free."""
    return 3 * (len(runs.names) + (len(runs.trim_names) if runs.trimmed else 0))


def stacked(runs: Runs, derivatives: Sequence[Array], common: int, beliefs: Array) -> Array:
    """Put the whitened derivatives of all blocks below each other, what is a run's or a record's own in own columns.

    Args:
        runs: with their sigma.
        derivatives: of each block, shape (N, 3 or 6, common + 3), or common + 6 where trims are free.
        common: columns that all runs share.
        beliefs: rows that stand below, shape (B, columns).
    """
    number, blocks, trims = len(runs.names), runs.whitened_columns(derivatives), runs.trimmed
    edges = np.cumsum([0, *map(len, blocks)]).tolist()
    matrix = np.zeros((edges[-1] + len(beliefs), beliefs.shape[1]))
    matrix[edges[-1] :] = beliefs
    for index, (block, rows) in enumerate(zip(blocks, starmap(slice, pairwise(edges)), strict=True)):
        own = common + 3 * (index % number)
        matrix[rows, :common] = block[:, :common]
        matrix[rows, own : own + 3] = block[:, common : common + 3]
        if trims:
            trim = common + 3 * (number + int(runs.trim_of[index % number]))
            matrix[rows, trim : trim + 3] = block[:, common + 3 :]
    return matrix


def _believed(runs: Runs, placed: Sequence[Hypothesis], values: Values, width: int) -> tuple[Array, Array]:
    """Return by how many standard deviations parameters fall short of beliefs, (B,), and slopes, (B, width)."""
    belief, rows = runs.belief, list[tuple[Array, Array]]()
    if belief is None:
        return np.zeros(0), np.zeros((0, width))
    if 0.0 < belief.log_ratio_std < np.inf:
        logarithm = belief.log_ratio_of(values.theta[0])
        slopes = np.linalg.inv(slopes_of_log_ratio(logarithm, belief.nominal, np.eye(3)))
        # The square of U is the sum of all nine entries: those off the diagonal count twice.
        std = belief.log_ratio_std / np.sqrt([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
        rows.append(((belief.log_ratio - logarithm) / std, _placed_columns(slopes / std[:, None], 0, width)))
    for key, mean, std in belief.effects:
        for first, each, value in zip(_firsts(placed), placed, values.effects, strict=True):
            if each.key == key:
                rows.append(((mean - value[0]) / std, _placed_columns(np.diag(1.0 / std), first, width)))
    if values.trim is not None and np.isfinite(belief.trim_std).all():
        trims = values.trim[np.unique(runs.trim_of, return_index=True)[1], 0]
        std = np.tile(belief.trim_std, len(trims))
        away = (belief.trim - trims).ravel() / std
        rows.append((away, _placed_columns(np.diag(1.0 / std), width - len(away), width)))
    if not rows:
        return np.zeros(0), np.zeros((0, width))
    return np.concatenate([away for away, _ in rows]), np.concatenate([slopes for _, slopes in rows])


def _firsts(placed: Sequence[Hypothesis]) -> list[int]:
    """Return the first column of every effect."""
    return [int(first) for first in np.cumsum([6, *(each.size for each in placed)])[:-1]]


def _placed_columns(block: Array, first: int, width: int) -> Array:
    matrix = np.zeros((len(block), width))
    matrix[:, first : first + block.shape[1]] = block
    return matrix


def moved(fit: Fit, step: Array) -> Values:
    """Return a fit's parameters after a step, the effects' kept inside their bounds.

    Args:
        fit: to start from.
        step: of (θ, effects, ω₀ of every run, trim of every record), shape (C + 3 R,) without trims.
    """
    lower, upper = bounds_of(fit.placed)
    common, rates, trim = 6 + len(lower), fit.values.initial_rate, fit.values.trim
    effects = np.clip(fit.effect_values + step[6:common], lower, upper)
    sizes = np.cumsum([value.shape[1] for value in fit.values.effects])[:-1]
    own = step[common:].reshape(-1, 1, 3)
    return Values(
        theta=fit.values.theta + step[:6] if fit.belief is None else fit.belief.moved(fit.theta, step[:6])[None],
        initial_rate=rates + own[: len(rates)],
        effects=tuple(part[None] for part in np.split(effects, sizes)) if len(fit.placed) else (),
        trim=None if trim is None else trim + own[len(rates) :][fit.trim_of],
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


_TRIALS = 16
"""Steps of a search: that for a mode that is there takes 4 to 8; for one that is not it wanders along its valley, 25
steps and more, until it is stopped. Of 126 fits of effects without a scan (cases 9 and 12 of 14 of seed 90817) none
takes more than four."""
_ENOUGH = 1e-3
"""Gain in χ² that is no longer searched for; one standard error of a parameter is a gain of 1, so that 1e-3 is 3 % of
it. With 0.1, χ² ends up to 0.08 higher in the same fits."""
_DAMPING = (1e-6, 1e6)
"""Smallest and largest Levenberg-Marquardt damping, in shares of the normal matrix's diagonal: the least bends a step
by a millionth where a direction is known, the greatest makes steps of a millionth of the slope's. With a least damping
of 1e-3, χ² ends up to 0.007 higher in the fits above."""
_FACTOR = 10.0
"""By which damping falls after a step that gains, and rises after one that does not; after the next, by its square.

Source: the factor 10 of Marquardt, "An algorithm for least-squares estimation of nonlinear parameters", SIAM (1963).
"""


def fitted(runs: Runs, placed: Sequence[Hypothesis], theta: Theta, starts: Sequence[Array]) -> Fit:
    """Fit inertia, initial rates, trims where they are free, and effects by maximum likelihood.

    Args:
        runs: to fit.
        placed: the effects in the model.
        theta: to start from, shape (6,), kg·m².
        starts: of each effect's parameters, shapes (K,).

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
            found.append(_search(runs, tuple(placed), _from_first_samples(runs, each[None], effects)))
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
    means = {} if runs.belief is None else {key: mean for key, mean, _ in runs.belief.effects}
    return [means[each.key] for each in given]


def refit(runs: Runs, fit: Fit) -> Fit:
    """Return a model fitted to runs, from where another fit of it ended."""
    if runs.belief is not None:  # many windows, of which each fit is dear
        return _search(runs, fit.placed, fit.values)
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
    # What keeps a platform from turning ever faster is that the mean torque is nearly zero, whatever telemetry says.
    trim = -runs.mean_torque if runs.trimmed else None
    return Values(theta=theta, initial_rate=first, effects=tuple(effects), trim=trim)


def _search(runs: Runs, placed: tuple[Hypothesis, ...], values: Values, *, only_initial: bool = False) -> Fit:
    return part(
        "search",
        (runs, [each.key for each in placed], values, only_initial),
        work=lambda: _searched(runs, placed, values, only_initial=only_initial),
        to_content=lambda fit: _to_content(fit.values),
        from_content=lambda content: evaluated(runs, placed, _from_content(content)),
    )


def _to_content(values: Values) -> Content:
    trim = {} if values.trim is None else {"trim": array_to_content(values.trim)}
    return trim | {"values": [array_to_content(each) for each in (values.theta, values.initial_rate, *values.effects)]}


def _from_content(content: Content) -> Values:
    theta, initial_rate, *effects = map(array_from_content, content["values"])
    trim = array_from_content(content["trim"]) if "trim" in content else None
    return Values(theta=theta, initial_rate=initial_rate, effects=tuple(effects), trim=trim)


def _searched(runs: Runs, placed: tuple[Hypothesis, ...], values: Values, *, only_initial: bool) -> Fit:
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
    slope, normal = fit.jacobian.T @ fit.residual, fit.normal
    moving = free & ~pushing_out(fit, slope)
    if fit.belief is None:
        return _solved(normal, slope, moving, damping)
    ways, limits = fit.belief.ways(fit.theta)
    slope, normal = slope.copy(), normal.copy()
    slope[:6], normal[:6] = ways.T @ slope[:6], ways.T @ normal[:6]
    normal[:, :6] = normal[:, :6] @ ways
    moving[:6] &= (limits * slope[:6] <= 0.0) & (fit.belief.log_ratio_std > 0.0)
    step, expected = _solved(normal, slope, moving, damping)
    step[:6] = ways @ step[:6]
    return step, expected


def _solved(normal: Array, slope: Array, moving: Flags, damping: float) -> tuple[Array, float]:
    step = np.zeros(len(slope))
    step[moving] = damped(normal[np.ix_(moving, moving)], slope[moving], damping)
    return step, float(slope @ step)


def damped(normal: Array, slope: Array, damping: float = 0.0) -> Array:
    """Return the step that solves a normal matrix, damped by a share of its diagonal; none along what nothing shows."""
    shown = np.diag(normal) > 0.0
    if not shown.all():
        step = np.zeros(len(slope))
        step[shown] = damped(normal[np.ix_(shown, shown)], slope[shown], damping) if shown.any() else 0.0
        return step
    scale = np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    scaled = normal / np.outer(scale, scale) + damping * np.eye(len(scale))
    if len(scale) > _MANY:
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
    """Return the fit at other values if χ² is not larger there."""
    try:
        trial = evaluated(runs, fit.placed, values)
    except InputError:
        return None
    return trial if trial.chi_square <= fit.chi_square else None


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
    deviance = np.inf
    for _ in range(_NOISE_ROUNDS):
        noise = torque_noise([run.gyro_time for run in runs.grid.runs], runs.gyro_residual(fit.residual))
        if runs.belief is not None and runs.belief.torque_noise is not None:
            noise = np.maximum(noise, runs.belief.torque_noise)
        runs = replace(runs, torque_noise=noise)
        fit = refit(runs, fit)
        if abs(deviance - fit.deviance) < _NOISE_FOUND:
            break
        deviance = fit.deviance
    freedom = min(runs.noise_freedom, _freedom_of_scatter(runs, fit))
    runs = replace(runs, noise_freedom=freedom)
    return runs, heldout and replace(heldout, torque_noise=noise, noise_freedom=freedom), fit


def _freedom_of_scatter(runs: Runs, fit: Fit) -> float:
    """Return the degrees of freedom with which records agree on their noise: a variance of ν has the variance 2/ν."""
    squares = np.array([float(np.mean(part**2)) for part in runs.by_run(fit.residual)])
    counts = np.bincount(runs.record_of)
    if len(counts) == 1:
        return np.inf
    scatter = np.var(np.bincount(runs.record_of, squares) / counts, ddof=1)
    return max(2.0 / max(float(scatter), np.finfo(float).tiny), float(len(counts)))


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
    return corrected_runs, corrected(heldout, fitted_initial_rates(heldout, fit))
