"""The gyro's noise from its samples alone, and what a record's own statement is worth beside it."""

from pathlib import Path

import numpy as np
import pytest

from testbed.assembly.platform import nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.estimation.gyro_noise import gyro_noise_of
from testbed.records.record import Record, RunDetails
from testbed.scenario.reader import read_scenario

SIGMA = 0.001658
TIME = np.arange(400) / 16.0
WITHIN = 0.15  # two standard deviations of a robust answer from 3 x 396 overlapping differences
SCENARIO = read_scenario(Path(__file__).resolve().parents[2] / "scenarios" / "basic.toml")
NOMINAL = nominal_platform(SCENARIO)


def rate_at(time):
    """A maneuver's rates, 0.7 rad/s at up to 2 rad/s."""
    return 0.7 * np.column_stack([np.sin(time), np.cos(1.3 * time), np.sin(2.0 * time)])


def noisy(rate, seed=0):
    return rate + np.random.default_rng(seed).normal(0.0, SIGMA, rate.shape)


def jittered(time):
    return time + np.random.default_rng(1).uniform(-0.02, 0.02, time.size)


def noise_used(time, rate, **details):
    channels = {"body_rate": rate, "applied_torque": np.zeros((len(time), 3))}
    record = Record(time=time, channels=channels, details=RunDetails(name="run", **details))
    return telemetry_of(record, SCENARIO, NOMINAL).gyro_noise


def test_the_motion_is_not_taken_for_noise():
    assert gyro_noise_of(TIME, noisy(rate_at(TIME))) == pytest.approx(SIGMA, rel=WITHIN)


def test_uneven_samples_do_not_matter():
    time = jittered(TIME)
    assert gyro_noise_of(time, noisy(rate_at(time))) == pytest.approx(SIGMA, rel=WITHIN)


def test_uneven_time_stamps_of_even_samples_do_not_matter():
    assert gyro_noise_of(jittered(TIME), noisy(rate_at(TIME))) == pytest.approx(SIGMA, rel=WITHIN)


def test_gaps_and_outliers_do_not_matter():
    rate = noisy(rate_at(TIME))
    rate[::100] += 3.0
    kept = (TIME < 5.0) | (TIME > 8.0)
    assert gyro_noise_of(TIME[kept], rate[kept]) == pytest.approx(SIGMA, rel=0.25)  # a tenth of windows hit


def test_a_short_record_and_repeated_samples_tell_nothing():
    assert gyro_noise_of(TIME[:20], noisy(rate_at(TIME[:20]))) is None
    assert gyro_noise_of(TIME, np.repeat(noisy(rate_at(TIME[:40])), 10, axis=0)) is None


@pytest.mark.parametrize("stated", [None, 0.0])
def test_a_measured_record_without_noise_tells_it_by_its_samples(stated):
    assert noise_used(TIME, noisy(rate_at(TIME)), gyro_noise=stated) == pytest.approx(SIGMA, rel=WITHIN)


def test_a_short_measured_record_has_the_scenarios_noise():
    assert noise_used(TIME[:20], noisy(rate_at(TIME[:20]))) == SCENARIO.gyro.noise_rad_s


def test_stated_noise_and_the_simulators_are_kept():
    rate = noisy(rate_at(TIME))
    assert noise_used(TIME, rate, gyro_noise=0.01) == 0.01
    assert noise_used(TIME, rate, gyro_noise=0.0, source="simulated") == 0.0
    assert noise_used(TIME, rate, source="simulated") == SCENARIO.gyro.noise_rad_s
