"""Inertia of a platform that thrusters turn: from torques that they hold, and as uncertain as the thrusts are."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

import testbed as tb
from support.thrusters import body_scenario, turned_by_held
from testbed.diagnosis.held_torques import HELD
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.considered import considered_shifts
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.held import held_periods, impulse_of_held
from testbed.estimation.motion import drive_of, simulate
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.telemetry import Telemetry, Thrusters, covered_part
from testbed.estimation.uncertainty import EXACT, Uncertainty
from testbed.records.record import Record, RunDetails
from testbed.report.measured import identification_notices

TRUE_THETA = np.array([20.4, 25.7, 29.1, 0.4, -0.3, 0.5])
TRUE_INERTIA = inertia_of(TRUE_THETA)
NOMINAL_THETA = np.array([20.0, 26.0, 29.0, 0.0, 0.0, 0.0])
PERIOD, COUNT = 0.1, 300
"""s for which a torque is held, and how many of them a flight has."""
FINER = 5
FINE = PERIOD / FINER
"""s between samples of a gyro that is read five times as often."""
JETS = Thrusters(
    position_B=0.5 * np.tile(np.roll(np.eye(3), 1, axis=1), (2, 1)),
    direction_B=np.concatenate([np.roll(np.eye(3), 2, axis=1), -np.roll(np.eye(3), 2, axis=1)]),
    reaction=np.zeros(6),
)
PER_THRUST_B = JETS.torque_per_thrust_B
"""N·m per N of six jets, about x, y, z and back."""
SIGMA = 1e-4
"""rad/s."""
FIRST = np.array([0.01, -0.02, 0.015])
"""rad/s."""
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA, uncertainty=EXACT)
STATED = """
schema = 1
name = "jets"
description = "Six jets."
seed = 1
[platform]
inertia_kg_m2 = [[20.0, 0, 0], [0, 26.0, 0], [0, 0, 29.0]]
mass_kg = 100.0
[gyro]
sample_rate_hz = 10.0
noise_rad_s = 1e-4
[estimation]
estimators = ["iv_momentum", "output_error"]
prefilter_time_constant_s = 0.8
instrument = "iterated"
initial_momentum = "estimated"
[diagnosis]
applied_torque = "held"
"""


def fired(seed: int):
    """Thrusts of a flight that change every half a second, shape (COUNT, 6), N; they turn it about and back."""
    rng = np.random.default_rng(seed)
    half = (rng.random((COUNT // 10, 6)) < 0.3).astype(float)
    return np.repeat(np.concatenate([half, np.roll(half[::-1], 3, axis=1)]), 5, axis=0)


def turned(thrust, inertia):
    """The body rate at the begin of each period, shape (COUNT, 3), rad/s."""
    return turned_by_held(np.arange(COUNT) * PERIOD, FIRST, inertia, thrust @ PER_THRUST_B)


def telemetry(thrust, rates):
    return Telemetry(
        gyro_time=np.arange(COUNT) * PERIOD,
        body_rate=rates,
        gyro_noise=SIGMA,
        actuator_time=(np.arange(COUNT) + 0.5) * PERIOD,
        gimbals=None,
        applied_torque=thrust @ PER_THRUST_B,
        torque_held=True,
        thrust=thrust,
        thrusters=JETS,
    )


def records(noise=SIGMA):
    for seed in range(3):
        thrust = fired(seed)
        rates = turned(thrust, TRUE_INERTIA)
        yield Record(
            time=np.arange(COUNT) * PERIOD,
            channels={
                "body_rate": rates + noise * np.random.default_rng(seed).standard_normal(rates.shape),
                "applied_torque": thrust @ PER_THRUST_B,
            },
            details=RunDetails(name=f"flight_{seed}", source="measured"),
        )


@pytest.fixture(scope="module")
def scenario():
    return body_scenario(STATED, "jets.toml")


@pytest.mark.parametrize(
    ("name", "within"), [("ls", 1e-6), ("iv", 1e-6), ("iv_momentum", 1e-5), ("output_error", 1e-6)]
)
def test_a_held_torque_is_taken_as_it_was_given(name, within):
    thrust = fired(0)
    run = replace(telemetry(thrust, turned(thrust, TRUE_INERTIA)), held_inertia=TRUE_INERTIA)
    estimate = ESTIMATORS[name](run, SETTINGS)
    np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=within * TRUE_THETA.max())


def test_samples_between_two_jumps_are_predicted_as_exactly_as_those_at_them():
    """A gyro that is read faster than torques change, and not at the ends of an integration's steps."""
    thrust, times = fired(0), FINE * np.arange(FINER * COUNT)
    fine = turned_by_held(times, FIRST, TRUE_INERTIA, np.repeat(thrust @ PER_THRUST_B, FINER, axis=0))
    run = replace(telemetry(thrust, fine), gyro_time=times, held_inertia=TRUE_INERTIA)
    predicted = simulate(drive_of(run), TRUE_THETA, TRUE_INERTIA @ FIRST)
    np.testing.assert_allclose(predicted.body_rate, fine, atol=1e-7)  # rad/s, of 0.1 rad/s


