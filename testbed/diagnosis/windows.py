"""Runs as a diagnosis compares them: averaged down to the rate that the motion needs, cut into windows.

A body whose torques are known in part runs away from any prediction, however good its model: after some seconds the
error is as large as the motion, and tells nothing. Over a short window it has not grown yet.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from math import sqrt
from typing import Any

import numpy as np

from testbed.arrays import Array, Series
from testbed.errors import InputError
from testbed.estimation.telemetry import Telemetry
from testbed.records.checks import MINIMUM_SAMPLES

_FULL = 0.5
"""Share of the usual number of samples that an average has to be of."""


def averaged(telemetry: Telemetry, rate: float) -> Telemetry:
    """Return telemetry whose samples are means over 1 / rate, and of the times over which they were taken.

    Args:
        telemetry: of one run.
        rate: Hz; samples that come more slowly are left as they are.
    """
    gyro_time, (body_rate,), gyro_count = _means(telemetry.gyro_time, [telemetry.body_rate], rate)
    channels = _actuator_channels(telemetry)
    actuator_time, means, _ = _means(telemetry.actuator_time, list(channels.values()), rate)
    changed: dict[str, Any] = dict(zip(channels, means, strict=True))
    return replace(
        telemetry,
        gyro_time=gyro_time,
        body_rate=body_rate,
        gyro_noise=telemetry.gyro_noise / sqrt(gyro_count),
        actuator_time=actuator_time,
        **changed,
    )


def windows_of(telemetry: Telemetry, horizon: float) -> Iterator[Telemetry]:
    """Yield windows that follow one another, each with what the actuators did a horizon before its first sample.

    Args:
        telemetry: of a run without gaps in its actuators' telemetry.
        horizon: length of a window, s.

    Raises:
        InputError: the run is shorter than two windows, or a window holds too few samples.
    """
    start, end = telemetry.gyro_time[[0, -1]]
    period = float(np.median(np.diff(telemetry.gyro_time)))
    count = int((end + period - start) / horizon)
    if count < 2 or horizon < MINIMUM_SAMPLES * period:
        raise InputError(
            f"{end - start:.3g} s at {1.0 / period:.3g} Hz cannot be cut into windows of {horizon} s of "
            f"{MINIMUM_SAMPLES} samples, the first for what came before: change diagnosis.horizon_s"
        )
    for first in start + horizon * np.arange(1, count):
        window = _between(telemetry, first, first + horizon)
        if len(window.gyro_time) >= MINIMUM_SAMPLES:  # fewer where the gyro has a gap
            yield window


def _between(telemetry: Telemetry, first: float, last: float) -> Telemetry:
    """Return the gyro samples between two times, and the actuators' from as long before to one sample after."""
    own = (telemetry.gyro_time >= first) & (telemetry.gyro_time < last)
    begin = max(int(np.searchsorted(telemetry.actuator_time, 2.0 * first - last)) - 1, 0)
    rows = slice(begin, int(np.searchsorted(telemetry.actuator_time, last)) + 1)
    return replace(
        with_actuator_rows(telemetry, rows),
        gyro_time=telemetry.gyro_time[own],
        body_rate=telemetry.body_rate[own],
    )


def with_actuator_rows(telemetry: Telemetry, rows: slice) -> Telemetry:
    """Return telemetry with some of its actuators' samples.

    Args:
        telemetry: of one run.
        rows: which samples.
    """
    cut: dict[str, Any] = {name: values[rows] for name, values in _actuator_channels(telemetry).items()}
    return replace(telemetry, actuator_time=telemetry.actuator_time[rows], **cut)


def _actuator_channels(telemetry: Telemetry) -> dict[str, Array]:
    """Return what was sampled at the actuators' times, by name."""
    of_gyro = {"gyro_time", "body_rate", "actuator_time"}
    values = {field.name: getattr(telemetry, field.name) for field in fields(telemetry) if field.name not in of_gyro}
    return {name: each for name, each in values.items() if isinstance(each, np.ndarray)}


def _means(time: Series, channels: list[Array], rate: float) -> tuple[Series, list[Array], float]:
    """Return times, channels and the usual number of samples in a mean."""
    number = np.floor((time - time[0]) * rate).astype(np.intp)
    first = np.flatnonzero(np.diff(number, prepend=-1))
    counts = np.diff(np.append(first, len(time)))
    usual = float(np.median(counts))
    full = counts >= _FULL * usual
    shares = 1.0 / counts[full]
    means = [np.add.reduceat(channel, first, axis=0)[full] * shares[:, None] for channel in channels]
    return np.add.reduceat(time, first)[full] * shares, means, usual
