"""Is there a torque that no named effect explains? A latent random-walk torque on each axis, and how likely it is.

The residual r of the present model, with all that the model can absorb projected out, is N(0, 1) if nothing is missing,
and N(0, 1 + q G Gᵀ) if a torque whose increments have the variance q acts on the platform. The likelihood ratio of the
two tests for the unknown, and gives it a place among the hypotheses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import minimize_scalar
from scipy.stats import chi2
from typing_extensions import override

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, orthonormal
from testbed.prediction.hooks import Hooks, Instant
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
        knot_time: of each run, shape (R, T), s.
        torque_B: the smoothed torque, shape (R, T, 3), N·m, body axes; zero where q̂ = 0.
    """

    likelihood_ratio: float
    p_value: float
    knot_time: Array
    torque_B: Array


def latent_torque(runs: Runs, fit: Fit) -> LatentTorque:
    """Estimate the variance of a random-walk torque, and the torque itself, from the residual of a fit."""
    knots = max(_FEWEST_KNOTS, int(np.ceil(KNOTS_PER_SECOND * float(np.ptp(runs.grid.node_time, axis=1).max()))))
    columns = torque_response(runs, fit, knots)
    # From its increments to the torque at the knots.
    walk = np.asarray(np.kron(np.tril(np.ones((knots, knots))), np.eye(3)), dtype=np.float64)
    nuisance = orthonormal(fit.jacobian[: runs.samples])  # a torque on the body shows in the gyro's samples
    spread = columns @ _for_every_run(walk, len(runs.names))
    spread = spread - nuisance @ (nuisance.T @ spread)
    residual = fit.residual[: runs.samples]
    residual = residual - nuisance @ (nuisance.T @ residual)
    left, strength, right = np.linalg.svd(spread, full_matrices=False)
    seen = (left.T @ residual) ** 2
    variance = _likeliest(strength**2, seen)
    ratio = 2.0 * (_log_likelihood(variance, strength**2, seen))
    weight = variance * strength / (1.0 + variance * strength**2)
    increments = right.T @ (weight * (left.T @ residual))
    torque_B = (_for_every_run(walk, len(runs.names)) @ increments).reshape(len(runs.names), knots, 3)
    ends = runs.grid.node_time[:, [0, -1]]
    return LatentTorque(
        likelihood_ratio=ratio,
        p_value=0.5 * float(chi2.sf(ratio, 1)) if variance > 0.0 else 1.0,
        knot_time=np.linspace(ends[:, 0], ends[:, 1], knots, axis=1),
        torque_B=torque_B,
    )


@final
class _Hats(Hooks):
    """A torque that is linear between knots, the same knots in every run as shares of its length."""

    def __init__(self, start: Array, step: Array) -> None:
        """Take the first knot and the distance of knots of every run, shape (R, 1), s."""
        self._start, self._step = start, step

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        knots = value.reshape(len(value), -1, 3)
        place = (at.time - self._start) / self._step
        index = np.clip(place.astype(np.intp), 0, knots.shape[1] - 2)[:, 0]
        part = (place[:, 0] - index)[:, None, None]
        by_run = np.moveaxis(knots, 1, 0)
        return by_run[index] * (1.0 - part) + by_run[index + 1] * part


def torque_response(runs: Runs, fit: Fit, knots: int) -> Array:
    """Return the gyro's whitened response to a torque at every knot of every run, shape (samples, R * knots * 3).

    Args:
        runs: to be explained.
        fit: of the present model to them.
        knots: of each run, evenly from its first sample to its last; the torque is linear between them.
    """
    start, end = runs.grid.node_time[:, :1], runs.grid.node_time[:, -1:]
    hats = _Hats(start, (end - start) / (knots - 1))
    effects = (*fit.values.effects, np.zeros((1, 3 * knots)))
    common = common_size(fit.values.effects)
    values = replace(fit.values, effects=effects)
    hooks = [*(each.hooks for each in fit.placed), hats]
    _, derivatives = predicted_with_derivatives(runs.grid, hooks, values, range(common, common + 3 * knots))
    blocks = [
        (derivative / sigma[:, None]).reshape(-1, 3 * knots)
        for derivative, sigma in zip(derivatives, runs.sigma, strict=True)
    ]
    return np.asarray(block_diag(*blocks))


def _for_every_run(matrix: Array, runs: int) -> Array:
    return np.asarray(np.kron(np.eye(runs), matrix), dtype=np.float64)


def _log_likelihood(variance: float, power: Array, seen: Array) -> float:
    """Log L(q) - log L(0) of independent components with variances 1 + q s²."""
    return float(0.5 * (seen * (1.0 - 1.0 / (1.0 + variance * power)) - np.log1p(variance * power)).sum())


def _likeliest(power: Array, seen: Array) -> float:
    """Return q̂ >= 0."""
    scale = 1.0 / max(power.max(initial=0.0), np.finfo(float).tiny)
    found = minimize_scalar(
        lambda exponent: -_log_likelihood(scale * np.exp(exponent), power, seen), bounds=(-12.0, 25.0), method="bounded"
    )
    variance = scale * float(np.exp(found.x))
    return variance if _log_likelihood(variance, power, seen) > 0.0 else 0.0