@pytest.mark.parametrize("name", ["ls", "iv"])
def test_corners_need_an_inertia_near_the_true_one(name):
    thrust = fired(0)
    run = telemetry(thrust, turned(thrust, TRUE_INERTIA))
    smooth, rough, near = (
        np.abs(ESTIMATORS[name](each, SETTINGS).theta - TRUE_THETA).max()
        for each in (run, replace(run, held_inertia=1.1 * TRUE_INERTIA), replace(run, held_inertia=1.01 * TRUE_INERTIA))
    )
    assert near < 0.15 * rough < 0.15 * 0.15 * smooth


@pytest.mark.parametrize("name", ["iv", "iv_momentum", "output_error"])
def test_the_covariance_is_that_of_the_scatter(name):
    """The attitude, by which torques are turned, is the integral of the noisy gyro."""
    thrust, noise = fired(3), 20.0 * SIGMA
    run = replace(telemetry(thrust, turned(thrust, TRUE_INERTIA)), held_inertia=TRUE_INERTIA, gyro_noise=noise)
    draws = noise * np.random.default_rng(5).standard_normal((60, COUNT, 3))
    estimates = [ESTIMATORS[name](replace(run, body_rate=run.body_rate + draw), SETTINGS) for draw in draws]
    stated = np.mean([np.diag(each.covariance) for each in estimates], axis=0)
    scatter = np.mean([(each.theta - TRUE_THETA) ** 2 for each in estimates], axis=0)
    np.testing.assert_allclose(np.mean(scatter / stated), 1.0, atol=0.3)  # three standard deviations of 60 draws


def test_even_commands_have_a_period_each_and_a_lost_one_leaves_a_gap():
    time = np.delete(np.arange(20) * PERIOD, 7)
    periods = held_periods(time, time)
    np.testing.assert_allclose(periods.middle, time + 0.5 * PERIOD)
    samples = np.arange(57.0).reshape(19, 3)
    assert periods.means(samples) is samples


def test_commands_logged_when_they_change_keep_their_impulse():
    gyro_time = 0.3 + 0.05 * np.arange(200)
    time = np.sort(np.random.default_rng(2).uniform(0.0, 9.0, 30))
    samples = np.random.default_rng(3).standard_normal((30, 3))
    periods = held_periods(time, gyro_time)
    impulse = impulse_of_held(periods.middle, periods.means(samples))
    fine = np.linspace(gyro_time[10], gyro_time[-1], 200_001)
    given = samples[np.searchsorted(time, 0.5 * (fine[1:] + fine[:-1])) - 1].sum(axis=0) * (fine[1] - fine[0])
    np.testing.assert_allclose(impulse(gyro_time[-1]) - impulse(gyro_time[10]), given, atol=1e-3)
    assert periods.middle[0] < time[time >= 0.3][0] + 0.05
    assert periods.middle[-1] > gyro_time[-1]  # the last command holds on


@pytest.mark.parametrize("time", [[1.0], [1.0, 1.5, 4.0], [60.0, 60.2, 61.0, 61.1, 64.0, 64.2]])
def test_commands_that_cover_nothing_are_no_fault_of_theirs(time):
    periods = held_periods(np.array(time), np.arange(100) * PERIOD)
    assert len(periods.means(np.zeros((len(time), 3)))) == len(periods.middle)


