"""Wheels' telemetry that is sampled between the instants at which commands change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.wheel_telemetry import PERIOD, WHEELS, commanded_wheels, wheels_at_rest
from testbed.prediction.command_phase import command_phase, torque_phase, with_command_phase


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


@pytest.mark.parametrize(("recorded", "goes_on"), [("until", 0.0), ("at", 0.5)])
@pytest.mark.parametrize("seed", [51, 52])
def test_measured_torques_are_what_was_given_until_their_sample_or_what_is_given_at_it(recorded, goes_on, seed):
    """One that is shown at an instant goes on for half a period; beyond the stated limit it was given all the same."""
    rng, time = np.random.default_rng(seed), PERIOD * np.arange(601)
    shift = np.arange(WHEELS)
    torque = sum(1e-3 * np.cos(rate * time[:, None] + shift) for rate in (0.9, 2.3))
    given = sum(1e-3 / rate * (np.sin(rate * time[:, None] + shift) - np.sin(shift)) for rate in (0.9, 2.3))
    mean = np.concatenate([torque[:1], np.diff(given, axis=0) / PERIOD])
    momentum = 0.02 + given + 7.5e-7 * rng.standard_normal(given.shape)
    run = wheels_at_rest(momentum, torque, time)
    assert run.wheels is not None
    limited = replace(run.wheels.wheels, torque_limit=np.full(WHEELS, 5e-4))
    shown = mean if recorded == "until" else torque
    run = replace(run, wheels=replace(run.wheels, wheels=limited, torque_command=None, torque=shown))
    assert torque_phase(with_command_phase([run])) == pytest.approx(goes_on * PERIOD, abs=0.01 * PERIOD)
