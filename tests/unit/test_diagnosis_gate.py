"""What the data gate does before anything is named: spikes, unstated noise, telemetry noise, roles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import NOISE, nominal, records
from testbed.diagnosis.p_values import p_value
from testbed.diagnosis.reading import data_set_of
from testbed.effects.contact import Contact
from testbed.effects.registry import EFFECTS
from testbed.estimation.contact import shows_a_jump
from testbed.prediction.grid import begin_of_runs


@pytest.fixture(scope="module")
def good():
    return records(4)


def read(used):
    return data_set_of(used, *nominal())


def with_rate(record, rate):
    return replace(record, channels={**record.channels, "body_rate": rate})


def unstated(record):
    return replace(record, details=replace(record.details, gyro_noise=None, source="measured"))


def test_spikes_are_left_out_and_all_else_is_kept(good):
    rate = good[0].channels["body_rate"].copy()
    rate[[7, 30], [0, 2]] += np.array([12.0, -20.0]) * NOISE
    data = read([with_rate(good[0], rate), *good[1:]])
    kept = data.runs.grid.runs[0].gyro_time
    assert sorted(set(good[0].time) - set(kept)) == good[0].time[[7, 30]].tolist()
    assert any("run1: 2 gyro samples stand alone" in notice for notice in data.notices)


def test_a_gyro_that_shows_nothing_but_spikes_keeps_them():
    rng = np.random.default_rng(5)
    wild = []
    for record in records(2, seed=3):
        hit = rng.random(record.channels["body_rate"].shape) < 0.1
        wild.append(with_rate(record, record.channels["body_rate"] + 20.0 * NOISE * hit))
    data = read(wild)
    assert all(len(run.gyro_time) == len(wild[0].time) for run in data.runs.grid.runs)


def test_a_jump_of_the_rate_is_no_spike(good):
    rate = good[0].channels["body_rate"].copy()
    rate[30:] += 12.0 * NOISE
    assert len(read([with_rate(good[0], rate), *good[1:]]).runs.grid.runs[0].gyro_time) == len(good[0].time)


def test_a_short_clipped_peak_is_no_spike(good):
    rate = good[0].channels["body_rate"].copy()
    limit = 2.0 * np.abs(rate).max()
    rate[[9, 20, 33], 1] = limit  # peaks of one sample each, all cut at the same reading
    spiky = rate.copy()
    spiky[[9, 20, 33], 1] *= np.array([1.0, 0.9, 0.8])
    for given, kept in ((rate, len(rate)), (spiky, len(rate) - 3)):
        data = read([with_rate(good[0], given), *good[1:]])
        (run,) = (run for run, name in zip(data.runs.grid.runs, data.runs.names, strict=True) if name == "run1")
        assert len(run.gyro_time) == kept


def test_a_spike_beside_the_largest_reading_of_another_axis_is_left_out(good):
    rate = good[0].channels["body_rate"].copy()
    rate[[9, 20, 33], 1] = 2.0 * np.abs(rate).max()
    rate[20, 0] -= 20.0 * NOISE
    data = read([with_rate(good[0], rate), *good[1:]])
    (run,) = (run for run, name in zip(data.runs.grid.runs, data.runs.names, strict=True) if name == "run1")
    assert set(good[0].time) - set(run.gyro_time) == {good[0].time[20]}


def test_unstated_noise_is_estimated_from_all_runs_together_and_known_as_well_as_that(good):
    data = read([unstated(record) for record in good])
    assert data.runs.sigma == pytest.approx(NOISE, rel=0.15)
    assert np.ptp(data.runs.sigma) == 0.0
    assert 200.0 < data.runs.noise_freedom < sum(record.channels["body_rate"].size for record in good)


def test_stated_noise_is_known_exactly(good):
    assert np.isinf(read(good).runs.noise_freedom)


def test_the_encoders_noise_is_added_to_the_gyros(good):
    rng = np.random.default_rng(2)
    noisy = []
    for record in good:
        angle = record.channels["gimbal_angle"]
        noisy.append(
            replace(record, channels={**record.channels, "gimbal_angle": angle + rng.normal(0.0, 2e-3, angle.shape)})
        )
    _, platform = nominal()
    share = read(noisy).runs.sigma ** 2 - read(good).runs.sigma ** 2
    added = (share.mean(axis=0) * np.diag(platform.inertia) ** 2).sum()
    assert added == pytest.approx(6.0 * (2e-3 * platform.cluster.rotor_momentum[0]) ** 2, rel=0.3)


def test_an_estimated_noise_makes_a_large_sum_of_squares_less_surprising():
    assert p_value(150.0, 100, np.inf) == pytest.approx(0.00090, rel=0.05)
    assert p_value(150.0, 100, 50.0) > 10.0 * p_value(150.0, 100, np.inf)


def test_a_run_that_was_touched_is_fitted_wherever_it_stands():
    touched = records(3, hooks=[Contact().hooks("platform")], values=[touch_in_the_third_run()])
    assert read(touched).heldout.names == ("run2",)
    assert read(records(3)).heldout.names == ("run3",)


def test_where_every_run_seems_to_jump_the_touched_one_is_fitted():
    hooks = [EFFECTS["rotor_spin_down"].hooks("cmg4"), Contact().hooks("platform")]
    values = [np.array([0.03]), touch_in_the_third_run()]
    touched = records(3, hooks=hooks, values=values)
    assert all(shows_a_jump(run) for run in read(touched).runs.grid.runs)
    assert read(touched).heldout.names != ("run3",)


def touch_in_the_third_run():
    begin = begin_of_runs(read(records(3)).runs.grid)
    between = float(begin[1])  # of runs of equal length
    return np.array([2.0 * between + 2.0, 3e-4, -2e-4, 1e-4])


def test_a_clipped_run_is_fitted_wherever_it_stands(good):
    rate = good[2].channels["body_rate"]
    clipped = with_rate(good[2], np.clip(rate, -0.8 * np.abs(rate).max(), 0.8 * np.abs(rate).max()))
    assert "run3" in read([*good[:2], clipped]).runs.names


def test_only_a_touch_happens_once():
    assert [effect.id for effect in EFFECTS.values() if not effect.recurs] == ["contact"]


@pytest.mark.parametrize("share", [1.0, 0.9])
def test_a_copy_of_a_flight_is_left_out_and_named(good, share):
    """Of 0.9 of the period the time of a clock that began elsewhere has other last digits."""
    good = [replace(record, time=share * record.time) for record in good]
    copied = replace(good[0], details=replace(good[0].details, name="copy"), time=good[0].time + 5.0)
    data = read([*good, copied])
    assert "copy" not in data.fit_records + data.heldout_records
    assert any("copy: holds the samples of run1" in notice for notice in data.notices)


def test_a_flight_given_twice_is_a_single_one(good):
    twice = [good[0], replace(good[0], details=replace(good[0].details, name="again"))]
    assert read(twice).alone
