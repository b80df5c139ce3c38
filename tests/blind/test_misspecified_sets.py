"""Null sets whose noise is not as stated: a colour or a level is named as what it is, or not at all."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.blind_diagnosis import diagnosis_of
from benchmarks.misspecified import KINDS, case_of
from concealing.case import Instruments
from concealing.files import conceal
from support.blind_cases import blind_case
from support.diagnosed_records import SCENARIO

WHOLE, BETWEEN = (8812, 1), (9351, 6)
"""Seeds and numbers of sets with motor torques that had names beside their own where angles were late by a sample or
half of one, and where all channels were so by half of one: between two samples their noise is a mean, with a colour."""
CLOCKS = (9351, 10)
"""Of a set in which a clock that runs slow had been drag."""
SEED = 2
"""Of a set that was `unexplained` in both cases while noise was white and as stated."""


@pytest.mark.parametrize(
    ("correlation", "white", "stated", "right"),
    [(0.3, 0.0, 1.0, "gyro_noise_color"), (0.8, 0.6, 1.0, "gyro_noise_color"), (0.0, 0.0, 0.87, "gyro_noise")],
    ids=["colour", "slow part in white noise", "level"],
)
def test_noise_that_is_not_as_stated_is_neither_another_effect_nor_unexplained(
    tmp_path, correlation, white, stated, right
):
    case = blind_case(SEED)
    case = replace(
        case,
        instruments=Instruments(noise_correlation=correlation, noise_white=white),
        telemetry=replace(case.telemetry, stated_noise=stated),
    )
    conceal(case, tmp_path / "data", tmp_path / "answer")
    content = diagnosis_of(SCENARIO, tmp_path / "data")
    assert content["verdict"] in ("none", "named")
    assert {step["effect"] for step in content["steps"]} <= {"inertia", right}


@pytest.mark.parametrize(
    ("case", "instruments", "right"),
    [
        (WHOLE, Instruments(telemetry_delay=0.031), "telemetry_skew"),
        (BETWEEN, Instruments(telemetry_delay=0.005), "telemetry_skew"),
        (WHOLE, Instruments(encoder_delay=0.5), "telemetry_skew"),
        (CLOCKS, Instruments(clock_skew=1e-3), "gyro_clock_drift"),
    ],
    ids=["all channels late", "late between samples", "angles alone late", "a slow clock"],
)
def test_late_channels_are_no_friction_no_misalignment_and_no_drag(tmp_path, case, instruments, right):
    """The motors' torques go with the body's motion and the gimbals' angles of their own instant."""
    without = case_of(KINDS["none"], *case)
    conceal(replace(without, instruments=instruments), tmp_path / "data", tmp_path / "answer")
    content = diagnosis_of(SCENARIO, tmp_path / "data")
    assert {step["effect"] for step in content["steps"]} == {"inertia", right}
