"""Motions as telemetry shows them, without noise too fast for a gimbal or a body: they can be differentiated."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_lsq_spline

from testbed.arrays import Array, Series
from testbed.estimation.telemetry import GimbalRun, Telemetry

KNOTS_PER_SECOND = 16.0
"""Enough for 8 Hz; an encoder's noise of 1e-3 rad at 100 Hz leaves 0.5 rad/s² in the second derivative."""
_REMEMBERED = 64
"""Runs whose splines are kept, as many as in `motor_torques`; a miss costs time only."""
_REVERSAL = 0.02
"""rad/s, in which a direction changes: above the noise of a rate that is estimated from an encoder, 0.012 rad/s of
1e-3 rad at 100 Hz, 0.002 of 1e-4 rad."""
_DEGREE = 3
"""Of the splines: cubic, the least whose second derivative, a gimbal's acceleration, has no jumps. With the fifth,
estimates move by 0.2 standard errors and no answer changes (three sets of seed 90817)."""


@lru_cache(maxsize=_REMEMBERED)
def gimbal_motion(run: GimbalRun) -> BSpline:
    """Return the gimbal angles of a run, (M,), rad."""
    return _smoothed(run.actuator_time, np.unwrap(run.gimbals.angle, axis=0))


@lru_cache(maxsize=_REMEMBERED)
def body_motion(run: Telemetry) -> BSpline:
    """Return the body rate of a run, (3,), rad/s, body axes, without what is known to be the gyro's error."""
    body_rate = run.body_rate if run.gyro_error is None else run.body_rate - run.gyro_error
    return _smoothed(run.gyro_time, body_rate)


def taken_off(run: Telemetry, time: Series) -> Array:
    """Return what `body_motion` is less by because of what the gyro's readings are off by, shape (T, 3), rad/s."""
    if run.reading_error is None:
        return np.zeros((len(time), 3))
    return np.asarray(CubicSpline(run.gyro_time, run.reading_error)(time))


def direction_of(rate: Array) -> Array:
    """Return the direction of measured rates, rad/s, from -1 to 1; between where noise decides."""
    return np.asarray(np.tanh(rate / _REVERSAL))


def _smoothed(time: Series, values: Array) -> BSpline:
    """Return a cubic spline: through the samples, or between them where they come faster than its knots."""
    every = max(1, round(1.0 / (KNOTS_PER_SECOND * float(np.median(np.diff(time))))))
    inner = time[2:-2:every]
    knots = np.concatenate([[time[0]] * (_DEGREE + 1), inner, [time[-1]] * (_DEGREE + 1)])
    return make_lsq_spline(time, values, knots, k=_DEGREE)
