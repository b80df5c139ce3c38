"""The figures of a campaign in the form of montecarlo.json."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from testbed.arrays import Array
from testbed.campaign.columns import FAILURE
from testbed.campaign.engine_check import EngineCheck
from testbed.campaign.statistics import CampaignStatistics, EstimatorStatistics

_SCHEMA = 1


def montecarlo_of(
    table: pa.Table, statistics: CampaignStatistics, *, name: str, seed: int, seconds: float, flight_s: float
) -> dict[str, Any]:
    """Return what montecarlo.json holds.

    Args:
        table: the runs.
        statistics: of them.
        name: of the scenario.
        seed: of the campaign.
        seconds: that flying and estimating took, s.
        flight_s: how long each flight lasts, s.
    """
    return {
        "schema": _SCHEMA,
        "scenario": name,
        "seed": seed,
        "runs": statistics.runs,
        "failed": statistics.failed,
        "estimates": {name: _estimator(figures) for name, figures in statistics.estimators.items()},
        "bound_std_kg_m2": _numbers(statistics.bound_std),
        "true_theta_kg_m2": _numbers(statistics.true_theta),
        "failures": failures_of(table),
        **({"unestimated": unestimated} if (unestimated := unestimated_of(table)) else {}),
        "seconds": seconds,
        "simulated_s": flight_s * (statistics.runs - statistics.failed),
    }


def checked(check: EngineCheck) -> dict[str, Any]:
    """Return what montecarlo.json holds of runs that both engines flew."""
    return {"runs": check.runs, "largest_difference_rad_s": check.largest_difference, "run": check.run}


def failures_of(table: pa.Table) -> list[dict[str, Any]]:
    """Return run, seed and message of every failed run."""
    failed = table.filter(pc.not_equal(table["outcome"], "completed"))
    rows: list[dict[str, Any]] = failed.select(["run", "seed", "message"]).to_pylist()
    return rows


def unestimated_of(table: pa.Table) -> list[dict[str, Any]]:
    """Return each estimator that gave no estimate of some flights, their number and the most frequent reason."""
    found = []
    for column in table.column_names:
        counted = Counter(table[column].drop_null().to_pylist() if column.endswith(FAILURE) else ())
        if counted:
            name = column.removesuffix(FAILURE)
            found.append({"estimator": name, "runs": counted.total(), "message": counted.most_common(1)[0][0]})
    return found


def _estimator(figures: EstimatorStatistics) -> dict[str, Any]:
    return {
        "runs": figures.runs,
        "mean_kg_m2": _numbers(figures.mean),
        "std_kg_m2": _numbers(figures.std),
        "claimed_std_kg_m2": _numbers(figures.claimed_std),
        "bias_in_standard_errors": _numbers(figures.bias_in_standard_errors),
        "coverage_95": _numbers(figures.coverage),
        "scatter_over_bound": _numbers(figures.scatter_over_bound),
        **({} if figures.offset is None else {"center_of_mass_offset": _offset(figures.offset)}),
    }


def _offset(figures: EstimatorStatistics) -> dict[str, Any]:
    return {
        "mean_m": _numbers(figures.mean),
        "std_m": _numbers(figures.std),
        "claimed_std_m": _numbers(figures.claimed_std),
        "bias_in_standard_errors": _numbers(figures.bias_in_standard_errors),
        "coverage_95": _numbers(figures.coverage),
        "scatter_over_bound": _numbers(figures.scatter_over_bound),
    }


def _numbers(values: Array) -> list[float | None]:
    """Numbers as JSON has them; null for one that is not finite."""
    return [float(value) if np.isfinite(value) else None for value in values]
