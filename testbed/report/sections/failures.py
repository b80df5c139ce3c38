"""Estimators that gave no estimate, and why."""

from __future__ import annotations

from collections.abc import Mapping

from testbed.report.frame.blocks import Cell, Column, Table
from testbed.report.wording import capitalized, estimator_name


def failures_table(failures: Mapping[str, str]) -> Table:
    """Return the table of failed estimators.

    Args:
        failures: estimator to message.
    """
    rows = tuple(
        (Cell(text=capitalized(estimator_name(name))), Cell(text=message)) for name, message in failures.items()
    )
    return Table(columns=(Column(title="No estimate from"), Column(title="because")), rows=rows, numeric=False)
