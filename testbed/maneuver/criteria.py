"""Optimality criteria of the information matrix as smooth, exact CasADi expressions.

D and A are costs by themselves. E and the condition number are bounds on eigenvalues, not smooth where two of them
meet: they become slack variables, a floor t with M - tI = L Lᵀ and a ceiling u with uI - M = K Kᵀ, which is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import casadi as ca
import numpy as np

from testbed.arrays import Array, Covariance
from testbed.maneuver.information import FIRST_FACTOR, SECOND_FACTOR, SUBDIVISIONS, SampledFilter, regressor_features

Criterion: TypeAlias = Literal["D", "A", "E", "condition"]
"""Determinant, trace of the inverse, smallest eigenvalue, condition number."""
_BLOCK = 256
"""Samples of a block of the prefilter; a minute at 4 Hz is one."""
_SIGNAL_WEIGHT = 0.3
"""Weight of the mean log eigenvalue beside log κ: the condition number alone is met by no motion at all."""


@dataclass(frozen=True, kw_only=True)
class CriterionTerms:
    """What a criterion adds to an optimisation problem.

    Attributes:
        cost: to be minimised.
        slack: its own variables, a column; empty for D and A.
        equality: expressions that are zero, a column; empty likewise.
        slack_start: the slack's values at a motion with the given information matrix, shape (6, 6).
    """

    cost: ca.MX
    slack: ca.MX
    equality: ca.MX
    slack_start: Callable[[Covariance], Array]


def information_matrix(sampling: SampledFilter, body_rate: ca.MX) -> ca.MX:
    """Return M = Ψ_fᵀΨ_f, shape (6, 6).

    With ψ_f = T_i f for each axis i and the features f of a sample, M = Σ_i T_i (Σ f fᵀ) T_iᵀ.

    Args:
        sampling: prefilter and grids.
        body_rate: ω on the fine grid, shape (M, 3), rad/s, body axes.

    Source: paper eqs. (17), (22), (23).
    """
    swing = body_rate - ca.repmat(body_rate[0, :], body_rate.shape[0], 1)
    products = body_rate[:, list(FIRST_FACTOR)] * body_rate[:, list(SECOND_FACTOR)]
    lagged = _filtered(sampling, ca.horzcat(swing, products))
    slope = (swing[sampling.samples, :] - lagged[:, :3]) / sampling.time_constant  # s F ω, nothing differentiated
    features = ca.horzcat(slope, lagged[:, 3:])
    gram = features.T @ features
    x, y, z = (ca.DM(axis) @ gram @ ca.DM(axis).T for axis in regressor_features())
    return x + y + z


def _filtered(sampling: SampledFilter, signal: ca.MX) -> ca.MX:
    """Return F x at the gyro's samples of x on the fine grid, as `testbed.maneuver.information.filtered`.

    Within a block of samples all that is left of earlier periods is one triangular matrix times what they add; from
    block to block it goes on from the last sample, so that the matrices grow with the samples and not with their
    square.
    """
    added = _added(sampling) @ signal
    samples = added.shape[0]
    period = sampling.fine_time[sampling.samples][1]
    ages = np.arange(min(_BLOCK, samples)) * period
    carry = ca.sparsify(ca.DM(np.tril(np.exp(-np.subtract.outer(ages, ages) / sampling.time_constant))))
    fade = ca.DM(np.exp(-(ages + period) / sampling.time_constant))
    blocks: list[ca.MX] = []
    for first in range(0, samples, _BLOCK):
        within = added[first : min(first + _BLOCK, samples), :]
        count = within.shape[0]
        block = carry[:count, :count] @ within
        blocks.append(block + fade[:count] @ blocks[-1][-1, :] if blocks else block)
    return blocks[0] if len(blocks) == 1 else ca.vertcat(*blocks)


def _added(sampling: SampledFilter) -> ca.DM:
    """Return the matrix of what the fine samples of each period add to F x at its end, shape (N, M)."""
    fine, periods = len(sampling.fine_time), len(sampling.fine_time) // SUBDIVISIONS
    rows = np.repeat(np.arange(1, periods + 1), SUBDIVISIONS + 1)
    columns = (np.arange(periods)[:, None] * SUBDIVISIONS + np.arange(SUBDIVISIONS + 1)).ravel()
    weights = np.tile(sampling.weights, periods)
    return ca.DM.triplet(rows.tolist(), columns.tolist(), ca.DM(weights), periods + 1, fine)


def criterion_terms(criterion: Criterion, information: ca.MX) -> CriterionTerms:
    """Return a criterion's cost and what it needs besides.

    Args:
        criterion: which one.
        information: M, shape (6, 6); of any size for D and A.

    Source: paper section 4.1.
    """
    return _TERMS[criterion](information)


def _determinant(information: ca.MX) -> CriterionTerms:
    """-log det M = -2 Σ log of the Cholesky factor's diagonal. Source: paper eq. (24)."""
    return _plain(-2.0 * ca.sum1(ca.log(ca.diag(_cholesky(information)))))


