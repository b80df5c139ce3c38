"""How unevenly the rows of a log are stamped."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from testbed.estimation.telemetry import Telemetry
from testbed.prediction.compared import incomplete


def stamp_jitter(runs: Sequence[Telemetry]) -> float:
    """Return the standard deviation of the actuators' stamps about a clock that is even, s."""
    intervals = [np.diff(run.actuator_time)[~incomplete(run)] for run in runs]
    return float(np.concatenate([each - np.median(each) for each in intervals]).std()) / sqrt(2.0)
