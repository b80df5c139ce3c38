"""Which samples of the gimbals' channels are compared with what is predicted."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from testbed.arrays import Flags
from testbed.estimation.gaps import covered_by, gaps
from testbed.estimation.telemetry import Telemetry

SETTLING = 0.2
"""s. How long a servo needs to take up its work: what the motors do until then is not compared. Its poles are at 25
1/s, so that e^-5, 0.7 % of how it began, remains. With 0.1 and 0.4 s, answers
are the same and estimates move by 0.1 and 0.3 standard errors (three sets of seed 90817)."""
_MISSING = 1.5
"""Of the usual interval: halfway between one and two, so that jitter makes no gap and a single lost sample does. It may
be interpolated over, but the second derivative of an angle across it is not a gimbal's acceleration."""
_BRIDGED = 0.08
"""s. What is sent is known between samples that are no farther apart than those of 16 Hz."""
_REMEMBERED = 64
"""Runs whose compared samples are kept: more than a diagnosis has. Every prediction asks for them."""


@lru_cache(maxsize=_REMEMBERED)
def compared(run: Telemetry) -> Flags:
    """Return which actuator samples are compared, shape (K,).

    They lie within the gyro's, after the servos have taken up their work, and not beside a gap, over which the gimbals'
    acceleration is not known; nor in a gap of the gyro, over which the body's is not.
    """
    gap = np.concatenate([[False], incomplete(run), [False]])
    inside = (run.actuator_time >= run.gyro_time[0] + SETTLING) & covered_by(run.actuator_time, run.gyro_time)
    return np.asarray(inside & ~gap[1:] & ~gap[:-1])


def torques_compared(run: Telemetry) -> Flags:
    """Return at which of them the torques of the gimbals' motors are: those at which they were sampled, shape (K,)."""
    torque = None if run.gimbals is None else run.gimbals.torque
    return compared(run) if torque is None else compared(run) & np.isfinite(torque).all(axis=1)


def incomplete(run: Telemetry) -> Flags:
    """Return between which actuator samples one or more are missing, shape (K - 1,)."""
    return gaps(run.actuator_time, _MISSING)


def long_gaps(run: Telemetry) -> Flags:
    """Return between which actuator samples the commands are not known, shape (K' - 1,)."""
    return gaps(run.actuator_time, _MISSING, shortest=_BRIDGED)
