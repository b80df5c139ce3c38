"""What held-out runs say of a fitted model: how well it predicts them, its parameters uncertain as the fit leaves them.

The held-out residual r of the fitted model is N(0, 1 + G P Gᵀ), with G = ∂prediction/∂(θ, effects) and P the fit's
covariance; initial rates are the run's own. The logarithm of that density rewards what carries over to other flights
and takes back what was fitted to chance, without fitting the held-out runs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs, joined
from testbed.diagnosis.model import Fit, evaluated, fitted_initial_rates, orthonormal, recurring

_UNKNOWN = 1e-9
"""Share of a parameter's own information below which the fit does not know it."""


def log_evidence(heldout: Runs | None, fit: Fit) -> float:
    """Return twice the logarithm of the density of held-out runs, up to what all models share; 0 without such runs.

    Args:
        heldout: runs that were not fitted.
        fit: to other runs.
    """
    if heldout is None:
        return 0.0
    fit, seen = recurring(fit), fitted_initial_rates(heldout, fit)
    common = 6 + len(fit.effect_values)
    free = np.ones(common, dtype=bool)
    free[6:] = ~fit.at_bound
    residual, columns = _without(seen.jacobian[:, common:], seen.residual, seen.jacobian[:, :common][:, free])
    _, fitted_columns = _without(fit.jacobian[:, common:], fit.residual, fit.jacobian[:, :common][:, free])
    scale = np.sqrt((columns**2).sum(axis=0) + (fitted_columns**2).sum(axis=0))
    scale = np.maximum(scale, np.finfo(float).tiny)
    columns, fitted_columns = columns / scale, fitted_columns / scale
    known = fitted_columns.T @ fitted_columns + _UNKNOWN * np.eye(free.sum())
    together = known + columns.T @ columns
    slope = columns.T @ residual
    explained = float(slope @ np.linalg.solve(together, slope))
    spread = float(np.linalg.slogdet(together)[1] - np.linalg.slogdet(known)[1])
    return explained - float(residual @ residual) - spread


def on_all_runs(runs: Runs, heldout: Runs | None, fit: Fit) -> tuple[Runs, Fit]:
    """Return all runs together, gyro only, and a fit evaluated on them: what no run is explained by is sought in all.

    Args:
        runs: that were fitted.
        heldout: that were not: of them, initial rates are fitted; None where there are none.
        fit: to the former.
    """
    rates = fit.values.initial_rate
    if heldout is not None:
        rates = np.concatenate([rates, fitted_initial_rates(heldout, fit).values.initial_rate])
    everything = joined(runs, heldout)
    return everything, evaluated(everything, fit.placed, replace(fit.values, initial_rate=rates))


def _without(own: Array, residual: Array, columns: Array) -> tuple[Array, Array]:
    """Return residual and columns with what initial rates can do projected out."""
    basis = orthonormal(own)
    return residual - basis @ (basis.T @ residual), columns - basis @ (basis.T @ columns)