def _trace_inverse(information: ca.MX) -> CriterionTerms:
    """Log of trace(M⁻¹) = |L⁻¹|², of the INVERSE; the logarithm scales and does not move the optimum."""
    return _plain(ca.log(ca.sumsqr(ca.solve(_cholesky(information), ca.MX.eye(information.shape[0])))))


def _smallest_eigenvalue(information: ca.MX) -> CriterionTerms:
    log_floor, factor = ca.MX.sym("log_floor"), ca.MX.sym("factor", _LOWER.nnz())
    return CriterionTerms(
        cost=-log_floor,
        slack=ca.vertcat(log_floor, factor),
        equality=_semidefinite(information - ca.exp(log_floor) * ca.MX.eye(6), factor),
        slack_start=_floor_start,
    )


def _condition_number(information: ca.MX) -> CriterionTerms:
    """Bounds on M over its mean eigenvalue: at any size alike, the floor below 1 and the ceiling 1 + e² above."""
    mean = ca.trace(information) / 6.0
    floor = _smallest_eigenvalue(information / mean)
    excess, factor = ca.MX.sym("excess"), ca.MX.sym("ceiling_factor", _LOWER.nnz())
    ceiling = 1.0 + excess**2
    return CriterionTerms(
        cost=ca.log(ceiling) + floor.cost + _SIGNAL_WEIGHT / 6.0 * _determinant(information).cost,
        slack=ca.vertcat(floor.slack, excess, factor),
        equality=ca.vertcat(floor.equality, _semidefinite(ceiling * ca.MX.eye(6) - information / mean, factor)),
        slack_start=_ratio_start,
    )


_TERMS: dict[Criterion, Callable[[ca.MX], CriterionTerms]] = {
    "D": _determinant,
    "A": _trace_inverse,
    "E": _smallest_eigenvalue,
    "condition": _condition_number,
}
_LOWER = ca.Sparsity.lower(6)
_ROWS, _COLUMNS = _LOWER.get_triplet()


def _plain(cost: ca.MX) -> CriterionTerms:
    return CriterionTerms(cost=cost, slack=ca.MX(0, 1), equality=ca.MX(0, 1), slack_start=lambda _: np.zeros(0))


def _cholesky(matrix: ca.MX) -> ca.MX:
    """Lower Cholesky factor; CasADi factors scalar expressions only, so the matrix goes through a function."""
    entries = ca.SX.sym("entries", *matrix.shape)
    return ca.Function("cholesky", [entries], [ca.chol(entries).T])(matrix)


def _semidefinite(matrix: ca.MX, factor: ca.MX) -> ca.MX:
    """Lower triangle of matrix - L Lᵀ; zero for some L exactly where the matrix has no negative eigenvalue."""
    lower = ca.MX(_LOWER, factor)
    return ca.project(matrix - lower @ lower.T, _LOWER).nz[:]


def _floor_start(information: Covariance) -> Array:
    floor = 0.5 * np.linalg.eigvalsh(information)[0]  # half: the factor starts away from singular
    return np.concatenate([[np.log(floor)], _factor(information - floor * np.eye(6))])


def _ratio_start(information: Covariance) -> Array:
    share = information / (np.trace(information) / 6.0)
    ceiling = 1.0 + 2.0 * np.linalg.eigvalsh(share)[-1]
    above = _factor(ceiling * np.eye(6) - share)
    return np.concatenate([_floor_start(share), [np.sqrt(ceiling - 1.0)], above])


def _factor(matrix: Covariance) -> Array:
    return np.asarray(np.linalg.cholesky(matrix)[_ROWS, _COLUMNS])
