"""Torques that jump between two samples of them, at an instant that nobody recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from support.wheel_telemetry import NOISE, ONE_WAY, PERIOD, WHEELS, undersampled_wheels, wheels_at_rest
from testbed.arrays import Array
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.command_phase import with_command_phase
from testbed.prediction.jumps import beside, jumps, restless
from testbed.prediction.tachometer import smoothed_wheels, without_tachometer_noise
from testbed.prediction.wheel_impulses import impulses_of

TIME = 0.2 * np.arange(400)


def smooth(time: Array) -> Array:
    return 1e-3 * np.stack([np.cos(0.9 * time), np.sin(0.4 * time)], axis=-1)


@pytest.mark.parametrize("scatter", [0.0, 1e-5])
def test_a_jump_is_found_between_its_samples(scatter):
    samples = smooth(TIME) + scatter * np.random.default_rng(5).standard_normal((len(TIME), 2))
    assert not jumps(TIME, samples).any()
    samples[200:, 1] += 8e-4
    found = np.flatnonzero(jumps(TIME, samples)).tolist()
    assert 199 in found
    assert set(found) <= set(range(197, 202))


def test_commands_that_step_all_the_time_are_not_jumps():
    """Of a random binary signal a third of all samples miss their neighbours: there is nothing to hold them against."""
    steps = np.repeat(np.random.default_rng(6).choice([-1e-3, 1e-3], (100, 1)), 4, axis=0)
    assert not jumps(TIME, steps).any()


def test_a_spline_is_believed_from_the_fourth_interval_behind_a_jump():
    jump = np.zeros(20, dtype=np.bool_)
    jump[10] = True
    assert np.flatnonzero(beside(jump)).tolist() == [7, 8, 9, 10, 11, 12, 13]
    assert beside(np.array([False, True, False])).tolist() == [True, True, True]
    assert beside(jump[:0]).tolist() == []


def test_the_maneuver_of_a_flight_that_mostly_rests_is_restless():
    noise = 1e-5 * np.random.default_rng(7).standard_normal((len(TIME), 2))
    assert not restless(TIME, noise).any()
    moved = restless(TIME, noise + smooth(8.0 * TIME) * (TIME < 15.0)[:, None])
    assert moved[:70].all()
    assert not moved[90:].any()


def test_few_samples_have_no_jumps():
    assert jumps(TIME[:5], smooth(TIME[:5])).tolist() == [False] * 4
    assert restless(TIME[:5], smooth(TIME[:5])).tolist() == [[False] * 2] * 4


PERIODS, ENDED = 4, 900
"""Control periods from sample to sample, and the first of them behind the end of a maneuver."""


def stopped(seed: int, size: float) -> Telemetry:
    """Two minutes of wheels whose maneuver ends while they are accelerated: from then on only noise is commanded."""
    end = PERIOD / PERIODS * (ENDED * PERIODS - 1.5)
    return flown(seed, lambda ticks: size * np.cos(0.9 * ticks + np.arange(WHEELS)) * (ticks < end))


def flown(seed: int, maneuver: Callable[[Array], Array]) -> Telemetry:
    """Two minutes of wheels, what is commanded behind the noise of a controller's gyro."""
    rng = np.random.default_rng(seed)
    ticks = PERIOD / PERIODS * np.arange(1200 * PERIODS)
    command = np.broadcast_to(maneuver(ticks[:, None]), (len(ticks), WHEELS)).copy()
    command += 1e-5 * rng.standard_normal(command.shape)
    momentum = ONE_WAY + np.concatenate([np.zeros((1, WHEELS)), np.cumsum(command * PERIOD / PERIODS, axis=0)[:-1]])
    shown = momentum[::PERIODS] + 0.1 * NOISE * rng.standard_normal((1200, WHEELS))
    run = wheels_at_rest(shown, command[::PERIODS], ticks[::PERIODS])
    return run.with_motors(lambda motors: replace(motors, period=PERIOD / PERIODS))


def test_the_interval_of_a_jump_is_not_compared_and_the_others_are_as_good_as_ever():
    run = stopped(81, 5e-3)
    impulses = impulses_of(run, commanded=True)
    assert impulses is not None
    missed = np.abs(impulses.needed - impulses.asked)
    assert missed[ENDED - 1].max() > 50.0 * NOISE
    for wheel, kept in enumerate(impulses.kept):
        assert ENDED - 1 not in kept
        assert len(kept) > 0.98 * len(missed) - 11
        assert missed[kept, wheel].max() < 6.0 * NOISE


def test_what_scatters_in_commands_is_found_beside_a_jump():
    (run,) = with_command_phase([stopped(82, 1e-3)])
    assert run.wheels is not None
    assert run.wheels.scatter is not None
    assert run.wheels.scatter.samples.std(axis=0).min() > 5e-6
    assert 0.0 < run.wheels.scatter.behind < 0.3  # it acts for a quarter of the interval; 0.5 with the jump in it


def faded(seed: int) -> Telemetry:
    """Two minutes of wheels, the first quarter a maneuver that fades out; from then on only noise is commanded."""
    return flown(seed, lambda ticks: 5e-3 * np.cos(6.0 * ticks) * np.clip((30.0 - ticks) / 5.0, 0.0, 1.0) ** 4)


def test_what_scatters_in_commands_is_found_behind_a_maneuver_that_fades_out():
    (run,) = with_command_phase([faded(85)])
    assert run.wheels is not None
    assert run.wheels.scatter is not None
    assert run.wheels.scatter.samples[400:].std(axis=0).min() > 6e-6
    assert not run.wheels.scatter.samples[:200].any()
    assert 0.0 < run.wheels.scatter.behind < 0.35


def test_a_jump_hides_no_noise_of_the_tachometers():
    (run,) = without_tachometer_noise([stopped(83, 5e-3)])
    assert run.wheels is not None
    assert run.wheels.smoothed is not None
    assert np.sqrt(run.wheels.smoothed.variance).max() < 0.5 * NOISE  # 0.7 with it taken for torque that jitters


def test_where_torques_are_known_the_gyro_may_choose_samples_as_they_were_sent():
    """What is not known of torques between samples the controller made of the gyro's noise."""
    run = undersampled_wheels(1, 84)
    ((left,),) = smoothed_wheels([run])
    assert left.wheels is not None
    assert run.wheels is not None
    np.testing.assert_array_equal(left.wheels.best_momentum, run.wheels.momentum)
    (smoothed,) = without_tachometer_noise([run])
    assert smoothed.wheels is not None
    assert list(smoothed_wheels([smoothed])) == []
    assert np.abs(smoothed.wheels.best_momentum - run.wheels.momentum).max() > 0.01 * NOISE
