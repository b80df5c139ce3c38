"""Lone wild samples of the gyro, left out before they pass for noise.

A transmission error or a spike of the sensor is one sample that stands away from both of its neighbours by far more
than the noise; what the platform does, or an effect of the library, lasts for longer than a sample or shows everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import median_abs_deviation

from testbed.arrays import Array, Flags
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise import readings_of
from testbed.estimation.telemetry import Telemetry

_WILD = 5.0
"""Times the usual distance of a sample from its neighbours; 1e-6 of normal samples are as far off."""
_MOST = 0.05
"""Share of wild samples, of all runs, beyond which they are what this gyro shows, and no accidents."""
_NEIGHBOURS = 2
"""On either side: the median of four follows a jump of the rate."""


def without_spikes(runs: Runs, fit: Fit) -> tuple[tuple[Telemetry, ...], tuple[int, ...]]:
    """Return the runs' telemetry less the gyro's wild samples, and how many those were, by run.

    Args:
        runs: measured.
        fit: of any model to them; what it leaves is looked at.
    """
    residuals = readings_of(runs, fit).residual
    wild = [_wild(residual, sigma) for residual, sigma in zip(residuals, runs.sigma, strict=True)]
    if np.concatenate(wild).mean() > _MOST:
        wild = [np.zeros_like(each) for each in wild]
    cleaned = tuple(_less(run, gone) for run, gone in zip(runs.grid.runs, wild, strict=True))
    return cleaned, tuple(int(gone.sum()) for gone in wild)


def _less(run: Telemetry, gone: Flags) -> Telemetry:
    return replace(run, gyro_time=run.gyro_time[~gone], body_rate=run.body_rate[~gone])


def _wild(residual: Array, sigma: Array) -> Flags:
    """Return which samples of a run are wild on any axis, shape (N,)."""
    apart = residual - _median_of_neighbours(residual)
    usual = np.maximum(sigma, median_abs_deviation(apart, axis=0, scale="normal"))
    return np.asarray((np.abs(apart) > _WILD * usual).any(axis=1))


def _median_of_neighbours(values: Sequence[Array] | Array) -> Array:
    """Return the median of the samples around each, its own left out, shape (N, 3)."""
    padded = np.pad(values, ((_NEIGHBOURS, _NEIGHBOURS), (0, 0)), mode="reflect")
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1, axis=0)
    return np.asarray(np.median(np.delete(around, _NEIGHBOURS, axis=-1), axis=-1))
