"""Which samples of the gimbals' channels are compared with what is predicted."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Flags
from testbed.estimation.telemetry import Telemetry, covered_by

SETTLING = 0.2
"""s. How long a servo needs to take up its work: what the motors do until then is not compared. Its poles are at 25
1/s, so that e^-5, 0.7 % of how it began, remains. With 0.1 and 0.4 s, answers
are the same and estimates move by 0.1 and 0.3 standard errors (three sets of seed 90817)."""
_MISSING = 1.5
"""Of the usual interval: longer ones are gaps; halfway between one and two intervals, so that jitter of less than half
an interval makes no gap and every lost sample does."""
_BRIDGED = 0.08
"""s. What is sent is known between samples that are no farther apart than those of 16 Hz."""


def compared(run: Telemetry) -> Flags:
    """Return which actuator samples are compared, shape (K,).

    They lie within the gyro's, after the servos have taken up their work, and not beside a gap, over which the gimbals'
    acceleration is not known; nor in a gap of the gyro, over which the body's is not.
    """
    inside = (run.actuator_time >= run.gyro_time[0] + SETTLING) & covered_by(run.actuator_time, run.gyro_time)
    gap = np.concatenate([[False], gaps(run), [False]])
    return np.asarray(inside & ~gap[1:] & ~gap[:-1])


def gaps(run: Telemetry) -> Flags:
    """Return between which actuator samples others are missing, shape (K' - 1,)."""
    interval = np.diff(run.actuator_time)
    return np.asarray(interval > _MISSING * np.median(interval))


def holes(run: Telemetry) -> Flags:
    """Return between which actuator samples nobody knows what was asked for, shape (K' - 1,): gaps that are long."""
    return np.asarray(gaps(run) & (np.diff(run.actuator_time) > _BRIDGED))
