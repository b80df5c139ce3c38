"""Wheels' telemetry that is sampled between the instants at which commands change."""

from __future__ import annotations

import numpy as np
import pytest

from support.wheel_telemetry import PERIOD, WHEELS, commanded_wheels
from testbed.prediction.command_phase import command_phase, with_command_phase


@pytest.mark.parametrize("phase", [0.04, 0.3, 0.9])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_phase_of_the_commands_is_found(phase, seed):
    runs = with_command_phase([commanded_wheels(phase, seed), commanded_wheels(phase, seed + 10)])
    assert command_phase(runs) == pytest.approx(phase * PERIOD, abs=0.015 * PERIOD)  # two standard errors


@pytest.mark.parametrize("seed", range(20, 30))
def test_telemetry_on_the_commands_own_clock_is_left_as_it_is(seed):
    runs = [commanded_wheels(0.0, seed)]
    assert with_command_phase(runs) == runs


def test_a_motor_that_lags_is_no_phase():
    for lag in (np.array([0.0, 0.0, 0.03, 0.0]), np.full(WHEELS, 0.03)):
        assert command_phase(with_command_phase([commanded_wheels(0.0, 31, lag)])) == 0.0


def test_too_few_impulses_show_no_phase():
    whole = commanded_wheels(0.3, 41)
    assert whole.wheels is not None
    short = whole.with_actuator_samples(whole.actuator_time[:30], lambda samples: samples[:30])
    assert command_phase(with_command_phase([short])) == 0.0