def test_commands_logged_when_they_change_give_the_inertia(scenario):
    """Held for 0.1 to 0.9 s, in rows of their own; taken for even ones they were 11 to 27 standard deviations off."""
    rng, tick = np.random.default_rng(4), 0.1 * PERIOD
    ticks = np.cumsum(rng.integers(10, 90, 60))
    ticks = np.append(0, ticks[ticks < COUNT * 10])
    torque = 0.5 * rng.integers(-1, 2, (len(ticks), 3))
    rows = np.union1d(np.arange(0, COUNT * 10, 10), ticks)
    acting = torque[np.searchsorted(ticks, rows, side="right") - 1]
    rates = turned_by_held(rows * tick, FIRST, TRUE_INERTIA, acting) + SIGMA * rng.standard_normal((len(rows), 3))
    channels = {
        "body_rate": np.where((rows % 10 == 0)[:, None], rates, np.nan),
        "applied_torque": np.where(np.isin(rows, ticks)[:, None], acting, np.nan),
    }
    details = RunDetails(name="logged", source="measured", gyro_noise=SIGMA)
    found = tb.estimate(scenario, tb.Records((Record(time=rows * tick, channels=channels, details=details),)))
    estimate = found.combined["output_error"]
    assert (np.abs(estimate.theta - TRUE_THETA) < 4.0 * estimate.noise_std).all()
    assert "is in doubt" not in found.verdict


def test_an_inertia_is_estimated_without_gyros(scenario):
    found = tb.estimate(scenario, tb.Records(tuple(records())))
    assert "is in doubt" not in found.verdict
    assert found.by_record["flight_0"].checks is not None
    for estimate in found.combined.values():
        missed = estimate.theta - TRUE_THETA
        assert missed @ np.linalg.solve(estimate.covariance, missed) < 22.5  # 0.1 % of χ² with six degrees of freedom
        assert (estimate.std > 3.0 * estimate.noise_std).all()  # thrusts are known to 2 % where nothing is stated


def test_the_gyros_noise_is_not_taken_from_the_corners(scenario):
    found = tb.estimate(scenario, tb.Records(tuple(records())))
    for estimation in found.by_record.values():
        assert 0.8 < estimation.checks.residual.size < 1.25


@pytest.mark.parametrize("form", ["mjcf", "urdf"])
def test_the_estimated_body_is_written_for_mujoco(scenario, tmp_path, form):
    found = tb.estimate(scenario, tb.Records(tuple(records())))
    folder, file = found.save(tmp_path / "found"), tmp_path / f"jets.{form}"
    tb.export(folder, **{form: file})
    text = file.read_text()
    if form == "urdf":  # MuJoCo would weld the root to the world
        text = text.replace("<link", '<mujoco><compiler fusestatic="false"/></mujoco><link', 1)
    model = mujoco.MjModel.from_xml_string(text)
    principal = np.sort(np.linalg.eigvalsh(inertia_of(found.combined["output_error"].theta)))
    np.testing.assert_allclose(np.sort(model.body("bus").inertia), principal, rtol=1e-12)
    assert model.body("bus").mass[0] == 100.0


def test_a_body_without_a_mass_is_not_written(scenario, tmp_path):
    massless = scenario.model_copy(update={"platform": scenario.platform.model_copy(update={"mass_kg": None})})
    found = tb.estimate(massless, tb.Records(tuple(records())))
    with pytest.raises(tb.InputError, match=r"platform.mass_kg is missing"):
        found.to_mjcf(tmp_path / "jets.xml")


def test_alignments_are_not_of_measured_records(scenario):
    asked = scenario.model_copy(update={"estimation": scenario.estimation.model_copy(update={"alignments": True})})
    found = tb.estimate(asked, tb.Records(tuple(records())))
    assert any("estimation.alignments is of flights" in notice for notice in found.identification.notices)


def sent_as(scenario, word):
    return scenario.model_copy(update={"diagnosis": type(scenario.diagnosis)(applied_torque=word)})


