"""Runs averaged down and cut into windows, and what that makes of a real quadcopter's flights."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from testbed.arrays import Array, Series
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.latent import latent_torque, on_enough_runs
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Fit
from testbed.diagnosis.reading import DataSet, belief_of, data_set_of
from testbed.diagnosis.run_residuals import residuals_of
from testbed.diagnosis.windows import averaged, parts_of, windows_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.direction import scanned
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError
from testbed.estimation.telemetry import Telemetry
from testbed.estimation.torque_noise import covariance
from testbed.prediction.grid import LONGEST_STEP, grid_of
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_body_scenario

ROOT = Path(__file__).parents[2]
SCENARIO = read_body_scenario(ROOT / "scenarios" / "crazyflie.toml")
NOMINAL = nominal_body(SCENARIO)
RECORDS = read_data_set(ROOT / "data" / "crazyflie")
TESTED = (
    "viscous_drag",
    "body_torque",
    "inertial_torque",
    "tether",
    "gyro_bandwidth",
    "actuator_lag",
    "actuator_delay",
)


def driven(rate: float = 1000.0, duration: float = 1.0) -> Telemetry:
    time = np.arange(0.0, duration, 1.0 / rate)
    noise = np.random.default_rng(1).normal(0.0, 0.01, (len(time), 3))
    ramp = np.outer(time, [1.0, -2.0, 0.5])
    return Telemetry(
        gyro_time=time,
        body_rate=ramp + noise,
        gyro_noise=0.01,
        actuator_time=time,
        gimbals=None,
        applied_torque=2.0 * ramp,
    )


def test_averages_keep_a_ramp_and_lose_noise():
    mean = averaged(driven(), 100.0)
    assert len(mean.gyro_time) == 100
    np.testing.assert_allclose(mean.applied_torque, 2.0 * np.outer(mean.actuator_time, [1.0, -2.0, 0.5]), atol=1e-12)
    left = mean.body_rate - np.outer(mean.gyro_time, [1.0, -2.0, 0.5])
    assert mean.gyro_noise == pytest.approx(0.01 / np.sqrt(10.0))
    assert left.std() == pytest.approx(mean.gyro_noise, rel=0.15)  # of 300 numbers it scatters by 4 %


def test_slower_samples_are_left_as_they_are():
    run = driven(rate=50.0)
    np.testing.assert_array_equal(averaged(run, 100.0).body_rate, run.body_rate)


def test_samples_as_slow_as_the_means_stay_whatever_their_stamps_round_to():
    run = driven(rate=100.0)
    late = np.arange(len(run.actuator_time)) * 0.01 + 0.005  # 0.015 s are 1.4999999999999998 periods
    shifted = replace(run, actuator_time=late)
    assert len(np.unique(np.floor((late - late[0]) * 100.0))) < len(late)
    np.testing.assert_array_equal(averaged(shifted, 100.0).actuator_time, late)


def test_means_are_of_no_half_a_sample():
    run = driven()
    kept = np.r_[0:500, 504:1000]
    gap = replace(run, gyro_time=run.gyro_time[kept], body_rate=run.body_rate[kept])
    lost = np.r_[0:500, 508:1000]
    wide = replace(run, gyro_time=run.gyro_time[lost], body_rate=run.body_rate[lost])
    assert (len(averaged(gap, 100.0).gyro_time), len(averaged(wide, 100.0).gyro_time)) == (100, 99)


def test_windows_follow_one_another_behind_what_they_remember():
    windows = list(windows_of(averaged(driven(), 100.0), 0.2))
    assert np.allclose([len(window.gyro_time) for window in windows], 20, atol=1)  # of which is on an edge
    assert windows[0].gyro_time[0] == pytest.approx(0.2, abs=0.01)
    for window in windows:
        assert window.gyro_time[0] - window.actuator_time[0] == pytest.approx(0.2, abs=0.02)
        assert window.actuator_time[-1] >= window.gyro_time[-1]


@pytest.mark.parametrize("horizon", [0.05, 0.6])
def test_a_run_that_gives_no_windows(horizon):
    with pytest.raises(InputError, match=r"cannot be cut into windows of .* change diagnosis\.horizon_s"):
        list(windows_of(averaged(driven(), 100.0), horizon))


def test_a_run_of_which_every_window_lacks_samples():
    run = averaged(driven(), 100.0)
    few = np.r_[0:4, 50:53, 96:100]
    thinned = replace(run, gyro_time=run.gyro_time[few], body_rate=run.body_rate[few])
    with pytest.raises(InputError, match=r"no 0\.2 s of it hold 10 gyro samples"):
        list(windows_of(thinned, 0.2))


def test_a_stretch_that_is_too_short_for_windows_does_not_cost_the_others():
    record = RECORDS[0]
    rows = np.r_[0:150, 600:2600]  # the first are too few for a window and one before it
    cut = replace(
        record,
        time=record.time[rows],
        channels={name: values[rows] for name, values in record.channels.items()},
    )
    notices: list[tuple[str, str]] = []
    parts = list(parts_of(cut, SCENARIO, NOMINAL, notices))
    assert {part.stretch for part in parts} == {f"{record.details.name} part 2"}
    assert any("2 parts are used" in text for _, text in notices)


def test_no_mode_is_looked_for_that_does_not_turn_over_in_a_window():
    assert scanned(grid_of(list(windows_of(averaged(driven(), 100.0), 0.2))), 0.3, 3.0, 0.1, 1.0).shape == (0, 5)


def test_of_very_many_runs_an_even_choice_is_enough_and_of_few_all():
    runs, fit = in_windows(hidden=0.0)
    some, at_some = on_enough_runs(runs, fit)
    assert (len(runs.names), len(some.names)) == (29, 24)
    assert (some.names[0], some.names[-1]) == (runs.names[0], runs.names[-1])
    by_name = dict(zip(runs.names, runs.by_run(fit.residual), strict=True))
    for name, residual in zip(some.names, some.by_run(at_some.residual), strict=True):
        np.testing.assert_allclose(residual, by_name[name], atol=1e-6)
    assert on_enough_runs(some, at_some) == (some, at_some)


@pytest.mark.parametrize(("hidden", "seen"), [(0.0, False), (4e-6, True)])
def test_a_torque_of_no_effect_shows_in_many_windows(hidden, seen):
    latent = latent_torque(*in_windows(hidden))
    assert len(latent.runs) == len(latent.torque_B) == len(latent.knot_time) == 24
    assert (latent.p_value < 1e-6) == seen


def in_windows(hidden: float) -> tuple[Runs, Fit]:
    """Six seconds of a roll under a torque that is known but for 2 Hz of it, of a size in N m, fitted in windows."""
    time = np.arange(0.0, 6.0, 1e-3)
    inertia = NOMINAL.inertia[0, 0]
    asked, unknown = 2e-5 * np.cos(9.0 * time), hidden * np.cos(4.0 * np.pi * time)
    rate = np.zeros((len(time), 3))
    rate[:, 0] = cumulative_trapezoid((asked + unknown) / inertia, time, initial=0.0)
    telemetry = Telemetry(
        gyro_time=time,
        body_rate=rate + np.random.default_rng(2).normal(0.0, 0.008, rate.shape),
        gyro_noise=0.008,
        actuator_time=time,
        gimbals=None,
        applied_torque=np.outer(asked, [1.0, 0.0, 0.0]),
    )
    windows = list(windows_of(averaged(telemetry, 100.0), 0.2))
    runs = runs_of([f"at {window.gyro_time[0]:.1f} s" for window in windows], windows)
    theta = theta_of(NOMINAL.inertia)
    runs = replace(runs, belief=belief_of(runs, SCENARIO, theta))
    return runs, fitted(runs, [], theta, [])


def test_the_quadcopters_records_are_read_in_windows_by_role():
    data = short(("roll_pitch_1", "yaw_1", "yaw_2"))
    assert (data.fit_records, data.heldout_records) == (("roll_pitch_1", "yaw_1"), ("yaw_2",))
    assert len(data.runs.names) == 2 * 14
    assert data.heldout is not None
    assert len(data.heldout.names) == 14
    assert data.runs.grid.step.max() <= LONGEST_STEP


def test_the_windows_of_a_record_are_shown_as_one_run():
    data = short(("roll_pitch_3", "roll_pitch_4"))
    baseline = next(diagnosed(data.runs, data.heldout, {}, theta_of(NOMINAL.inertia)))
    shown = residuals_of(baseline)
    assert [(run.name, run.held_out) for run in shown] == [("roll_pitch_3", False), ("roll_pitch_4", True)]
    for run in shown:
        assert run.time[0] == pytest.approx(0.2, abs=0.02)
        assert run.time[-1] == pytest.approx(3.0, abs=0.02)
        assert np.diff(run.time).max() < 0.045  # three samples of 10 ms are one, and what a lone wild sample leaves
        assert len(run.time) == len(run.measured) == len(run.extended) == len(run.after)


def test_gimbal_angles_without_a_cluster_are_refused():
    angles = np.zeros((len(RECORDS[0].time), 6))
    record = replace(RECORDS[0], channels={**RECORDS[0].channels, "gimbal_angle": angles})
    with pytest.raises(InputError, match=r"holds gimbal_angle, but the scenario has no \[cluster\]"):
        data_set_of([record], SCENARIO, NOMINAL)


def test_late_motors_come_first_and_shrink_the_gap_of_a_flight_that_was_held_out():
    """Three seconds to fit and three to verify; all seven flights: python -m benchmarks.crazyflie."""
    data = short(("roll_pitch_3", "yaw_1", "roll_pitch_4"))
    tested, theta = {name: EFFECTS[name] for name in TESTED}, theta_of(NOMINAL.inertia)
    stages = diagnosed(data.runs, data.heldout, tested, theta, given=data.given)
    named = next(stage for stage in stages if stage.steps)
    (step,) = named.steps
    assert step.placed.effect.id == "actuator_lag"
    (late,) = named.model.effect_values[named.model.own(step.placed)]
    assert 0.05 < late < 0.12  # s; published regressions of these flights: 70 to 90 ms
    gain = np.exp(named.model.effect_values[:2])
    assert (gain > 0.5).all()  # in the noise of the model without it a fifth of the torque was left
    assert named.gap.fit < 0.8 * named.gap_before.fit
    assert named.gap.heldout < 0.8 * named.gap_before.heldout


def test_noise_costs_what_its_covariance_has_in_all_contrasts():
    runs, _ = in_windows(4e-6)
    costs, contrasts = [], []
    apart = [[0.02, 0.1, 0.0, 0.3, 0.1], [0.01, 0.3, 1.0, 0.1, 0.2], [0.03, 0.2, 3.0, 0.2, 0.04]]
    for noise in (np.array([[0.01, 0.2, 2.0, 1.0, 0.05]] * 3), np.array(apart)):
        costs.append(replace(runs, torque_noise=noise).noise_deviance)
        contrasts.append([_of_contrasts(run.gyro_time, noise) for run in runs.grid.runs])
    np.testing.assert_allclose(np.subtract(*costs), np.subtract(*contrasts), rtol=1e-9)
    assert not runs.noise_deviance.any()  # without torque noise all models have the same


def _of_contrasts(time: Series, noise: Array) -> float:
    """Return ln det of the covariance of all differences of samples: no initial rate changes these."""
    weights = np.diff(np.eye(len(time)), axis=0)
    return sum(float(np.linalg.slogdet(weights @ each @ weights.T)[1]) for each in covariance(time, noise))


def short(names: tuple[str, ...]) -> DataSet:
    chosen = [record for record in RECORDS if record.details.name in names]
    return data_set_of(
        [replace(record, details=replace(record.details, usable_to=3.0)) for record in chosen], SCENARIO, NOMINAL
    )
