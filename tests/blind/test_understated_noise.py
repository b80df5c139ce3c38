"""Noise that is stated too small stands out of its own estimate as an oscillation would, and gets its name."""

from __future__ import annotations

from benchmarks.blind_diagnosis import diagnosis_of
from concealing.blind_set import Counts, make, orders
from concealing.order import case_name
from support.diagnosed_records import SCENARIO

SEED, CASE = 2026, "case_0788"
"""Of `make blind`: 0.0011 rad/s that the records do not state, which had been said to be an unknown oscillation."""


def test_noise_stated_too_small_is_named_before_the_torques_it_would_pass_for(tmp_path):
    (order,) = (each for each in orders(Counts(), SEED) if case_name(each) == CASE)
    make(order, SEED, SCENARIO, tmp_path / "data", tmp_path / "answers")
    diagnosis = diagnosis_of(SCENARIO, tmp_path / "data" / CASE)
    assert [step["effect"] for step in diagnosis["steps"] if step["effect"] != "inertia"] == ["gyro_noise"]
    assert diagnosis["verdict"] == "named"