def test_held_torques_that_are_said_to_be_samples_are_asked_for(scenario):
    asked, right = (
        tb.estimate(each, tb.Records(tuple(records()))) for each in (sent_as(scenario, "sampled"), scenario)
    )
    assert "is in doubt" in asked.verdict or "put it in doubt" in asked.verdict
    assert any('applied_torque = "held"' in notice.text for notice in identification_notices(asked.identification))
    assert not any('"held"' in notice.text for notice in identification_notices(right.identification))


def test_held_torques_that_are_not_said_to_be_held_are_taken_so(scenario):
    found, right = (tb.estimate(each, tb.Records(tuple(records()))) for each in (sent_as(scenario, None), scenario))
    assert found.combined.keys() == right.combined.keys()
    for name, estimate in found.combined.items():
        np.testing.assert_array_equal(estimate.theta, right.combined[name].theta)
    assert HELD in found.identification.notices


def test_the_estimator_in_which_uncertain_thrusts_add_up_least_is_pointed_out(scenario):
    """Output error believes the momentum that thrusts have given since the start; the prefilter forgets it."""
    estimation = scenario.estimation.model_copy(update={"estimators": ("iv", "output_error")})
    asked = scenario.model_copy(update={"estimation": estimation})
    found = tb.estimate(asked, tb.Records(tuple(records())))
    texts = [notice.text for notice in identification_notices(found.identification)]
    (said,) = (text for text in texts if "adds up less" in text)
    assert said.startswith("Instrumental variable states")
    combined = found.combined
    assert np.prod(combined["iv"].std) < np.prod(combined["output_error"].std) / 1.5**6


@pytest.mark.parametrize("lost", [1, 4])
def test_a_lost_command_parts_a_record(scenario, lost):
    """What was commanded then is not known, and the momentum behind is another one."""
    first, *others = records()
    gone = slice(150, 150 + lost)
    torn = replace(
        first,
        time=np.delete(first.time, gone),
        channels={name: np.delete(values, gone, axis=0) for name, values in first.channels.items()},
    )
    found = tb.estimate(scenario, tb.Records((torn, *others)))
    assert {"flight_0 part 1", "flight_0 part 2"} <= set(found.by_record)
    assert "is in doubt" not in found.verdict
    estimate = found.combined["output_error"]
    assert (np.abs(estimate.theta - TRUE_THETA) < 4.0 * estimate.noise_std).all()


@pytest.mark.parametrize("known", ["thrusters", "axes"])
def test_uncertain_torques_move_the_estimate_as_predicted(known):
    thrust, share = fired(1), 1e-4
    run = telemetry(thrust, turned(thrust, TRUE_INERTIA))
    if known == "axes":
        run = replace(run, thrusters=None, thrust=None)
    estimate = ESTIMATORS["output_error"](run, SETTINGS)
    influences = {"output_error": estimate.influence}
    predicted = considered_shifts(covered_part(run), estimate.theta, Uncertainty(applied_torque=share), influences)
    assert set(predicted.kinds) == {"applied_torque"}
    scales = np.eye(6) if known == "thrusters" else np.eye(3)
    for column, scale in enumerate(1.0 - share * scales):
        torque_B = (thrust * scale) @ PER_THRUST_B if known == "thrusters" else (thrust @ PER_THRUST_B) * scale
        moved = ESTIMATORS["output_error"](replace(run, applied_torque=torque_B), SETTINGS).theta - estimate.theta
        shift = predicted.by_name["output_error"][:, column]
        np.testing.assert_allclose(moved, shift, atol=0.02 * np.abs(shift).max())


def test_a_common_factor_of_all_torques_is_one_of_the_inertia():
    thrust = fired(2)
    run = replace(telemetry(thrust, turned(thrust, TRUE_INERTIA)), thrusters=None, thrust=None)
    estimate = ESTIMATORS["output_error"](run, SETTINGS)
    influences = {"output_error": estimate.influence}
    shifts = considered_shifts(covered_part(run), estimate.theta, Uncertainty(applied_torque=0.01), influences)
    together = shifts.by_name["output_error"].sum(axis=1)
    np.testing.assert_allclose(np.abs(together), 0.01 * np.abs(TRUE_THETA), atol=2e-3 * 0.01 * TRUE_THETA.max())
