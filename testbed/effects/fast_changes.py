"""The gyro's own noise, estimated from the residual's fastest changes, which no motion of the platform makes.

Where the residual holds nothing else, all of it estimates the noise, twice as precisely.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.arrays import Array, Flags
from testbed.effects.noise_effect import Readings
from testbed.estimation.differences import correlated_share, squared_differences

ORDER = 4
"""Of the differences: a motion of 1 Hz at 16 Hz passes by a factor 0.02, white noise by √70."""
_AGREEING = 2.0
"""Standard deviations by which two estimates of one thing may differ: 95 %. On failure the less precise one counts, so
that a false alarm costs half of the degrees of freedom and no more.

Source: Hausman, "Specification tests in econometrics", Econometrica (1978).
"""
FEWEST = ORDER + 1
"""Samples in a row without which there is no fourth difference."""


def variance_ratio(readings: Readings, axes: Flags) -> tuple[float, float]:
    """Return the variance of the noise over the stated one, and its degrees of freedom; (1, 0) of too few samples.

    Args:
        readings: against a model.
        axes: which count, shape (3,).
    """
    powers = [fast_power(values) for values in _whitened(readings, axes) if len(values) >= FEWEST]
    number = sum(power.size for power in powers)
    if not number:
        return 1.0, 0.0
    return sum(float(power.sum()) for power in powers) / number, number / correlated_share(ORDER)


def noise_ratio(readings: Readings, axes: Flags) -> tuple[float, float]:
    """Return the variance of the noise over the stated one, and its degrees of freedom.

    From all of a residual that is white, unless its fastest changes differ by more than chance (Hausman's test: of two
    estimates the surer one counts, if they differ by no more than its being surer explains); else from these alone.

    Args:
        readings: against a model.
        axes: which count, shape (3,).
    """
    fast, fast_freedom = variance_ratio(readings, axes)
    squares = [values**2 for values in _whitened(readings, axes)]
    turning = np.any(readings.live, axis=0)
    freedom = float(sum(each.size for each in squares) - readings.parameters * np.mean(axes[turning]))
    if not readings.white or not 0.0 < fast_freedom < freedom:
        return fast, fast_freedom
    whole = sum(float(each.sum()) for each in squares) / freedom
    doubt = whole * np.sqrt(2.0 / fast_freedom - 2.0 / freedom)
    return (whole, freedom) if abs(whole - fast) < _AGREEING * doubt else (fast, fast_freedom)


def _whitened(readings: Readings, axes: Flags) -> Iterator[Array]:
    """Yield each run's whitened residual about some axes, those of them about which the run turns."""
    live = np.broadcast_to(readings.live, readings.sigma.shape)
    for whitened, own in zip(readings.whitened_residual, live, strict=True):
        if (axes & own).any():
            yield whitened[:, axes & own]


def fast_power(values: Array) -> Array:
    """Return the squared fourth differences of columns, scaled to have the variance of white noise as their mean.

    Args:
        values: shape (N, W), N at least `FEWEST`.
    """
    return squared_differences(values, ORDER)
