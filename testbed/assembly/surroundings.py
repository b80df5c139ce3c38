"""What acts on a measured platform, along its attitude: recorded, or the gyro's integral from a known start."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Quaternion, Series
from testbed.assembly.platform import Body
from testbed.errors import InputError
from testbed.estimation.surroundings import Attitude, Surroundings, integrated, measured
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
    return Surroundings(
        environment=nominal.environment, inertia=nominal.inertia, attitude=attitude, measured=is_measured
    )


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
