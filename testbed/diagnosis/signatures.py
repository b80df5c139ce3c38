"""Signatures of hypotheses: first-order changes of the measurements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import sqrt

import numpy as np
import scipy

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import NEGLIGIBLE, Fit, Hypothesis, orthonormal, projected_out
from testbed.diagnosis.settings import SETTINGS
from testbed.effects.checking import blamed_on_own
from testbed.prediction.prediction import (
    common_size,
    derivatives_at,
    predicted_channels,
    predicted_with_derivatives,
)

_UNSEEN = 1e-3
"""Sigma: a parameter whose typical size does less than this, such as the frequency of a speck of mass, is left out.
Of 326 signatures (cases 2 and 12 of 14 of seed 90817) none has a parameter between 1e-4 and 0.1."""
_DEPENDENT = 1e-7
"""Share of the largest singular value of an effect's columns, scaled alike, below which a direction of it is not seen:
its square, the information, is then 1e-14 of the largest, which is rounding."""
_TOGETHER = 6
"""Hypotheses that are predicted together. An effect costs something at all parameter sets of its batch, and a batch the
motion without any: on five runs at 16 Hz all 62 take 1.1 s with 4 or 8 together, 2.1 s one by one, 4.5 s at once."""
_SHIFTS_KEPT = 256
"""Noncentralities that are kept, by rank and number of hypotheses; a miss costs 8 ms."""
_SHIFTS = (1e-6, 1e4)
"""Between which the noncentrality of a χ² is found that is significant with the power wanted: at the first the power is
the level itself, at the second it is one for any number of hypotheses below 1e300."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reach:
    """How far an effect of its typical size moves the samples at one of its starts.

    Attributes:
        absent: parameters of the effect there without any size, shape (K,).
        typical: change of the parameters to its typical size, shape (K,).
        length: of what that changes, in sigma.
        rank: directions that the data show.
    """

    absent: Array
    typical: Array
    length: float
    rank: int

    def multiple(self, hypotheses: int) -> float:
        """Return the size, as a multiple of the typical one, that would be detected with the power wanted.

        Args:
            hypotheses: tested together.
        """
        if self.rank == 0 or self.length == 0.0:
            return np.inf
        return required_shift(self.rank, hypotheses) / self.length


@dataclass(frozen=True, kw_only=True, eq=False)
class Start:
    """What the data say of a hypothesis linearised at one of its starts.

    Attributes:
        values: of its parameters there, shape (K,).
        information: of its parameters, all else projected out, shape (K, K).
        slope: of the log-likelihood, shape (K,).
        step: of the parameters that explains the most inside their bounds, shape (K,).
        score: how much of χ² that explains.
    """

    values: Array
    information: Array
    slope: Array
    step: Array
    score: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Signature:
    """A hypothesis linearised about the present model.

    Attributes:
        placed: effect and component.
        start: values of its parameters at which it is linearised, shape (K,).
        columns: whitened ∂prediction/∂parameters after projection, shape (samples, K).
        basis: orthonormal basis of what they span, shape (samples, rank).
        score: how much of χ² the linearised effect explains, its parameters inside their bounds.
        step: the change of its parameters that does so, shape (K,).
        slope: of the log-likelihood of the parameters, shape (K,).
        elsewhere: what the data say at the hypothesis's other starts, once those were compared.
        reaches: how far it moves the samples at each of its starts, once those were compared; of a scan over
            frequencies.
    """

    placed: Hypothesis
    start: Array
    columns: Array
    basis: Array
    score: float
    step: Array
    slope: Array
    elsewhere: tuple[Start, ...] = ()
    reaches: tuple[Reach, ...] = ()

    @property
    def here(self) -> Start:
        """What the data say at this start."""
        information = self.columns.T @ self.columns
        return Start(values=self.start, information=information, slope=self.slope, step=self.step, score=self.score)

    @property
    def rank(self) -> int:
        """Number of independent directions that the data show."""
        return int(self.basis.shape[1])


def signatures(runs: Runs, fit: Fit, hypotheses: Sequence[Hypothesis]) -> Iterator[Signature]:
    """Return the signature of every hypothesis at each of its starts, in order.

    Args:
        runs: that the model was fitted to.
        fit: the present model; its parameters are projected out.
        hypotheses: effects that are not in it.
    """
    nuisance = orthonormal(fit.jacobian)
    residual = projected_out(fit.residual, nuisance)
    with blamed_on_own([placed.effect for placed in hypotheses]):
        for placed, start, columns in _linearised(runs, fit, hypotheses):
            beside_beliefs = np.pad(columns, ((0, fit.believed), (0, 0))) if fit.believed else columns
            free = projected_out(beside_beliefs, nuisance)
            yield _signature(placed, start, beside_beliefs, free, residual)


@lru_cache(maxsize=_SHIFTS_KEPT)
def required_shift(rank: int, hypotheses: int) -> float:
    """Return the length in sigma of a signature that is detected with the power wanted.

    Args:
        rank: degrees of freedom of the test.
        hypotheses: tested together, by which the family-wise error is divided (Bonferroni).
    """
    threshold = scipy.stats.chi2.isf(SETTINGS.family_wise_error / hypotheses, rank)
    return sqrt(
        scipy.optimize.brentq(lambda shift: scipy.stats.ncx2.sf(threshold, rank, shift) - SETTINGS.power, *_SHIFTS)
    )


