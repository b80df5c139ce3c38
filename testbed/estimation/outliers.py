"""Single samples that stand apart from their neighbours by far more than the noise: transmission errors, spikes.

What the platform does, or an effect of the library, lasts for longer than a sample or shows everywhere.
"""

from __future__ import annotations

import numpy as np
import scipy

from testbed.arrays import Array, Flags

OUTLYING = 4.5
"""Times the noise by which a sample lies beyond those before and those after it; of normal samples, 1.9e-5 do.

∫ 2 φ(x) Φ(√2 (x - 4.5))² dx, as each side's mean has half the variance.
"""
BY_CHANCE = 6e-5
"""Share of samples with three axes that lie so by their noise alone."""
_SIDE = 2
"""Samples on either side that it is compared with: the edge of a jump agrees with one side."""
AT_ENDS = _SIDE
"""Samples at either end of a run that have fewer neighbours there."""
_OF_DIFFERENCES = float(np.sqrt(1.0 + 1.0 / _SIDE))
"""Standard deviation of a sample less the mean of its neighbours on one side, in that of the noise."""
FEWEST = 2 * _SIDE + 1
"""Samples that have neighbours to be compared with."""


_GROSS = 50.0
"""Times the noise beyond which a sample spoils any fit, so that it has to go before one is made: 1.2 rad/s at the
paper's noise. A body rate of 0.3 rad/s at 2 Hz, sampled at 16 Hz, stands off the cubic by 0.017 rad/s."""
_CUBIC = np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0
"""Weights of the cubic through two samples on either side, at the one between them."""
_OF_CUBIC = float(np.sqrt(1.0 + np.sum(_CUBIC**2)))
_BEFORE = np.array([1.0, -3.0, 3.0])
"""Weights of the parabola through the three samples before, at the next; after it, the same in reverse."""


def gross_outliers(values: Array, sigma: float) -> Flags:
    """Return which samples stand so far off their neighbours that no motion explains it, shape (N, C); needs no fit.

    Off those before as off those after: at the corner where a torque jumps, a sample goes on from one side. The corners
    of a slew stand off the cubic by 100 times the noise of a fibre-optic gyro.

    Args:
        values: samples of a smooth motion with noise, shape (N, C).
        sigma: of the noise.
    """
    found = np.zeros(values.shape, dtype=bool)
    if len(values) < FEWEST:
        return found
    apart = np.abs(values - _windows(values, _SIDE) @ _CUBIC)
    usual = np.maximum(sigma * _OF_CUBIC, scipy.stats.median_abs_deviation(apart, axis=0, scale="normal", center=_zero))
    # The neighbours of a spike stand off by two thirds of it, and stay.
    farthest = scipy.ndimage.maximum_filter1d(apart, FEWEST, axis=0) == apart
    found = farthest & (apart > _GROSS * usual)
    return np.asarray(found & (_off_both_sides(values) > _GROSS * usual))


def _off_both_sides(values: Array) -> Array:
    """Return by how much each sample misses the parabola of either side, the less of both, shape (N, C)."""
    reach = len(_BEFORE)
    windows = _windows(values, reach)
    before, after = values - windows[..., :reach] @ _BEFORE, values - windows[..., -reach:] @ _BEFORE[::-1]
    return np.where(before * after > 0.0, np.minimum(np.abs(before), np.abs(after)), 0.0)


def _zero(values: Array, axis: int) -> Array:
    return np.zeros(np.delete(values.shape, axis))


def outliers(values: Array, sigma: Array | float) -> Flags:
    """Return which values stand apart on both sides, shape (N, C).

    Args:
        values: a residual, or any signal that changes little from sample to sample, shape (N, C).
        sigma: of the noise in each column, shape (C,) or a number; where the values scatter more, that counts.
    """
    if len(values) < FEWEST:
        return np.zeros(values.shape, dtype=bool)
    before = values - _neighbours(values, slice(0, _SIDE))
    after = values - _neighbours(values, slice(-_SIDE, None))
    usual = np.maximum(sigma, scipy.stats.median_abs_deviation(before, axis=0, scale="normal") / _OF_DIFFERENCES)
    return np.asarray((before * after > 0.0) & (np.minimum(np.abs(before), np.abs(after)) > OUTLYING * usual))


def _neighbours(values: Array, side: slice) -> Array:
    """Return the mean of the samples before or after each, shape (N, C)."""
    return np.asarray(_windows(values, _SIDE)[..., side].mean(axis=-1))


def _windows(values: Array, reach: int) -> Array:
    """Return each sample among so many on either side, shape (N, C, 2 reach + 1); beyond an end they are mirrored."""
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="reflect")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=0)
