"""What the model knows of the gyro's errors, told to the runs: their gimbals' channels are predicted with its rate."""

from __future__ import annotations

from dataclasses import replace

from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.prediction.prediction import without_gyro_errors


def corrected(runs: Runs, fit: Fit) -> Runs:
    """Return runs whose gyro's errors are those of a model; the same object where nothing changes.

    Args:
        runs: fitted or held out.
        fit: of the model to them, or of their initial rates alone.
    """
    grid = without_gyro_errors(runs.grid, [placed.hooks for placed in fit.placed], fit.values)
    return runs if grid is runs.grid else replace(runs, grid=grid)