def smallest_detectable(signature: Signature, hypotheses: int) -> float:
    """Return the size, as a multiple of the effect's typical one, that would be detected with the power wanted.

    Infinite where the data show nothing of it.
    """
    typical = np.array([parameter.typical - parameter.absent for parameter in signature.placed.effect.parameters])
    length = float(np.linalg.norm(signature.columns @ typical))
    if signature.rank == 0 or length == 0.0:
        return np.inf
    return required_shift(signature.rank, hypotheses) / length


def reach_of(signature: Signature) -> Reach:
    """Return how far an effect moves the samples at its start, of its typical size along the start's own direction."""
    parameters = signature.placed.effect.parameters
    fixed = np.array([parameter.scanned for parameter in parameters])
    speck, typical = (
        np.where(fixed, 0.0, signature.start),
        np.array([each.typical - each.absent for each in parameters]),
    )
    typical = np.where(fixed, 0.0, typical)
    if speck.any():
        typical = np.linalg.norm(typical) * speck / np.linalg.norm(speck)
    return Reach(
        absent=np.where(fixed, signature.start, 0.0),
        typical=typical,
        length=float(np.linalg.norm(signature.columns @ typical)),
        rank=signature.rank,
    )


def distinguishability(one: Signature, other: Signature) -> float:
    """Return the sine of the smallest angle between two signatures: 0 for aliases, 1 for orthogonal ones."""
    if one.rank == 0 or other.rank == 0:
        return 0.0
    largest = float(np.linalg.svd(one.basis.T @ other.basis, compute_uv=False)[0])
    return sqrt(max(0.0, 1.0 - min(largest, 1.0) ** 2))


def _linearised(runs: Runs, fit: Fit, hypotheses: Sequence[Hypothesis]) -> Iterator[tuple[Hypothesis, Array, Array]]:
    """Return each hypothesis, a start, and its whitened columns; those that start absent are predicted together."""
    starts = [(placed, placed.effect.starts(placed.component, runs.grid)) for placed in hypotheses]
    absent = [(placed, rows[0]) for placed, rows in starts if _is_absent(placed, rows)]
    for first in range(0, len(absent), _TOGETHER):
        together = absent[first : first + _TOGETHER]
        columns = _columns(runs, fit, together)
        edges = np.cumsum([placed.size for placed, _ in together])[:-1]
        for (placed, start), part in zip(together, np.split(columns, edges, axis=1), strict=True):
            yield placed, start, part
    for placed, rows in starts:
        if len(rows) and not _is_absent(placed, rows):
            for start, columns in zip(rows, _scanned_columns(runs, fit, placed, rows), strict=True):
                yield placed, start, columns


def _is_absent(placed: Hypothesis, starts: Array) -> bool:
    return len(starts) == 1 and starts[0].tolist() == [each.absent for each in placed.effect.parameters]


def _columns(runs: Runs, fit: Fit, added: Sequence[tuple[Hypothesis, Array]]) -> Array:
    """Return whitened ∂prediction/∂parameters of hypotheses added to the model, shape (samples, sum of K)."""
    effects = (*fit.values.effects, *(start[None] for _, start in added))
    hooks = [each.hooks for each in (*fit.placed, *(placed for placed, _ in added))]
    wanted = range(common_size(fit.values.effects), common_size(effects))
    values = replace(fit.values, effects=effects)
    _, derivatives = predicted_with_derivatives(runs.grid, hooks, values, wanted, predicted_channels)
    return np.concatenate(runs.whitened_columns(derivatives))


def _scanned_columns(runs: Runs, fit: Fit, placed: Hypothesis, starts: Array) -> Array:
    """Return whitened ∂prediction/∂parameters of one hypothesis at each of its starts, shape (S, samples, K)."""
    hooks = [each.hooks for each in (*fit.placed, placed)]
    shown = [index for index, parameter in enumerate(placed.effect.parameters) if not parameter.scanned]
    derivatives = derivatives_at(runs.grid, hooks, fit.values, starts, shown, predicted_channels)
    at_starts = [runs.whitened_columns([block[index] for block in derivatives]) for index in range(len(starts))]
    return np.stack([np.concatenate(columns) for columns in at_starts])


def _signature(placed: Hypothesis, start: Array, columns: Array, free: Array, residual: Array) -> Signature:
    scale = np.linalg.norm(columns, axis=0)
    typical = np.abs([parameter.typical for parameter in placed.effect.parameters])
    usable = np.where(scale * typical > _UNSEEN, scale, np.inf)
    left, strength, right = np.linalg.svd(free / usable, full_matrices=False)
    seen = strength > max(NEGLIGIBLE, _DEPENDENT * strength.max(initial=0.0))
    basis, present = left[:, seen], left[:, seen].T @ residual
    step = (right[seen].T @ (present / strength[seen])) / usable
    lower, upper = (bound - start for bound in placed.reach(start))
    if np.any((step < lower) | (step > upper)):
        step = _bounded(basis.T @ free, present, lower, upper, usable)
    missed = present - basis.T @ (free @ step)
    return Signature(
        placed=placed,
        start=start,
        columns=free,
        basis=basis,
        score=float(present @ present - missed @ missed),
        step=step,
        slope=free.T @ residual,
    )


def _bounded(columns: Array, present: Array, lower: Array, upper: Array, scale: Array) -> Array:
    """Return the step inside the bounds that explains the most: no delay is negative, whatever that explains."""
    step, used = np.zeros(len(scale)), np.isfinite(scale) & (upper > lower)
    if used.any():
        bounds = (lower[used] * scale[used], upper[used] * scale[used])
        scaled = columns[:, used] / scale[used]  # a few: which of them are at a bound is found in a tenth of the time
        step[used] = scipy.optimize.lsq_linear(scaled, present, bounds, method="bvls").x / scale[used]
    return step
