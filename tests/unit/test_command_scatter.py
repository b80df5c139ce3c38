"""Wheels whose commands change several times between the samples of their telemetry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.wheel_telemetry import PERIOD, commanded_wheels, undersampled_wheels
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.command_phase import command_phase, with_command_phase
from testbed.prediction.command_scatter import believed_held, found_changing, with_command_scatter
from testbed.prediction.wheel_impulses import impulses_of


def believed(run: Telemetry, periods: int) -> Telemetry:
    """Return a run whose controller is believed to have so many periods between samples."""
    return run.with_motors(lambda motors: replace(motors, period=PERIOD / periods))


def left(run: Telemetry) -> float:
    """Return the root mean square of what impulses miss of what turned the wheels, N·m·s."""
    impulses = impulses_of(run, commanded=True)
    assert impulses is not None
    return float(np.sqrt(np.mean((impulses.needed - impulses.asked)[5:-5] ** 2)))


@pytest.mark.parametrize("periods", [2, 5])
@pytest.mark.parametrize("seed", [71, 72])
def test_scatter_acts_for_one_control_period_of_several(periods, seed):
    run = believed(undersampled_wheels(periods, seed), periods)
    (known,) = with_command_scatter([run])
    assert known.wheels is not None
    assert known.wheels.scatter is not None
    assert known.wheels.scatter.behind == pytest.approx(1.0 / periods, abs=0.08)  # a tenth of it is taken for smooth
    assert known.wheels.scatter.before == pytest.approx(0.0, abs=0.08)
    assert not found_changing([known])
    print(f"{left(run):.2e} -> {left(known):.2e} N·m·s")
    assert left(known) < 0.95 * left(run)


@pytest.mark.parametrize("seed", [73, 74])
def test_commands_that_are_believed_to_hold_and_do_not_are_found(seed):
    (known,) = with_command_phase([undersampled_wheels(5, seed)])
    assert not believed_held([known])
    assert found_changing([known])


@pytest.mark.parametrize("periods", [2, 5, 10])
@pytest.mark.parametrize("seed", [79, 80])
def test_commands_that_change_smoothly_in_between_do_not_hold_at_a_phase(periods, seed):
    """Taken to lie on lines between samples, they left a factor of motors that nobody has."""
    (known,) = with_command_phase([undersampled_wheels(periods, seed, scatter=0.0, rates=(0.9, 2.3, 5.1))])
    assert found_changing([known])
    assert known.wheels is not None
    assert known.wheels.motors is not None
    assert known.wheels.motors.period == pytest.approx(PERIOD / periods, rel=1e-6)
    assert command_phase([known]) == 0.0


@pytest.mark.parametrize("seed", [75, 76, 77])
@pytest.mark.parametrize("phase", [0.0, 0.4])
def test_commands_that_hold_stay_as_they_are_believed(seed, phase):
    (known,) = with_command_phase([commanded_wheels(phase, seed)])
    assert believed_held([known])
    assert known.wheels is not None
    assert known.wheels.scatter is None


def test_samples_are_chosen_of_the_scatter_too():
    (known,) = with_command_scatter([believed(undersampled_wheels(5, 78), 5)])
    half = known.with_actuator_samples(known.actuator_time[:300], lambda samples: samples[:300])
    assert half.wheels is not None
    assert half.wheels.scatter is not None
    assert half.wheels.scatter.samples.shape == (300, 4)


def test_no_runs_stay_none():
    assert with_command_phase([]) == []
