"""Lone wild samples of the gyro, left out before they pass for noise.

A transmission error or a spike of the sensor is one sample that stands away from both of its neighbours by far more
than the noise; what the platform does, or an effect of the library, lasts for longer than a sample or shows everywhere.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Flags
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise import readings_of
from testbed.effects.gyro_saturation import flat_tops
from testbed.estimation.outliers import outliers
from testbed.estimation.telemetry import Telemetry

_MOST = 0.05
"""Share of wild samples, of all runs, beyond which they are what this gyro shows, and no accidents."""


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
        np.any(outliers(residual, sigma) & ~at_limit, axis=1)
        for residual, sigma, at_limit in zip(residuals, runs.sigma, clipped, strict=True)
    ]
    if np.concatenate(wild).mean() > _MOST:
        wild = [np.zeros_like(each) for each in wild]
    cleaned = tuple(_less(run, gone) for run, gone in zip(runs.grid.runs, wild, strict=True))
    return cleaned, tuple(int(gone.sum()) for gone in wild)


def _less(run: Telemetry, gone: Flags) -> Telemetry:
    return replace(run, gyro_time=run.gyro_time[~gone], body_rate=run.body_rate[~gone])
