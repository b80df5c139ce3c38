"""Flights side by side: the telemetry of several as one, with the flights on a leading axis.

Flights that were sampled at the same times on platforms that are believed to be the same go through an estimator
together, which takes a sixth of the time that they take one by one. What a flight answers depends on no other.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TypeVar

import numpy as np

from testbed.arrays import Array
from testbed.errors import InputError
from testbed.estimation.motion import LONGEST_STEP
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry, WheelTelemetry

MOST_INSTANTS = 20_000
"""Of all flights that stand side by side, samples or steps of the integration: an instant takes some 10 kB on the way.
Of flights of 5 s more than 100 at once are no quicker."""

_Answer = TypeVar("_Answer")


def answers_side_by_side(
    flights: Sequence[Telemetry],
    together: Callable[[Telemetry, Sequence[int]], Sequence[_Answer]],
    alone: Callable[[int], _Answer],
) -> list[_Answer]:
    """Return an answer for each flight, of those that are alike found together.

    Where those together are refused, each half of them is tried, down to single flights, which say for themselves why.

    Args:
        flights: any.
        together: from flights side by side and their indices to their answers; InputError or LinAlgError where any of
            them has none.
        alone: from the index of one of the flights to its answer.
    """

    def found(which: Sequence[int]) -> list[_Answer]:
        if len(which) == 1:
            return [alone(which[0])]
        try:
            return list(together(side_by_side(tuple(flights[index] for index in which)), which))
        except (InputError, np.linalg.LinAlgError):
            middle = len(which) // 2
            return found(which[:middle]) + found(which[middle:])

    answers = {index: answer for which in _alike(flights) for index, answer in zip(which, found(which), strict=True)}
    return [answers[index] for index in range(len(flights))]


def _alike(flights: Sequence[Telemetry]) -> Iterator[list[int]]:
    """Yield the indices of flights that can be put side by side, no more of them than fit into the memory."""
    groups: dict[Hashable, list[int]] = {}
    for index, flight in enumerate(flights):
        groups.setdefault(_likeness(flight), []).append(index)
    for which in groups.values():
        time = flights[which[0]].gyro_time
        instants = max(len(time), int(np.ptp(time) / LONGEST_STEP), 1)
        most = max(MOST_INSTANTS // instants, 1)
        yield from (which[first : first + most] for first in range(0, len(which), most))


@lru_cache(maxsize=2)  # several estimators ask for the same in turn
def side_by_side(flights: tuple[Telemetry, ...]) -> Telemetry:
    """Return flights that are alike as one, its channels of shape (F, N, ...); commands and thrusts are left out."""
    first = flights[0]
    return replace(
        first,
        body_rate=np.stack([flight.body_rate for flight in flights]),
        gimbals=_gimbals([flight.gimbals for flight in flights if flight.gimbals is not None]),
        wheels=_wheels([flight.wheels for flight in flights if flight.wheels is not None]),
        cluster_momentum=_stacked([flight.cluster_momentum for flight in flights]),
        applied_torque=_stacked([flight.applied_torque for flight in flights]),
        thrust=None,
        thrusters=None,
    )


def _likeness(flight: Telemetry) -> Hashable:
    """Return what flights have in common that can be put side by side; those in surroundings stay alone."""
    if flight.surroundings is not None or flight.gyro_error is not None:
        return id(flight)
    gimbals, wheels = flight.gimbals, flight.wheels
    return (
        flight.gyro_time.tobytes(),
        flight.actuator_time.tobytes(),
        flight.gyro_noise,
        flight.initial_momentum,
        flight.constant_torque,
        flight.slow_bias,
        flight.noise_freedom,
        flight.live,
        gimbals and (id(gimbals.cluster), gimbals.rotor_momentum is None),
        wheels and id(wheels.wheels),
        flight.cluster_momentum is None,
        flight.applied_torque is None,
        flight.torque_held,
        None if flight.held_inertia is None else flight.held_inertia.tobytes(),
    )


def _gimbals(sent: Sequence[GimbalTelemetry]) -> GimbalTelemetry | None:
    if not sent:
        return None
    return GimbalTelemetry(
        cluster=sent[0].cluster,
        angle=np.stack([each.angle for each in sent]),
        rotor_momentum=_stacked([each.rotor_momentum for each in sent]),
    )


def _wheels(sent: Sequence[WheelTelemetry]) -> WheelTelemetry | None:
    return WheelTelemetry(wheels=sent[0].wheels, momentum=np.stack([each.momentum for each in sent])) if sent else None


def _stacked(channels: Sequence[Array | None]) -> Array | None:
    """Return a channel that all flights have, or none."""
    sent = [channel for channel in channels if channel is not None]
    return np.stack(sent) if sent else None
