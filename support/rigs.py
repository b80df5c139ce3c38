"""A rig of one axis with a wheel on it: its scenario, and records that the concealing engine made of it."""

from __future__ import annotations

from collections.abc import Sequence

from concealing.rig import Rig, rig_record
from support.thrusters import body_scenario
from testbed.records.record import Record
from testbed.scenario.body import BodyScenario

_SCENARIO = """
schema = 1
name = "rig"
description = "A wheel on a bearing."
seed = 1

[platform]
inertia_kg_m2 = [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]]
{axes}

[gyro]
sample_rate_hz = {rate}
noise_rad_s = 1e-3

[estimation]
estimators = ["output_error"]
prefilter_time_constant_s = 0.8
instrument = "iterated"
initial_momentum = "estimated"
"""


def rig_scenario_text(axes: str = 'axes = ["z"]', rate: float = 20.0) -> str:
    """Return the rig's scenario as a file; `axes` is the line of its [platform] that says about which axes it turns."""
    return _SCENARIO.format(axes=axes, rate=rate)


def rig_scenario(axes: str = 'axes = ["z"]', rate: float = 20.0) -> BodyScenario:
    """Return the rig's scenario; arguments as `rig_scenario_text`."""
    return body_scenario(rig_scenario_text(axes, rate), "rig.toml")


def rig_records(rigs: Sequence[Rig], *, seconds: float = 6.0, rate: float = 20.0, seed: int = 100) -> list[Record]:
    """Return a run of each rig, each with motions and noise of its own."""
    return [
        rig_record(rig, f"run{number}", seed + number, seconds=seconds, rate=rate, fastest=1.0)
        for number, rig in enumerate(rigs, start=1)
    ]
