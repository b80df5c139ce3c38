"""Which limit each CMG unit is at, as lanes of states over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rerun as rr

from testbed.arrays import Array, Series
from testbed.recording.palette import FREE_COLOR, SATURATED_COLORS
from testbed.recording.stream import send

ROOT = "saturation"
FREE = "free"
STATES: Mapping[str, str] = {
    "gimbal_rate_saturated": "gimbal rate",
    "gimbal_torque_saturated": "gimbal torque",
    "rotor_momentum_clamped": "rotor momentum",
}
"""What a lane says while a flag is up; the last named wins where several are."""


def log_saturation(stream: rr.RecordingStream, time: Series, channels: Mapping[str, Array]) -> None:
    """Write one lane per unit, a row wherever its state changes.

    Args:
        stream: the recording.
        time: shape (N,), s.
        channels: of the flight, flags of shape (N, M); without them there are no lanes.
    """
    flags = {state: channels[name] > 0.5 for name, state in STATES.items() if name in channels}
    if not flags:
        return
    states = np.full(next(iter(flags.values())).shape, FREE, dtype=object)
    for state, raised in flags.items():
        states[raised] = state
    for unit, lane in enumerate(states.T, start=1):
        _log_lane(stream, f"{ROOT}/cmg{unit}", time, lane)


def _log_lane(stream: rr.RecordingStream, path: str, time: Series, states: Array) -> None:
    values = [FREE, *STATES.values()]
    stream.log(path, rr.StateConfiguration(values=values, colors=[FREE_COLOR, *SATURATED_COLORS]), static=True)
    changed = np.append(True, states[1:] != states[:-1])
    kept = list(states[changed])
    send(stream, path, time[changed], lambda rows: rr.StateChange.columns(state=kept[rows]))
