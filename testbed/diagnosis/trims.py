"""Whether the actuators of a platform have one trim in all records, or another in each.

A trim is the constant torque by which applied torques are off. In a short record of a slow motion a drag is hardly more
than a constant torque: with a trim of its own for every record, a drag of eight detectable sizes is explained away. So
the records have one trim in common, unless trims of their own are more probable than any effect.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import helmert

from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import refit
from testbed.diagnosis.model import Fit, orthonormal, projected_out
from testbed.diagnosis.settings import SETTINGS

_TOGETHER = "all records"


def may_share_a_trim(runs: Runs) -> bool:
    """Return whether one trim of all records is to be tried.

    Not of windows of torque that is known in part, nor beside healthy records: what is known of each trim counts.
    """
    free = runs.belief is None or not np.isfinite(runs.belief.trim_std).all()
    return runs.trimmed and not runs.known_in_part and free and len(runs.record_names) > 1


def with_one_trim(runs: Runs) -> Runs:
    """Return runs whose records have one trim."""
    return replace(runs, trim_group=(_TOGETHER,) * len(runs.names))


def with_own_trims(runs: Runs, model: Fit) -> tuple[Runs, Fit]:
    """Return runs with a trim of every record, and a model of them fitted again; the same where they have."""
    if not runs.trim_group:
        return runs, model
    own = replace(runs, trim_group=())
    return own, refit(own, model)


def log_odds_of_own_trims(runs: Runs, model: Fit) -> float:
    """Return twice the logarithm of the posterior odds of a trim of every record against one of all; even a priori.

    The trims' deviations from their mean have a normal prior. Of deviations that are estimated as δ with information I,
    2 ln B = δᵀ I (I + T⁻²)⁻¹ I δ - ln det(1 + T² I) (Savage-Dickey).

    Args:
        runs: whose records have one trim.
        model: of them.

    Source: Dickey, "The weighted likelihood ratio, linear hypotheses on normal location parameters", Annals of
    Mathematical Statistics (1971).
    """
    own, fit = with_own_trims(runs, model)
    torque = np.concatenate([run.applied_torque for run in own.grid.runs if run.applied_torque is not None])
    scatter = SETTINGS.trim_scatter * float(np.sqrt(np.mean(torque**2)))
    own_trims = fit.jacobian[:, -fit.trims.size :]
    count = len(fit.trims)
    apart = np.kron(helmert(count).T, np.eye(3))  # the mean of all records is free
    mean = own_trims @ np.kron(np.ones((count, 1)), np.eye(3))
    nuisance = orthonormal(np.hstack([fit.jacobian[:, : -fit.trims.size], mean]))
    columns = projected_out(own_trims @ apart, nuisance)
    information = columns.T @ columns
    slope = information @ (apart.T @ fit.trims.ravel())
    gain = slope @ np.linalg.solve(information + np.eye(len(slope)) / scatter**2, slope)
    return float(gain - np.linalg.slogdet(np.eye(len(slope)) + scatter**2 * information)[1])
