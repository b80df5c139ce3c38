"""The gyro's own noise, told from the residual's fastest changes, which no motion of the platform makes."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Flags
from testbed.effects.contract import Readings

_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
"""Fourth differences: a motion of 1 Hz at 16 Hz passes by a factor 0.02, white noise by √70."""


def variance_ratio(readings: Readings, axes: Flags) -> tuple[float, float]:
    """Return the variance of the noise over the believed one, and its degrees of freedom; (1, 0) of too few samples.

    Args:
        readings: against a model.
        axes: which count, shape (3,).
    """
    fast = [
        np.convolve(residual[:, axis] / sigma[axis], _DIFFERENCES, mode="valid")
        for residual, sigma in zip(readings.residual, readings.sigma, strict=True)
        if len(residual) >= len(_DIFFERENCES)
        for axis in np.flatnonzero(axes)
    ]
    number = sum(len(each) for each in fast)
    if not number:
        return 1.0, 0.0
    power = sum(float(each @ each) for each in fast) / float(_DIFFERENCES @ _DIFFERENCES)
    return power / number, number / _correlated_share()


def _correlated_share() -> float:
    """Return how many correlated differences are worth one independent number: Σ ρ² over all lags."""
    correlation = np.convolve(_DIFFERENCES, _DIFFERENCES[::-1])
    return float((correlation**2).sum() / correlation.max() ** 2)
