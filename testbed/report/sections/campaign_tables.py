"""The figures of a campaign as tables: means and scatter, then bias, efficiency, coverage of each estimator."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from testbed.campaign.statistics import CampaignStatistics, EstimatorStatistics
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import inertia_unit
from testbed.report.frame.blocks import Cell, Column, Table
from testbed.report.wording import capitalized, decimals_for, estimator_name

_NOTABLE_BIAS = 3.0
"""Standard errors."""
_CHANCE = 3.0
"""Standard deviations of a share that is counted in so many runs."""


def estimators_table(statistics: CampaignStatistics) -> Table:
    """Return truth, means and scatter of all estimators, and the bound."""
    every = statistics.estimators.values()
    unit = inertia_unit(statistics.true_theta)
    decimals = decimals_for(np.concatenate([each.std / np.sqrt(each.runs) for each in every]), unit)  # of the means
    rows = [(Cell(text="True, mean"), *(Cell(text=unit.shown(value, decimals)) for value in statistics.true_theta))]
    for name, figures in statistics.estimators.items():
        pairs = zip(figures.mean, figures.std, strict=True)
        values = (Cell(text=f"{unit.shown(mean, decimals)} ± {unit.shown(std, decimals)}") for mean, std in pairs)
        rows.append((Cell(text=f"{capitalized(estimator_name(name))}, ± scatter"), *values))
    bound = (Cell(text=unit.shown(value, decimals)) for value in statistics.bound_std)
    rows.append((Cell(text="Cramér-Rao bound, std"), *bound))
    note = (
        "Scatter is the standard deviation of estimate minus truth over the completed runs. Where the truth was "
        "dispersed, each run is held against its own, and means lie about the mean truth. The bound is the root mean "
        "square of the runs' own."
    )
    return Table(columns=_columns("Inertia", unit.text), rows=tuple(rows), note=note)


def statistics_tables(statistics: CampaignStatistics) -> tuple[Table, ...]:
    """Return the tables of bias, efficiency, stated over actual scatter, and coverage."""
    chance = f"{_standard_error_of_scatter(statistics):.1%}"
    return (
        _table(
            statistics,
            "Bias, std errors",
            _bias,
            f"Mean error over its standard error; marked beyond {_NOTABLE_BIAS:.0f}, which chance exceeds once in 370.",
        ),
        _table(
            statistics,
            "Scatter over bound",
            _efficiency,
            "1 is the best that an unbiased estimator can reach; less is the scatter of a biased one, or chance, which "
            f"makes up {chance} (one standard error) in so many runs.",
        ),
        _table(
            statistics,
            "Claimed over scatter",
            _honesty,
            "The standard deviation that the estimator states, on average, over its scatter: less than 1 is too sure.",
        ),
        _table(
            statistics,
            "In 95 % interval, %",
            _coverage,
            "Share of the runs whose 95 % interval holds the truth; marked where chance does not explain it.",
        ),
    )


def _bias(of: EstimatorStatistics) -> Iterator[Cell]:
    for value in of.bias_in_standard_errors:
        yield Cell(text=f"{value:+.1f}", tone="warn" if abs(value) > _NOTABLE_BIAS else "plain")


def _efficiency(of: EstimatorStatistics) -> Iterator[Cell]:
    return (Cell(text=f"{value:.3f}") for value in of.scatter_over_bound)


def _honesty(of: EstimatorStatistics) -> Iterator[Cell]:
    return (Cell(text=f"{value:.3f}") for value in of.claimed_std / of.std)


def _coverage(of: EstimatorStatistics) -> Iterator[Cell]:
    chance = _CHANCE * float(np.sqrt(0.95 * 0.05 / of.runs))
    for share in of.coverage:
        yield Cell(text=f"{100.0 * share:.1f}", tone="warn" if abs(share - 0.95) > chance else "plain")


def _standard_error_of_scatter(statistics: CampaignStatistics) -> float:
    """Of a standard deviation, as a share of it."""
    runs = min(of.runs for of in statistics.estimators.values())
    return float(1.0 / np.sqrt(2.0 * (runs - 1)))


def _table(
    statistics: CampaignStatistics, title: str, cells: Callable[[EstimatorStatistics], Iterator[Cell]], note: str
) -> Table:
    rows = tuple(
        (Cell(text=capitalized(estimator_name(name))), *cells(of)) for name, of in statistics.estimators.items()
    )
    return Table(columns=_columns(title), rows=rows, note=note, wide=False)


def _columns(title: str, unit: str = "") -> tuple[Column, ...]:
    return (Column(title=title), *(Column(title=name, unit=unit) for name in PARAMETER_NAMES))
