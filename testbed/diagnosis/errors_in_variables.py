"""Errors in variables: what a model explains only by taking the telemetry's noise out of its own prediction.

Noise of encoders and tachometers stands in the predicted body rate. A model in which the body, or the gyro, follows its
actuators' fast motion less takes some of it away, and suits the samples better, whether there is anything of the kind
or not: healthy satellites had a slow gyro, a loose mass and a flexible appendage, with P = 1. How much a model takes
away is found with more noise of the same size: by how much less of it stands in its prediction. It counts however much
a model explains: a slow gyro took 7 more than a late one, which was there, of 14,000 that both explain.

Source: Fuller, "Measurement error models" (1987), section 1.1.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit, orthonormal, projected_out
from testbed.estimation.telemetry_noise import is_as_sent, predicted_rate_variance, with_more_noise
from testbed.prediction.grid import Grid, grid_of
from testbed.prediction.integration import GRIDS
from testbed.prediction.prediction import predicted

_SEED = 20261127
"""Of the noise that is added; one draw tells the power of hundreds of samples to a tenth."""
_NOTICED = 20.0
"""χ² that the telemetry's noise adds to the gyro's samples, from which on models are asked what they take.

Source: as for modes beside tachometers (`testbed.diagnosis.tachometers`): a fifth of it is less than names need."""


def taken_out(runs: Runs, without: Fit, model: Fit) -> float:
    """Return by how much a model reduces χ² by the telemetry's noise alone, expected where its effect is absent.

    Args:
        runs: that both were fitted to.
        without: the model without the effect.
        model: with it.
    """
    if _added(runs, without.theta) < _NOTICED or not without.deviance > model.deviance:
        return 0.0
    return max(power_of_noise(runs, without) - power_of_noise(runs, model), 0.0)


def _added(runs: Runs, theta: Theta) -> float:
    """Return what noise of telemetry that is as it was sent adds to χ² of the gyro's samples."""
    pairs = zip(runs.grid.runs, runs.sigma, strict=True)
    return sum(
        len(run.gyro_time) * float((predicted_rate_variance(run, theta) / sigma**2).sum())
        for run, sigma in pairs
        if is_as_sent(run)
    )


@lru_cache(maxsize=4)
def power_of_noise(runs: Runs, fit: Fit) -> float:
    """Return the sum of squares of what more noise of the telemetry, as much as it has, adds to the residual, in σ."""
    found = predicted(_noisier(runs.grid), [each.hooks for each in fit.placed], fit.values)
    measured = [(rates - one[0])[..., None] for rates, one in zip(runs.measured, found, strict=True)]
    noisier = np.concatenate(runs.whitened_columns(measured))[:, 0]
    change = noisier - fit.residual[: runs.samples]
    return float(np.square(projected_out(change, orthonormal(fit.jacobian[: runs.samples]))).sum())


@lru_cache(maxsize=GRIDS)
def _noisier(grid: Grid) -> Grid:
    rng = np.random.default_rng(_SEED)
    return grid_of([with_more_noise(run, rng) if is_as_sent(run) else run for run in grid.runs])
