"""What instruments do that no model says: noise has the colour, tails and level that were chosen, clocks differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kurtosis

from concealing.case import Instruments
from concealing.files import record
from concealing.flown import fly_case
from concealing.instruments import gyro_noise
from concealing.sensors import draw_noise
from support.blind_cases import blind_case

TICKS, SAMPLES, RUNS = 5, 4000, 4


def samples_of(**instruments):
    case = replace(blind_case(3), instruments=Instruments(**instruments))
    white = draw_noise(np.random.SeedSequence(5), TICKS * SAMPLES, RUNS, 0, 0.0125)
    return gyro_noise(case, white, TICKS).gyro[::TICKS]


@pytest.mark.parametrize("correlation", [-0.5, 0.2, 0.5])
def test_neighbouring_samples_are_correlated_as_asked_for_and_their_variance_stays(correlation):
    samples = samples_of(noise_correlation=correlation)
    assert np.mean(samples[1:] * samples[:-1]) == pytest.approx(correlation, abs=0.03)
    assert samples.var() == pytest.approx(1.0, abs=0.03)


def test_a_slow_part_within_white_noise_is_correlated_by_its_share():
    samples = samples_of(noise_correlation=0.8, noise_white=0.6)
    for apart in (1, 2, 4):
        assert np.mean(samples[apart:] * samples[:-apart]) == pytest.approx(0.4 * 0.8**apart, abs=0.03)
    assert samples.var() == pytest.approx(1.0, abs=0.03)


def test_noise_behind_an_anti_alias_filter_is_correlated_by_its_impulse_response():
    samples = samples_of(anti_alias=0.4)
    assert np.mean(samples[1:] * samples[:-1]) == pytest.approx(0.131, abs=0.02)  # e^-a (cos a + sin a), a = 0.4 π √2


def test_noise_of_five_degrees_of_freedom_has_heavy_tails_and_unit_variance():
    samples = samples_of(tail_freedom=5.0)
    assert samples.var() == pytest.approx(1.0, abs=0.03)
    assert kurtosis(samples, axis=None) > 2.0


def test_noise_by_run_has_another_level_in_every_run():
    levels = samples_of(noise_by_run=0.2).std(axis=(0, 2))
    assert np.ptp(levels) > 0.05
    assert np.all(np.abs(levels - 1.0) < 0.25)


def test_late_telemetry_shows_the_angles_of_before():
    case = blind_case(3)
    period = 1.0 / case.telemetry.gyro_rate
    late = replace(case, instruments=Instruments(telemetry_delay=period))
    angle, delayed = (record(fly_case(each, quiet=True), 0).channels["gimbal_angle"] for each in (case, late))
    assert delayed[1:] == pytest.approx(angle[:-1], abs=1e-9)


def test_an_averaging_gyro_is_late_by_half_a_period():
    case = blind_case(3)
    averaging = replace(case, instruments=Instruments(averaging=True))
    rate, mean = (record(fly_case(each, quiet=True), 0).channels["body_rate"] for each in (case, averaging))
    between = 0.5 * (rate[1:] + rate[:-1])
    assert np.abs(mean[1:] - between).max() < 0.1 * np.abs(mean[1:] - rate[1:]).max()


def test_instruments_that_do_nothing_change_no_record():
    case = blind_case(3)
    plain, same = (record(fly_case(each), 0) for each in (case, replace(case, instruments=Instruments())))
    assert all(np.array_equal(plain.channels[name], same.channels[name]) for name in plain.channels)
