"""The gyro's own noise, told from the residual's fastest changes, which no motion of the platform makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from testbed.arrays import Array, Vector3
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit

_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
"""Fourth differences: a motion of 1 Hz at 16 Hz passes by a factor 0.02, white noise by √70."""


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
    power, freedom = np.zeros(3), 0.0
    offset = 0
    for rates in runs.measured:
        residual = fit.residual[offset : offset + rates.size].reshape(-1, 3)
        offset += rates.size
        fast = _differences(residual)
        power += (fast**2).sum(axis=0) / (_DIFFERENCES @ _DIFFERENCES)
        freedom += len(fast) / _correlated_share()
    ratio = np.sqrt(power / (freedom * _correlated_share()))
    statistic = freedom * ratio**2
    tails = np.array([2.0 * min(chi2.cdf(value, freedom), chi2.sf(value, freedom)) for value in statistic])
    return NoiseLevel(ratio=ratio, std=ratio / np.sqrt(2.0 * freedom), p_value=float(min(1.0, 3.0 * tails.min())))


def _differences(residual: Array) -> Array:
    return np.stack([np.convolve(axis, _DIFFERENCES, mode="valid") for axis in residual.T], axis=1)


def _correlated_share() -> float:
    """Return how many correlated differences are worth one independent number: Σ ρ² over all lags."""
    correlation = np.convolve(_DIFFERENCES, _DIFFERENCES[::-1])
    return float((correlation**2).sum() / correlation.max() ** 2)
