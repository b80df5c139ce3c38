"""Is there a torque that no named effect explains? A latent random-walk torque on each axis, and how likely it is.

The residual r of the present model, with all that the model can absorb projected out, is N(0, 1) if nothing is missing,
and N(0, 1 + q G Gᵀ) if a torque whose increments have the variance q acts on the platform. The likelihood ratio of the
two tests for the unknown, and gives it a place among the hypotheses.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import final

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import minimize_scalar
from scipy.stats import chi2
from typing_extensions import override

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.evidence import on_enough_runs
from testbed.diagnosis.keeping import Content, array_made, array_told, part
from testbed.diagnosis.model import Fit
from testbed.diagnosis.projection import orthonormal, projected_out
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.prediction import common_size, predicted_with_derivatives

KNOTS_PER_SECOND = 8.0
"""Hat functions of the torque: enough for 4 Hz, the fastest that 16 Hz samples tell from noise."""
_FEWEST_KNOTS = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class LatentTorque:
    """What the residual says of a torque that the model lacks.

    Attributes:
        likelihood_ratio: 2 (log L(q̂) - log L(0)).
        p_value: of the ratio if there is no such torque; q cannot be negative.
        runs: names of those that were looked at.
        knot_time: of each run, shape (R, T), s.
        torque_B: the smoothed torque, shape (R, T, 3), N·m, body axes; zero where q̂ = 0.
    """

    likelihood_ratio: float
    p_value: float
    runs: tuple[str, ...]
    knot_time: Array
    torque_B: Array


def latent_torque(runs: Runs, fit: Fit) -> LatentTorque:
    """Estimate the variance of a random-walk torque, and the torque itself, from the residual of a fit.

    Args:
        runs: that were fitted; an even choice of them where there are very many.
        fit: of the present model to them.
    """
    return part(
        "latent torque",
        (runs, [each.key for each in fit.placed], fit.values, fit.residual),
        work=lambda: _latent_torque(runs, fit),
        told=_told,
        made=_made,
    )


def _told(latent: LatentTorque) -> Content:
    arrays = {"knot_time": array_told(latent.knot_time), "torque_B": array_told(latent.torque_B)}
    return {field.name: getattr(latent, field.name) for field in fields(latent)} | arrays


def _made(content: Content) -> LatentTorque:
    arrays = {name: array_made(content[name]) for name in ("knot_time", "torque_B")}
    return LatentTorque(**content | arrays | {"runs": tuple(content["runs"])})


def _latent_torque(runs: Runs, fit: Fit) -> LatentTorque:
    runs, fit = on_enough_runs(runs, fit)
    knots = max(_FEWEST_KNOTS, int(np.ceil(KNOTS_PER_SECOND * float(np.ptp(runs.grid.node_time, axis=1).max()))))
    # From its increments to the torque at the knots.
    walk = np.asarray(np.kron(np.tril(np.ones((knots, knots))), np.eye(3)), dtype=np.float64)
    power, slope, directions = _spread(runs, fit, torque_response(runs, fit, knots), walk)
    variance = _likeliest(power, slope)
    increments = directions @ (variance * slope / (1.0 + variance * power))
    torque_B = (increments.reshape(len(runs.names), -1) @ walk.T).reshape(len(runs.names), knots, 3)
    ratio = 2.0 * _log_likelihood(variance, power, slope)
    ends = runs.grid.node_time[:, [0, -1]]
    return LatentTorque(
        likelihood_ratio=ratio,
        p_value=0.5 * float(chi2.sf(ratio, 1)) if variance > 0.0 else 1.0,
        runs=runs.names,
        knot_time=np.linspace(ends[:, 0], ends[:, 1], knots, axis=1),
        torque_B=torque_B,
    )


def _spread(runs: Runs, fit: Fit, columns: Array, walk: Array) -> tuple[Array, Array, Array]:
    """Return what the increments do to the residual, all that the model can do projected out.

    Runs share few parameters, so that the normal matrix is that of each run less a product of small matrices: its cost
    grows as the samples do.

    Args:
        runs: to be explained.
        fit: of the model.
        columns: response to the torque at every knot, shape (samples, R * knots * 3).
        walk: from a run's increments to its torque, shape (knots * 3, knots * 3).

    Returns:
        The normal matrix's eigenvalues, the slope along its eigenvectors, and the eigenvectors as columns.
    """
    common, width = 6 + len(fit.effect_values), len(walk)
    edges = np.cumsum([0, *(rates.size for rates in runs.measured)])
    parts = []
    for run, rows in enumerate(slice(*ends) for ends in pairwise(edges.tolist())):
        # A torque on the body shows in the gyro's samples, which come first.
        own = orthonormal(fit.jacobian[rows, common + 3 * run : common + 3 * run + 3])
        response = columns[rows, run * width : (run + 1) * width] @ walk
        part = np.hstack([response, fit.jacobian[rows, :common], fit.residual[rows, None]])
        parts.append(projected_out(part, own))
    shared = orthonormal(np.concatenate([part[:, width:-1] for part in parts]))
    residual = projected_out(np.concatenate([part[:, -1] for part in parts]), shared)
    by_run = list(zip(np.split(shared, edges[1:-1]), np.split(residual, edges[1:-1]), parts, strict=True))
    along = np.hstack([basis.T @ part[:, :width] for basis, _, part in by_run])
    normal = block_diag(*(part[:, :width].T @ part[:, :width] for part in parts)) - along.T @ along
    slope = np.concatenate([part[:, :width].T @ rest for _, rest, part in by_run])
    power, directions = np.linalg.eigh(normal)
    return np.maximum(power, 0.0), directions.T @ slope, directions


@final
class _Hats(Hooks):
    """A torque that is linear between knots, the same knots in every run as shares of its length."""

    @override
    def applied_torque(self, torque_B: Array, value: Array, grid: Grid) -> Array:
        knots = value.reshape(len(value), -1, 3)
        at, places = np.linspace(0.0, 1.0, knots.shape[1]), np.linspace(0.0, 1.0, grid.time.shape[1])
        hats = np.stack([np.interp(places, at, hat) for hat in np.eye(len(at))], axis=-1)
        return np.asarray(torque_B[:, :, -len(places) :] + hats @ knots)


def torque_response(runs: Runs, fit: Fit, knots: int) -> Array:
    """Return the gyro's whitened response to a torque at every knot of every run, shape (samples, R * knots * 3).

    Args:
        runs: to be explained.
        fit: of the present model to them.
        knots: of each run, evenly from its first sample to its last; the torque is linear between them.
    """
    effects = (*fit.values.effects, np.zeros((1, 3 * knots)))
    common = common_size(fit.values.effects)
    values = replace(fit.values, effects=effects)
    hooks = [*(each.hooks for each in fit.placed), _Hats()]
    _, derivatives = predicted_with_derivatives(runs.grid, hooks, values, range(common, common + 3 * knots))
    blocks = [
        (derivative / sigma[:, None]).reshape(-1, 3 * knots)
        for derivative, sigma in zip(derivatives, runs.sigma, strict=True)
    ]
    return np.asarray(block_diag(*blocks))


def _log_likelihood(variance: float, power: Array, slope: Array) -> float:
    """Log L(q) - log L(0) of independent components with variances 1 + q s², and slopes s times their values."""
    return float(0.5 * (slope**2 * variance / (1.0 + variance * power) - np.log1p(variance * power)).sum())


def _likeliest(power: Array, slope: Array) -> float:
    """Return q̂ >= 0."""
    scale = 1.0 / max(power.max(initial=0.0), np.finfo(float).tiny)
    found = minimize_scalar(
        lambda exponent: -_log_likelihood(scale * np.exp(exponent), power, slope),
        bounds=(-12.0, 25.0),
        method="bounded",
    )
    variance = scale * float(np.exp(found.x))
    return variance if _log_likelihood(variance, power, slope) > 0.0 else 0.0
