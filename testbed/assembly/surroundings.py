"""What acts on a measured platform, along its attitude: recorded, or the gyro's integral from a known start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Self

import numpy as np

from testbed.arrays import Array, Flags, Quaternion, Quaternions, Series, Vectors3
from testbed.assembly.platform import Body
from testbed.dynamics.environment import Pivoted
from testbed.errors import InputError
from testbed.estimation.differences import median_variance
from testbed.estimation.gaps import GYRO_BRIDGED, between_gaps, gaps
from testbed.estimation.surroundings import (
    EXACT,
    Attitude,
    Fused,
    Surroundings,
    fused,
    integrated,
    known_right,
    measured,
    sensor_noise,
)
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
    gyro = _Gyro.of(record)
    sent = None if "attitude" not in record.channels else _known(gyro, *sampled(record, "attitude"))
    attitude, is_measured = _attitude(record, scenario, gyro, sent)
    around = Surroundings(
        environment=nominal.environment,
        inertia=nominal.inertia,
        attitude=attitude,
        measured=is_measured,
        left_out=0 if sent is None else sent.left_out,
    )
    if sent is None or not isinstance(nominal.environment, Pivoted):
        return around
    return _by_gyro(around, gyro, sent)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Gyro:
    """The gyro's samples: times, shape (N,), s, and rates, shape (N, 3), rad/s."""

    time: Series
    body_rate: Vectors3

    @classmethod
    def of(cls, record: Record) -> Self:
        time, body_rate = sampled(record, "body_rate")
        return cls(time=time, body_rate=body_rate)

    @property
    def unbroken(self) -> list[_Gyro]:
        """Its stretches between gaps, over which its integral can be compared with a sensor of the attitude."""
        rows = between_gaps(gaps(self.time, shortest=GYRO_BRIDGED))
        return [_Gyro(time=self.time[each], body_rate=self.body_rate[each]) for each in rows]

    @property
    def walk(self) -> float:
        """What its noise makes of its integral in a second, rad."""
        step = float(np.median(np.diff(self.time)))
        return float(np.sqrt(step * median_variance(self.body_rate, _FAST).mean()))

    def walk_between(self, sent: _Sent) -> float:
        """Return what its noise makes of its integral from one sample of a sensor to the next, rad."""
        return max(self.walk * sqrt(sent.interval), EXACT)


_FAST = 4
"""Of the differences that show the gyro's noise: a body turns more smoothly."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sent:
    """Samples of a sensor of the attitude: times, shape (K,), s, quat_NB, shape (K, 4), and how many were left out."""

    time: Series
    quat_NB: Quaternions
    left_out: int = 0

    def within(self, gyro: _Gyro) -> Flags:
        """Return which of them lie between the gyro's samples, shape (K,)."""
        return np.asarray((self.time >= gyro.time[0]) & (self.time <= gyro.time[-1]))

    def chosen(self, kept: Flags) -> _Sent:
        return replace(self, time=self.time[kept], quat_NB=self.quat_NB[kept])

    @property
    def interval(self) -> float:
        return float(np.median(np.diff(self.time)))


_NOTICED = 3.0
"""Times what the gyro's noise makes of the attitude from one sample of a sensor to the next, from which on the sensor's
own noise shows.

Source: convention: three standard errors."""
_LATE = 5.0
"""Standard errors from which on a lag of the sensor counts. Source: as for a wheel's command phase."""
_SHORTEST_LAG = 5e-4
"""Below it a lag does no harm, s. Source: docs/misspecified.md, jitter of 0.5 ms."""


def _by_gyro(around: Surroundings, gyro: _Gyro, sent: _Sent) -> Surroundings:
    """Return the surroundings of a platform on a pivot without a sensor's noise and lag, if it has any.

    Where the sensor does not tell the attitude at all times, all its samples tell where the gyro's integral starts.
    Gravity on the offset turns a table by it: 5e-4 rad at 10 Hz of a table of 15 kg, off by 0.6 mm, put the inertia off
    by two standard deviations, and healthy tables in doubt.
    """
    stretches = [(part, sent.chosen(sent.within(part))) for part in gyro.unbroken]
    if any(len(inside.time) < _FEWEST for _, inside in stretches):
        return around
    walk, noise = gyro.walk, max(*(_noise_of(part, inside) for part, inside in stretches), EXACT)
    found = [
        fused(part.time, part.body_rate, inside.time, inside.quat_NB, noise=noise, walk=walk)
        for part, inside in stretches
    ]
    weights = np.array([each.lag_std**-2 for each in found])
    lag = float(weights @ [each.lag for each in found] / weights.sum())
    is_late = abs(lag) > max(_LATE / sqrt(weights.sum()), _SHORTEST_LAG)
    is_noisy = noise > _NOTICED * gyro.walk_between(sent)
    if around.measured and not is_noisy and not is_late:
        return around
    return replace(
        around,
        attitude=_joined(stretches, found),
        start_std=max(each.start_std for each in found),
        lag=lag if is_late else 0.0,
    )


def _noise_of(gyro: _Gyro, sent: _Sent) -> float:
    integral = integrated(gyro.time, gyro.body_rate, sent.quat_NB[0], float(sent.time[0]))
    return sensor_noise(integral, sent.time, sent.quat_NB)


def _joined(stretches: Sequence[tuple[_Gyro, _Sent]], found: Sequence[Fused]) -> Attitude:
    """Return the attitude of all stretches, through their values where the gyro has gaps."""
    if len(found) == 1:
        return found[0].attitude
    times = [part.time for part, _ in stretches]
    quats = [each.attitude.quat(time) for each, time in zip(found, times, strict=True)]
    return measured(np.concatenate(times), np.concatenate(quats))


def _attitude(record: Record, scenario: BodyScenario, gyro: _Gyro, sent: _Sent | None) -> tuple[Attitude, bool]:
    """Return the attitude as it is known, and whether a sensor tells it at all times."""
    if sent is None or not len(sent.time):
        return integrated(gyro.time, gyro.body_rate, _start(record, scenario)), False
    if len(sent.time) >= _FEWEST and sent.time[0] <= gyro.time[0] and sent.time[-1] >= gyro.time[-1]:
        return measured(sent.time, sent.quat_NB), True
    return integrated(gyro.time, gyro.body_rate, sent.quat_NB[0], float(sent.time[0])), False


def _known(gyro: _Gyro, time: Series, quat_NB: Array) -> _Sent:
    """Return the samples that are attitudes, filters send zeros before they converge, without single wrong ones."""
    lengths = np.linalg.norm(quat_NB, axis=1) > _SHORTEST
    sent = _Sent(time=time[lengths], quat_NB=quat_NB[lengths])
    right = np.ones(len(sent.time), dtype=bool)
    for part in gyro.unbroken:
        within = sent.within(part)
        if np.count_nonzero(within) >= _FEWEST:
            inside = sent.chosen(within)
            right[within] = known_right(
                part.time, part.body_rate, inside.time, inside.quat_NB, gyro.walk_between(inside)
            )
    return replace(sent.chosen(right), left_out=int(np.count_nonzero(~right)))


def _start(record: Record, scenario: BodyScenario) -> Quaternion:
    if not isinstance(scenario, Scenario):
        raise InputError(
            f"{record.details.name}: gravity, or the orbit, acts by the platform's attitude, and nothing says how it "
            "stood: give the columns attitude_w to attitude_z, in the first row at least"
        )
    return np.array(scenario.initial.attitude_quat_NB)
