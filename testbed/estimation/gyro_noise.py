"""The gyro's white noise from its samples alone, for records that do not state it."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Series, Vectors3
from testbed.estimation.differences import divided_differences, median_std
from testbed.estimation.gaps import stretches

ORDER = 4
"""Of the differences: they take any cubic out of the motion; of 1 rad/s at 2 rad/s, 3e-5 are left at 16 Hz."""
FEWEST_WINDOWS = 20
"""With fewer, the noise is not known to a quarter."""
_EFFICIENCY = 0.19
"""Degrees of freedom of the noise's variance per number that the gyro gave: a median tells as much as 37 % of them, and
differences of five samples overlap. Measured on 3,000 series of white noise of 64 to 1,000 samples (a test says so)."""
ROUNDING = 1e-12
"""Share of the largest rate below which differences are rounding."""


def gyro_noise_of(time: Series, body_rate: Vectors3) -> float | None:
    """Return the standard deviation of the white noise per sample, rad/s, root mean square over the axes.

    Fourth-order divided differences, scaled to the noise's variance, within stretches without gaps; the median of their
    size bears a tenth of outliers. Either the samples are uneven, or their time stamps alone: the part of the motion
    in the differences only adds to the noise, so that the smaller of both estimates is the better one. Noise that the
    gyro itself has smoothed is not white, and is underestimated.

    Args:
        time: shape (N,), s, strictly increasing.
        body_rate: measured ω, shape (N, 3), rad/s.

    Returns:
        None where the record is too short, or its samples repeat, so that they hide the noise.
    """
    runs = [run for run in stretches(time) if run.stop - run.start > ORDER]
    if sum(run.stop - run.start - ORDER for run in runs) < FEWEST_WINDOWS:
        return None
    even = np.arange(float(len(time)))
    noise = min(_noise(clock, body_rate, runs) for clock in (time, even))
    return noise if noise > ROUNDING * np.abs(body_rate).max() else None


def noise_freedom(time: Series) -> float:
    """Return the degrees of freedom of the variance that `gyro_noise_of` returns, by its precision.

    Args:
        time: of the samples, shape (N,), s.
    """
    return _EFFICIENCY * 3.0 * len(time)


def _noise(time: Series, body_rate: Vectors3, runs: list[slice]) -> float:
    differences = np.concatenate([divided_differences(time[run], body_rate[run], ORDER) for run in runs])
    return float(np.sqrt(np.mean(median_std(differences) ** 2)))
