"""Effects that take each other away: only the one that is there is named."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.blind import counts_of
from benchmarks.blind_diagnosis import diagnosis_of
from concealing.blind_set import make, orders
from concealing.order import case_name
from support.diagnosed_records import SCENARIO

SEED, CASE = 6841, "case_0188"
"""Of a set with a gyro of 103 Hz that was one of 19 Hz beside telemetry 7 ms late."""


def test_a_fast_gyro_is_no_slow_one_beside_late_telemetry(tmp_path):
    order = next(each for each in orders(counts_of(856), SEED) if case_name(each) == CASE)
    data = make(order, SEED, SCENARIO, tmp_path / "data", tmp_path / "answers")
    content = diagnosis_of(SCENARIO, data)
    inertia, step = content["steps"]
    assert inertia["effect"] == "inertia"
    # What a low-pass takes of the encoders' noise is all that makes it more probable than a delay as long.
    (shown, *_), (size, *_) = content["probabilities"], step["parameters"].values()
    assert "gyro_bandwidth:gyro" in shown.split("|")
    late = 1.0 / (2.0 * np.pi * size["value"]) if step["effect"] == "gyro_bandwidth" else abs(size["value"])
    assert late == pytest.approx(1.0 / (2.0 * np.pi * 103.0), rel=0.1)
