"""Is the residual of an estimate noise: as large as it is stated, and white?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from testbed.arrays import Array, Indices, Vector3, Vectors3

LAGS = 8
"""Of the test of whiteness: half a second at 16 Hz, in which a maneuver's motion is still alike."""
MOST_LOOKED_AT = 20_000
"""Samples that are tested; of a longer record, blocks that are spread over it. A lack of 1 % in size shows in them."""
_BLOCK = 1_000
"""Samples in such a block, so that those of neighbouring lags are together."""


@dataclass(frozen=True, kw_only=True)
class ResidualCheck:
    """The residual of an estimate on a record.

    Attributes:
        size: root mean square in standard deviations of the stated noise; 1 where the model is right.
        size_p_value: of a residual as large, if the model and the noise are as stated.
        whiteness_p_value: of autocorrelations as large, if the noise is white; NaN where samples are too few.
        noise_is_stated: whether the noise is stated; otherwise it is that of the samples' differences.
    """

    size: float
    size_p_value: float
    whiteness_p_value: float
    noise_is_stated: bool


def checked_rows(samples: int) -> Indices:
    """Return which of a record's samples are tested, shape (N',)."""
    if samples <= MOST_LOOKED_AT:
        return np.arange(samples)
    starts = np.linspace(0, samples - _BLOCK, MOST_LOOKED_AT // _BLOCK).astype(np.intp)
    return np.asarray((starts[:, None] + np.arange(_BLOCK)).ravel())


def residual_check(
    residual: Vectors3,
    sigma: Vector3,
    considered: Array,
    parameters: int,
    noise_freedom: float,
    common: Vector3 | None = None,
) -> ResidualCheck:
    """Test a residual against noise and what is uncertain of actuators and gyro.

    With errors E δp of quantities δp of unit variance, the residual's covariance is σ² I + E Eᵀ; its quadratic form is
    a χ². The most likely δp is taken off before the autocorrelation is looked at (Ljung and Box, all axes together).

    Args:
        residual: measured - predicted, shape (N, 3), rad/s.
        sigma: of the noise on each axis, shape (3,), rad/s.
        considered: E, what of the considered quantities the estimate does not take up, shape (3N, K), rad/s.
        parameters: that were estimated.
        noise_freedom: degrees of freedom with which σ is known; infinite where it is stated.
        common: correlation of neighbouring samples that noise of the actuators' telemetry makes, shape (3,); none of
            the gyro's, it is taken off before.

    Source: G. M. Ljung, G. E. P. Box, On a measure of lack of fit in time series models, Biometrika 65, 1978.
    """
    white = (residual / sigma).ravel()
    errors = considered / np.tile(sigma, len(residual))[:, None]
    number = errors.shape[1]  # errors far above the noise make a normal matrix singular: least squares are not
    believed = np.vstack([errors, np.eye(number)])
    explained = np.linalg.lstsq(believed, np.concatenate([white, np.zeros(number)]))[0]
    rest = white - errors @ explained
    freedom, square = white.size - parameters, float(white @ rest)
    return ResidualCheck(
        size=float(np.sqrt(square / freedom)),
        size_p_value=_exceeded(square, freedom, noise_freedom),
        whiteness_p_value=_whiteness(_without_common(rest.reshape(-1, 3), common)),
        noise_is_stated=not np.isfinite(noise_freedom),
    )


def _without_common(rest: Vectors3, common: Vector3 | None) -> Vectors3:
    return rest if common is None or not common.any() else rest[1:] - common * rest[:-1]


def _exceeded(square: float, freedom: int, noise_freedom: float) -> float:
    if np.isfinite(noise_freedom):
        return float(scipy.stats.f.sf(square / freedom, freedom, noise_freedom))
    return float(scipy.stats.chi2.sf(square, freedom))


def _whiteness(residual: Vectors3) -> float:
    samples = len(residual)
    if samples < 4 * LAGS:  # the statistic is no χ² of so short a series
        return float("nan")
    centred = residual - residual.mean(axis=0)
    power = (centred**2).sum(axis=0)
    statistic = 0.0
    for lag in range(1, LAGS + 1):
        correlation = (centred[lag:] * centred[:-lag]).sum(axis=0) / power
        statistic += samples * (samples + 2) * float((correlation**2).sum()) / (samples - lag)
    return float(scipy.stats.chi2.sf(statistic, 3 * LAGS))
