"""The gyro's own noise, told from the residual's fastest changes, which no motion of the platform makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from testbed.arrays import Vector3
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.dynamics.inertia import inertia_of
from testbed.effects.fast_changes import variance_ratio
from testbed.effects.reading_effect import Readings


@dataclass(frozen=True, kw_only=True)
class NoiseLevel:
    """How the gyro's noise compares with what is stated.

    Attributes:
        ratio: measured over stated standard deviation, shape (3,), per axis.
        std: of the ratio, shape (3,).
        p_value: that the stated noise is right on all axes, two-sided.
    """

    ratio: Vector3
    std: Vector3
    p_value: float

    @property
    def understated(self) -> bool:
        """Whether there is more noise than stated, by more than chance."""
        return self.p_value < 0.01 and bool(np.mean(self.ratio) > 1.0)

    @property
    def overstated(self) -> bool:
        """Whether there is less."""
        return self.p_value < 0.01 and bool(np.mean(self.ratio) < 1.0)


def noise_level(runs: Runs, fit: Fit) -> NoiseLevel:
    """Compare the residual's fourth differences with those of white noise of the stated standard deviation."""
    readings = readings_of(runs, fit)
    told = [variance_ratio(readings, axis) for axis in np.eye(3, dtype=bool)]
    ratio, freedom = np.sqrt([variance for variance, _ in told]), told[0][1]
    statistic = freedom * ratio**2
    tails = np.array([2.0 * min(chi2.cdf(value, freedom), chi2.sf(value, freedom)) for value in statistic])
    return NoiseLevel(ratio=ratio, std=ratio / np.sqrt(2.0 * freedom), p_value=float(min(1.0, 3.0 * tails.min())))


def readings_of(runs: Runs, fit: Fit) -> Readings:
    """Return what the gyro gave against what a model predicts."""
    whitened = runs.by_run(fit.residual)
    return Readings(
        measured=[run.body_rate for run in runs.grid.runs],
        residual=[part * sigma for part, sigma in zip(whitened, runs.sigma, strict=True)],
        sigma=runs.sigma,
        runs=runs.grid.runs,
        inertia=inertia_of(fit.theta),
        parameters=fit.jacobian.shape[1],
    )
