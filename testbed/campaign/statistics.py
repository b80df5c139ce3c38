"""What a campaign's runs say of each estimator: bias, scatter, coverage, beside the bound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from testbed.arrays import Array, Theta
from testbed.campaign.columns import offset_columns, parameter_columns

_FAILURE = "_failure"
NORMAL_95 = 1.96
"""Standard deviations on either side that hold 95 % of a normal distribution."""


@dataclass(frozen=True, kw_only=True)
class EstimatorStatistics:
    """One estimator over the completed runs; arrays have shape (6,), in the order of θ.

    Where the truth was dispersed, every run's error is against its own truth, and `mean` lies about the mean truth.

    Attributes:
        runs: in which it gave an estimate.
        mean: mean truth plus mean error, kg·m².
        std: of the errors, kg·m².
        mean_error: estimate minus truth, kg·m².
        bias_in_standard_errors: mean error over std / √runs.
        coverage: share of the 95 % intervals that hold the truth.
        claimed_std: mean of the standard deviations that it states, kg·m².
        scatter_over_bound: std over the bound's.
        offset: the same figures of the centre of mass on an air bearing, in shape (3,) and m; None without one.
    """

    runs: int
    mean: Theta
    std: Theta
    mean_error: Theta
    bias_in_standard_errors: Theta
    coverage: Theta
    claimed_std: Theta
    scatter_over_bound: Theta
    offset: EstimatorStatistics | None = None


@dataclass(frozen=True, kw_only=True)
class CampaignStatistics:
    """A campaign in figures.

    Attributes:
        runs: all, failed ones included.
        failed: runs that were not flown to their end.
        true_theta: mean truth of the completed runs, shape (6,), kg·m².
        bound_std: root mean square of the Cramér-Rao bound's standard deviations, shape (6,), kg·m².
        estimators: by name; one that never gave an estimate twice is absent.
    """

    runs: int
    failed: int
    true_theta: Theta
    bound_std: Theta
    estimators: Mapping[str, EstimatorStatistics]


def statistics_of(table: pa.Table) -> CampaignStatistics:
    """Return the figures of a campaign.

    Args:
        table: its runs, as `run_campaign` returns them; where none was completed, the figures are NaN.
    """
    flown = table.filter(pc.equal(table["outcome"], "completed"))
    true_theta, bound = parameters(flown, "true"), parameters(flown, "bound_std")
    bound_std = np.sqrt(_mean(bound[np.isfinite(bound).all(axis=1)] ** 2))
    each = {name: _estimator(flown, name, bound_std) for name in estimators_of(table)}
    return CampaignStatistics(
        runs=len(table),
        failed=len(table) - len(flown),
        true_theta=_mean(true_theta),
        bound_std=bound_std,
        estimators={name: statistics for name, statistics in each.items() if statistics is not None},
    )


def estimators_of(table: pa.Table) -> tuple[str, ...]:
    """Return the names of the estimators that a table of runs has columns for."""
    return tuple(column.removesuffix(_FAILURE) for column in table.column_names if column.endswith(_FAILURE))


def parameters(table: pa.Table, prefix: str) -> Array:
    """Return the six columns of a θ, shape (runs, 6), kg·m²; NaN where a run has none.

    Args:
        table: runs.
        prefix: as in `parameter_columns`.
    """
    return _columns(table, parameter_columns(prefix))


def _columns(table: pa.Table, names: Sequence[str]) -> Array:
    columns = [table[name].to_numpy(zero_copy_only=False) for name in names]
    return np.stack(columns, axis=1).astype(np.float64)


def errors_of(table: pa.Table, name: str) -> Array:
    """Return an estimator's errors in the runs in which it gave an estimate, shape (runs, 6), kg·m²."""
    errors = parameters(table, name) - parameters(table, "true")
    return errors[np.isfinite(errors).all(axis=1)]


def _estimator(flown: pa.Table, name: str, bound_std: Theta) -> EstimatorStatistics | None:
    truth, estimate, claimed = (parameters(flown, prefix) for prefix in ("true", name, f"{name}_std"))
    figures = _figures(truth, estimate, claimed, bound_std)
    if figures is None or offset_columns("true")[0] not in flown.column_names:
        return figures
    truth, estimate, claimed, bound = (
        _columns(flown, offset_columns(prefix)) for prefix in ("true", name, f"{name}_std", "bound_std")
    )
    offset_bound = np.sqrt(_mean(bound[np.isfinite(bound).all(axis=1)] ** 2))
    return replace(figures, offset=_figures(truth, estimate, claimed, offset_bound))


def _figures(truth: Array, estimate: Array, claimed: Array, bound_std: Array) -> EstimatorStatistics | None:
    given = np.isfinite(estimate).all(axis=1)
    runs = int(given.sum())
    if runs < 2:  # no scatter
        return None
    errors, claimed = estimate[given] - truth[given], claimed[given]
    mean_error, std = errors.mean(axis=0), errors.std(axis=0, ddof=1)
    return EstimatorStatistics(
        runs=runs,
        mean=_mean(truth) + mean_error,
        std=std,
        mean_error=mean_error,
        bias_in_standard_errors=mean_error / std * np.sqrt(runs),
        coverage=np.mean(np.abs(errors) <= NORMAL_95 * claimed, axis=0),
        claimed_std=claimed.mean(axis=0),
        scatter_over_bound=std / bound_std,
    )


def _mean(values: Array) -> Theta:
    return values.mean(axis=0) if len(values) else np.full(6, np.nan)
