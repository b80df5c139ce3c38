"""A gyro that reads in steps, in healthy records as in suspect ones, is nothing new; coarser steps are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import testbed as tb
from support.few_effects import know_only
from support.thrusters import body_scenario
from tests.unit.test_measured_actuators import RIG, rig_run

HEALTHY_STEP = 2e-3


def read_in_steps(seed: int, step: float):
    """A healthy rig of one wheel, whose gyro has a noise of 1e-3 rad/s and reads in steps."""
    record = rig_run(seed, inertia=0.05, drag=0.0)
    rates = step * np.round(record.channels["body_rate"] / step)
    return replace(record, channels=record.channels | {"body_rate": rates})


@pytest.mark.parametrize(("step", "verdict"), [(HEALTHY_STEP, "none"), (2.0 * HEALTHY_STEP, "named")])
def test_steps_of_the_gyro_that_healthy_records_have_are_nothing_new(step, verdict, monkeypatch):
    know_only(monkeypatch, "viscous_drag", "dry_friction", "gyro_latency", "gyro_scale")
    healthy = tb.Records(tuple(read_in_steps(seed, HEALTHY_STEP) for seed in range(1, 6)))
    suspect = tb.Records(tuple(read_in_steps(seed, step) for seed in range(11, 16)))
    scenario = body_scenario(RIG, "rig.toml")
    assert [each.key for each in tb.diagnose(scenario, healthy).state.added] == ["gyro_quantization:gyro"]
    found = tb.diagnose(scenario, suspect, reference=healthy)
    assert found.verdict == verdict
    assert [each.key for each in found.state.added] == (["gyro_quantization:gyro"] if verdict == "named" else [])
    known = [text for text in found.notices if "nothing new: gyro_quantization:gyro" in text]
    assert len(known) == (verdict == "none")
