"""Lone wild samples of the gyro, left out before they pass for noise.

A transmission error or a spike of the sensor is one sample that stands away from both of its neighbours by far more
than the noise; what the platform does, or an effect of the library, lasts for longer than a sample or shows everywhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import median_abs_deviation

from testbed.arrays import Array, Flags
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise import readings_of
from testbed.effects.gyro_saturation import flat_tops
from testbed.estimation.telemetry import Telemetry

_WILD = 4.5
"""Times the noise by which a sample lies beyond those before and those after it; of normal samples, 1e-6 do."""
_MOST = 0.05
"""Share of wild samples, of all runs, beyond which they are what this gyro shows, and no accidents."""
_SIDE = 2
"""Samples on either side that it is compared with: the edge of a jump agrees with one side."""
_OF_DIFFERENCES = float(np.sqrt(1.0 + 1.0 / _SIDE))
"""Standard deviation of a sample less the mean of its neighbours on one side, in that of the noise."""


def without_spikes(runs: Runs, fit: Fit) -> tuple[tuple[Telemetry, ...], tuple[int, ...]]:
    """Return the runs' telemetry less the gyro's wild samples, and how many those were, by run.

    A clipped peak of few samples looks wild to a model without the limit, and stays.

    Args:
        runs: measured.
        fit: of any model to them; what it leaves is looked at.
    """
    residuals = readings_of(runs, fit).residual
    clipped = flat_tops(runs.grid.runs)
    wild = [
        np.any(_wild(residual, sigma) & ~at_limit, axis=1)
        for residual, sigma, at_limit in zip(residuals, runs.sigma, clipped, strict=True)
    ]
    if np.concatenate(wild).mean() > _MOST:
        wild = [np.zeros_like(each) for each in wild]
    cleaned = tuple(_less(run, gone) for run, gone in zip(runs.grid.runs, wild, strict=True))
    return cleaned, tuple(int(gone.sum()) for gone in wild)


def _less(run: Telemetry, gone: Flags) -> Telemetry:
    return replace(run, gyro_time=run.gyro_time[~gone], body_rate=run.body_rate[~gone])


def _wild(residual: Array, sigma: Array) -> Flags:
    """Return which readings of a run are wild, shape (N, 3)."""
    before, after = (
        residual - _neighbours(residual, slice(0, _SIDE)),
        residual - _neighbours(residual, slice(-_SIDE, None)),
    )
    usual = np.maximum(sigma, median_abs_deviation(before, axis=0, scale="normal") / _OF_DIFFERENCES)
    return np.asarray((before * after > 0.0) & (np.minimum(np.abs(before), np.abs(after)) > _WILD * usual))


def _neighbours(values: Array, side: slice) -> Array:
    """Return the mean of the samples before or after each, shape (N, 3); beyond an end they are mirrored."""
    padded = np.pad(values, ((_SIDE, _SIDE), (0, 0)), mode="reflect")
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * _SIDE + 1, axis=0)[..., side].mean(axis=-1))
