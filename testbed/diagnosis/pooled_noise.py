"""The gyro's noise where no record states it: one for all runs, told by what all their samples say together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.noise import readings_of
from testbed.effects.fast_changes import variance_ratio


def pooled_noise(runs: Runs, theta: Theta) -> tuple[float, float] | None:
    """Return the noise that the samples of all runs tell together, rad/s, and its degrees of freedom.

    None where they are too few.

    Args:
        runs: all of them.
        theta: to start their fit from, shape (6,), kg·m².
    """
    # Runs whose noises were told one by one are weighted alike: the fit is not the one that those noises gave.
    runs = runs.with_sigma(np.sqrt(np.mean(runs.sigma**2, axis=0)))
    ratio, freedom = variance_ratio(readings_of(runs, fitted(runs, [], theta, [])), np.ones(3, dtype=bool))
    return (float(np.sqrt(ratio * np.mean(runs.sigma**2))), freedom) if freedom > 0.0 else None


def with_pooled_noise(runs: Runs, level: tuple[float, float]) -> Runs:
    """Return runs with the noise that the samples tell; that of the actuators' telemetry is in it.

    Args:
        runs: any of them.
        level: as `pooled_noise`.
    """
    noise, freedom = level
    return replace(runs.with_sigma(np.full(3, noise)), noise_freedom=freedom)
