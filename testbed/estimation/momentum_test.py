"""Did the platform start without momentum, as was assumed? A score test on the residual of the estimate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from testbed.arrays import Array, Theta
from testbed.estimation.bound import rate_columns
from testbed.estimation.motion import drive_of, simulate, with_torque
from testbed.estimation.stated_noise import whitened
from testbed.estimation.telemetry import Telemetry


def zero_momentum_p_value(telemetry: Telemetry, theta: Theta, acting: Array | None = None) -> float:
    """Return the p-value of the hypothesis that the initial momentum is zero, by a score test.

    The residual is that of the motion without momentum; what of the momentum's sensitivities the inertia takes up is
    projected out. Of a χ² of three degrees of freedom.

    Args:
        telemetry: the covered part of one run.
        theta: estimated with zero initial momentum, kg·m².
        acting: what was estimated along, as `Telemetry.torque_of`; nothing where None.
    """
    drive = drive_of(telemetry) if acting is None else with_torque(drive_of(telemetry), acting)
    motion = simulate(drive, theta, np.zeros(3))
    columns = whitened(telemetry, rate_columns(replace(telemetry, initial_momentum="estimated"), drive, motion))
    inertia, _ = np.linalg.qr(np.delete(columns, slice(6, 9), axis=1))
    own, _ = np.linalg.qr(columns[:, 6:9] - inertia @ (inertia.T @ columns[:, 6:9]))
    apart = (telemetry.body_rate - motion.body_rate).reshape(-1, 1)
    residual = whitened(telemetry, apart).ravel() / telemetry.gyro_noise
    residual -= inertia @ (inertia.T @ residual)  # of an estimate that is not quite the most likely one
    return float(scipy.stats.chi2.sf(float(np.sum((own.T @ residual) ** 2)), 3))
