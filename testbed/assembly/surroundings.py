"""What acts on a measured platform, along its attitude: recorded, or the gyro's integral from a known start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Array, Quaternion, Series
from testbed.assembly.platform import Body
from testbed.dynamics.environment import Pivoted
from testbed.errors import InputError
from testbed.estimation.differences import median_variance
from testbed.estimation.gaps import GYRO_BRIDGED, gaps
from testbed.estimation.surroundings import Attitude, Surroundings, fused, integrated, measured, sensor_noise
from testbed.records.record import Record
from testbed.records.selection import sampled
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario

_FEWEST = 4
"""Samples of the attitude from which a cubic spline goes through them; fewer say where the gyro's integral starts."""

_SHORTEST = 0.5
"""Length from which four numbers are an attitude: midway between that of a unit quaternion, and of the zeros that
filters send before they converge."""


def surroundings_of(record: Record, scenario: BodyScenario, nominal: Body) -> Surroundings | None:
    """Return the environment of a whole record, before its usable part is taken; None where nothing acts.

    Args:
        record: flown or measured; its attitude counts where it has one.
        scenario: how a flight starts, where the record does not say it.
        nominal: with the environment.

    Raises:
        InputError: nothing says how the platform stood.
    """
    if nominal.environment is None:
        return None
    attitude, is_measured = _attitude(record, scenario)
    around = Surroundings(
        environment=nominal.environment, inertia=nominal.inertia, attitude=attitude, measured=is_measured
    )
    return _less_noise(around, record) if is_measured and isinstance(nominal.environment, Pivoted) else around


_NOTICED = 3.0
"""Times what the gyro's noise makes of the attitude from one sample of a sensor to the next, from which on the sensor's
own noise shows.

Source: convention: three standard errors."""


def _less_noise(around: Surroundings, record: Record) -> Surroundings:
    """Return the surroundings of a platform on a pivot along an attitude without a sensor's noise, if that has any.

    Gravity on the offset turns a table by it: 5e-4 rad at 10 Hz of a table of 15 kg, off by 0.6 mm, put the inertia off
    by two standard deviations, and healthy tables in doubt.
    """
    rate_time, body_rate = sampled(record, "body_rate")
    sent, quat_NB = _known_attitude(*sampled(record, "attitude"))
    inside = (sent >= rate_time[0]) & (sent <= rate_time[-1])
    if np.count_nonzero(inside) < _FEWEST or gaps(rate_time, shortest=GYRO_BRIDGED).any():
        return around
    sent, quat_NB = sent[inside], quat_NB[inside]
    by_gyro = integrated(rate_time, body_rate, quat_NB[0], float(sent[0]))
    step, between = float(np.median(np.diff(rate_time))), float(np.median(np.diff(sent)))
    walk = float(np.sqrt(step * median_variance(body_rate, _FAST).mean()))
    noise = sensor_noise(by_gyro, sent, quat_NB)
    if noise < _NOTICED * walk * np.sqrt(between):
        return around
    attitude, start_std = fused(rate_time, body_rate, sent, quat_NB, noise=noise, walk=walk)
    return replace(around, attitude=attitude, start_std=start_std)


_FAST = 4
"""Of the differences that show the gyro's noise: a body turns more smoothly."""


def _attitude(record: Record, scenario: BodyScenario) -> tuple[Attitude, bool]:
    rate_time, body_rate = sampled(record, "body_rate")
    if "attitude" in record.channels:
        time, quat_NB = _known_attitude(*sampled(record, "attitude"))
        if len(time) >= _FEWEST and time[0] <= rate_time[0] and time[-1] >= rate_time[-1]:
            return measured(time, quat_NB), True
        if len(time):
            return integrated(rate_time, body_rate, quat_NB[0], float(time[0])), False
    return integrated(rate_time, body_rate, _start(record, scenario)), False


def _known_attitude(time: Series, quat_NB: Array) -> tuple[Series, Array]:
    """Return the samples that are attitudes: filters send zeros before they converge."""
    known = np.linalg.norm(quat_NB, axis=1) > _SHORTEST
    return time[known], quat_NB[known]


def _start(record: Record, scenario: BodyScenario) -> Quaternion:
    if not isinstance(scenario, Scenario):
        raise InputError(
            f"{record.details.name}: gravity, or the orbit, acts by the platform's attitude, and nothing says how it "
            "stood: give the columns attitude_w to attitude_z, in the first row at least"
        )
    return np.array(scenario.initial.attitude_quat_NB)
