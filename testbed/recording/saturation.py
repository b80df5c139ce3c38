"""Which limit each actuator is at, as lanes of states over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rerun as rr

from testbed.arrays import Array, Flags, Series
from testbed.recording.palette import FREE_COLOR, SATURATED_COLORS
from testbed.recording.stream import send
from testbed.signals import FLAGS, KINDS

ROOT = "saturation"
FREE = "free"
STATES: Mapping[str, str] = {flag.name: flag.reached for flag in FLAGS}
"""What a lane says while a flag is up; the last named wins where several are."""


def log_saturation(stream: rr.RecordingStream, time: Series, channels: Mapping[str, Array]) -> None:
    """Write one lane per actuator, a row wherever its state changes.

    Args:
        stream: the recording.
        time: shape (N,), s.
        channels: of the flight, flags of shape (N, M) or (N, W); without them there are no lanes.
    """
    for name, kind in KINDS.items():
        flags = {
            flag.reached: channels[flag.name] > 0.5 for flag in FLAGS if flag.name in channels and flag.per == name
        }
        if flags:
            _log_lanes(stream, time, flags, f"{ROOT}/{kind.prefix}")


def _log_lanes(stream: rr.RecordingStream, time: Series, flags: Mapping[str, Flags], name: str) -> None:
    states = np.full(next(iter(flags.values())).shape, FREE, dtype=object)
    for state, raised in flags.items():
        states[raised] = state
    for unit, lane in enumerate(states.T, start=1):
        _log_lane(stream, f"{name}{unit}", time, lane)


def _log_lane(stream: rr.RecordingStream, path: str, time: Series, states: Array) -> None:
    values = [FREE, *STATES.values()]
    stream.log(path, rr.StateConfiguration(values=values, colors=[FREE_COLOR, *SATURATED_COLORS]), static=True)
    changed = np.append(True, states[1:] != states[:-1])
    kept = list(states[changed])
    send(stream, path, time[changed], lambda rows: rr.StateChange.columns(state=kept[rows]))
