"""Wheel speeds without commands, whose tachometers' noise must not pass for an effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import testbed as tb
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.tachometers import distinct_from_tachometers
from testbed.effects.registry import NOISE_EFFECTS
from testbed.prediction.tachometer import smoothed_wheels
from testbed.records.record import Record

SCENARIO = "scenarios/cubesat_wheels.toml"
SECONDS = 40.0


def flown(seed: int, noise: float, *, commanded: bool) -> Record:
    changes = {"seed": seed, "wheel_tachometer.noise_rad_s": noise, "simulation.duration_s": SECONDS}
    record = tb.fly(tb.read_scenario(SCENARIO, changes)).record
    channels = {key: value for key, value in record.channels.items() if commanded or "torque" not in key}
    return replace(record, channels=channels, details=replace(record.details, name=f"flight{seed}"))


def wheels_of(noise: float, *, commanded: bool):
    scenario = tb.read_scenario(SCENARIO, {"wheel_tachometer.noise_rad_s": noise})
    records = [flown(seed, noise, commanded=commanded) for seed in (41, 42)]
    data = data_set_of(records, scenario, nominal_platform(scenario))
    return data, data.runs.grid.runs[0].wheels


def test_speeds_of_noisy_tachometers_are_smoothed_as_the_gyro_has_it():
    data, wheels = wheels_of(0.5, commanded=False)
    _, exact = wheels_of(0.0, commanded=False)
    assert wheels.smoothed is not None
    before, after = wheels.momentum - exact.momentum, wheels.best_momentum - exact.momentum
    assert np.all(np.std(after, axis=0) < 0.8 * np.std(before, axis=0))
    assert any("tachometers have noise of about 0.6" in each for each in data.notices)


def test_speeds_that_are_known_well_enough_stay_as_they_are():
    data, wheels = wheels_of(1e-4, commanded=False)
    assert wheels.smoothed is None
    assert not any("tachometers" in each for each in data.notices)


def test_where_commands_tell_the_noise_the_gyro_is_not_asked():
    data, wheels = wheels_of(0.5, commanded=True)
    assert wheels.smoothed is not None
    assert wheels.smoothed.noise is None
    assert list(smoothed_wheels(data.runs.grid.runs)) == []
    assert distinct_from_tachometers(data.runs, NOISE_EFFECTS) == (NOISE_EFFECTS, [])


def test_the_level_and_the_color_of_the_gyros_noise_are_not_distinguished_from_it():
    data, _ = wheels_of(0.5, commanded=False)
    effects, hidden = distinct_from_tachometers(data.runs, NOISE_EFFECTS)
    assert {each.effect for each in hidden} == {"gyro_noise", "gyro_noise_color"}
    assert set(effects) == set(NOISE_EFFECTS) - {"gyro_noise", "gyro_noise_color"}
    assert all("wheel_torque_command" in each.needs for each in hidden)


def test_ever_more_is_smoothed_but_never_more_than_the_noise():
    run = wheels_of(0.5, commanded=False)[0].runs.grid.runs[0]
    noisy = replace(run, wheels=replace(run.wheels, smoothed=None))
    sizes = [np.std(noisy.wheels.momentum - one.wheels.best_momentum, axis=0) for (one,) in smoothed_wheels([noisy])]
    noise = next(iter(smoothed_wheels([noisy])))[0].wheels.smoothed.noise
    assert len(sizes) > 1
    assert all(np.all(size <= 1.001 * noise) for size in sizes)
    assert np.all(sizes[1] > sizes[0])
