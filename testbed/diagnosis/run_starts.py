"""What actuators did before the first gyro sample that is compared, of runs that begin in the middle of a motion.

Behind a release a torque builds up from nothing. A log that was switched on later begins with a torque that nobody
recorded, and a late gyro still shows it: of jets that switch five times a second, it was named a touch and noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbed.estimation.telemetry import Telemetry

_MOVING = 5.0
"""Times the gyro's noise of a first sample from which on a run has been turning: by chance in two of a million."""
_HISTORY = 0.25
"""s. What a lag of 50 ms leaves of a torque is then less than a hundredth.

Source: chosen: jets and motors have 20 to 90 ms, and of the slowest a sixteenth is left."""
_SHARE = 0.1
"""Share of the shortest run that it is at most.

Source: chosen: it costs an inertia a twentieth of its standard deviation."""


def with_history(runs: Sequence[Telemetry]) -> list[Telemetry]:
    """Return runs of applied torques, the first moment of which tells what acted before, if any of them begins moving.

    All of them then, as what actuators did before is known of all runs or of none. Runs in gravity or in orbit stay:
    their first attitude is that of the record's begin.

    Args:
        runs: as they were sent.
    """
    driven = all(run.applied_torque is not None and run.surroundings is None for run in runs)
    if not driven or not any(_begins_moving(run) for run in runs):
        return list(runs)
    history = min(_HISTORY, _SHARE * min(float(np.ptp(run.gyro_time)) for run in runs))
    return [_compared_after(run, history) for run in runs]


def _compared_after(run: Telemetry, history: float) -> Telemetry:
    begin = float(run.gyro_time[0])
    return replace(run.with_gyro_rows(run.gyro_time >= begin + history), followed_from=begin)


def _begins_moving(run: Telemetry) -> bool:
    return bool(np.abs(run.body_rate[0]).max() > _MOVING * run.gyro_noise)
