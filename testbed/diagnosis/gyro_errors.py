"""What the model knows of the gyro's errors, told to the runs: their gimbals' channels are predicted with its rate."""

from __future__ import annotations

from dataclasses import replace

from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted_initial_rates
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


def all_corrected(runs: Runs, heldout: Runs | None, fit: Fit) -> tuple[Runs, Runs | None]:
    """Return fitted and held-out runs whose gyro's errors are those of a model; the same objects where nothing changes.

    Args:
        runs: fitted.
        heldout: not fitted; None where there are none.
        fit: of the model to the former.
    """
    told = corrected(runs, fit)
    if heldout is None or told is runs:
        return told, heldout
    return told, corrected(heldout, fitted_initial_rates(heldout, fit))
