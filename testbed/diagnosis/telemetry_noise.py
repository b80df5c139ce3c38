"""What the noise of the actuators' telemetry adds to the residual of runs."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.data import Runs
from testbed.estimation.telemetry_noise import predicted_rate_variance


def with_telemetry_noise(runs: Runs, theta: Theta) -> Runs:
    """Return runs whose standard deviation holds what the actuators' telemetry adds to the gyro's noise.

    Args:
        runs: with the gyro's own.
        theta: inertia parameters, shape (6,), kg·m².
    """
    added = [predicted_rate_variance(run, theta) for run in runs.grid.runs]
    return runs.with_sigma(np.sqrt(runs.sigma**2 + np.array(added)))
