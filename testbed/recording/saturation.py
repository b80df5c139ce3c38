"""Which limit each CMG unit and wheel is at, as lanes of states over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import rerun as rr

from testbed.arrays import Array, Flags, Series
from testbed.recording.palette import FREE_COLOR, SATURATED_COLORS
from testbed.recording.stream import send
from testbed.signals import SIGNALS

ROOT = "saturation"
FREE = "free"
STATES: Mapping[str, str] = {
    "gimbal_rate_saturated": "gimbal rate",
    "gimbal_torque_saturated": "gimbal torque",
    "rotor_momentum_clamped": "rotor momentum",
    "wheel_torque_saturated": "wheel torque",
    "wheel_momentum_clamped": "wheel momentum",
}
"""What a lane says while a flag is up; the last named wins where several are."""
_LANES = {"unit": "cmg", "wheel": "wheel"}
"""Names of lanes, by what a flag has an entry for each of."""


def log_saturation(stream: rr.RecordingStream, time: Series, channels: Mapping[str, Array]) -> None:
    """Write one lane per unit, a row wherever its state changes.

    Args:
        stream: the recording.
        time: shape (N,), s.
        channels: of the flight, flags of shape (N, M) and (N, W); without them there are no lanes.
    """
    for kind, lane in _LANES.items():
        flags = {
            state: channels[name] > 0.5
            for name, state in STATES.items()
            if name in channels and SIGNALS[name].per == kind
        }
        if flags:
            _log_lanes(stream, time, flags, f"{ROOT}/{lane}")


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
