"""The boxes of figure 3: quartiles, whiskers and outliers of an estimator's errors."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.cbook import boxplot_stats

from testbed.arrays import Array, Series


@dataclass(frozen=True, kw_only=True)
class Box:
    """One box; all in the unit of what it was made of.

    Attributes:
        median: of the values.
        lower_quartile: a quarter lies below.
        upper_quartile: a quarter lies above.
        lowest: smallest value within 1.5 times the box's height below it.
        highest: largest value within 1.5 times the box's height above it.
        outliers: values beyond, shape (K,).
    """

    median: float
    lower_quartile: float
    upper_quartile: float
    lowest: float
    highest: float
    outliers: Series


def boxes_of(errors: Array) -> tuple[Box, ...]:
    """Return a box for each column, as Matlab's `boxplot` draws them.

    Args:
        errors: shape (runs, 6).
    """
    return tuple(
        Box(
            median=float(one["med"]),
            lower_quartile=float(one["q1"]),
            upper_quartile=float(one["q3"]),
            lowest=float(one["whislo"]),
            highest=float(one["whishi"]),
            outliers=one["fliers"],
        )
        for one in boxplot_stats(errors)
    )
