"""What the noise of the actuators' telemetry adds to the residual: a body rate is predicted from it, sample by sample.

Of J ω = L - h the whole momentum L is integrated and hardly feels single samples of h: an error δh of a sample stands
as J⁻¹ δh in the prediction of that sample.
"""

from __future__ import annotations

from math import comb

import numpy as np
from scipy.stats import chi2

from testbed.arrays import Array, Theta
from testbed.cmg.cluster import transverse_axes
from testbed.diagnosis.data import Runs
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.telemetry import Telemetry

_ORDER = 8
"""Of the differences: of a gimbal swinging by 0.3 rad at 1.5 Hz, they take 3e-5 rad for noise at 16 Hz."""
_WEIGHTS = np.array([(-1.0) ** index * comb(_ORDER, index) for index in range(_ORDER + 1)])
_MEDIAN = float(chi2.median(1))


def with_telemetry_noise(runs: Runs, theta: Theta) -> Runs:
    """Return runs whose standard deviation holds what the actuators' telemetry adds to the gyro's noise.

    Args:
        runs: with the gyro's own.
        theta: inertia parameters, shape (6,), kg·m².
    """
    inverse = np.linalg.inv(inertia_of(theta))
    added = [np.diag(inverse @ momentum_covariance(run) @ inverse.T) for run in runs.grid.runs]
    return runs.with_sigma(np.sqrt(runs.sigma**2 + np.array(added)))


def momentum_covariance(run: Telemetry) -> Array:
    """Return the covariance of a sample of the cluster's momentum by its telemetry's noise, (N·m·s)², shape (3, 3)."""
    if run.gimbal_angle is not None and run.cluster is not None:
        slopes = run.cluster.rotor_momentum[:, None] * transverse_axes(run.cluster, run.gimbal_angle)
        return np.asarray(np.einsum("kui,kuj,u->ij", slopes, slopes, _variance(run.gimbal_angle)) / len(slopes))
    if run.cluster_momentum is not None:
        return np.diag(_variance(run.cluster_momentum))
    return np.zeros((3, 3))


def _variance(channel: Array) -> Array:
    """Return the variance of the white noise of columns, told from their fastest changes; zero of too few samples."""
    if len(channel) <= _ORDER:
        return np.zeros(channel.shape[1])
    fast = np.lib.stride_tricks.sliding_window_view(channel, _ORDER + 1, axis=0) @ _WEIGHTS
    return np.asarray(np.median(fast**2, axis=0) / (_MEDIAN * float(_WEIGHTS @ _WEIGHTS)))
