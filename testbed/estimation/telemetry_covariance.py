"""What the noise of the actuators' telemetry does to an estimate that integrates the motion.

Of J ω = L - h single samples of h hardly move the total angular momentum L, but all of them together walk: an error
of the rate turns L away, by the more, the larger L is. Wheels that are biased, or a release with spin, so make a slow
error of the prediction, beside which the gyro's noise is small, and a whiteness test sees nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Array
from testbed.estimation.estimate import Estimate
from testbed.estimation.motion import drive_of, simulate, with_torque
from testbed.estimation.telemetry import Telemetry
from testbed.estimation.telemetry_noise import with_more_noise

_DRAWS = 24
"""Of noise; a standard deviation is then known to 14 %."""
_SEED = 20261127
"""Of these draws."""
_NOTICED = 0.02
"""Share of the gyro's part of a variance, below which the telemetry's is left out: 1 % of a standard deviation."""


def with_telemetry_noise(estimate: Estimate, part: Telemetry) -> Estimate:
    """Return an estimate by output error with what the telemetry's noise makes in its covariance, if that is noticed.

    Args:
        estimate: with the influence of the gyro's samples.
        part: of the run that it was estimated from.
    """
    assert estimate.influence is not None
    rng = np.random.default_rng(_SEED)
    theta = estimate.theta

    def rates(run: Telemetry) -> Array:
        drive = with_torque(drive_of(run), estimate.acting)
        return np.asarray(simulate(drive, theta, estimate.initial_momentum_B).body_rate.ravel())

    as_sent = rates(part)
    errors = np.stack([rates(with_more_noise(part, rng)) - as_sent for _ in range(_DRAWS)])
    moved = estimate.influence @ errors.T
    added = moved @ moved.T / _DRAWS
    known = np.diag(estimate.joint_covariance)
    if np.all(np.diag(added) < _NOTICED * known):
        return estimate
    return replace(
        estimate,
        covariance=estimate.covariance + added[:6, :6],
        offset_covariance=estimate.offset_covariance + added[6:, 6:],
        offset_cross_covariance=estimate.offset_cross_covariance + added[:6, 6:],
        by_telemetry=added,
    )
