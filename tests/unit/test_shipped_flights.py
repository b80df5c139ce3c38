"""The real flights that the project ships are taken as they are."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from benchmarks.crazypad import Kept, diagnosed
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.control_loop import acts_steadily, with_mean_thrust
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.reference import without_trims_by_name
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.shipped import shipped_scenario

DATA = Path(__file__).resolve().parents[2] / "data" / "crazypad"
SCENARIO = read_body_scenario(shipped_scenario("crazypad"))
FOLDERS = sorted(each.name for each in DATA.iterdir() if each.is_dir())


@cache
def runs_of_flights(folder="normal"):
    return data_set_of(read_data_set(DATA / folder), SCENARIO, nominal_body(SCENARIO)).runs


@pytest.mark.parametrize("folder", FOLDERS)
def test_flights_of_a_quadcopter_that_hardly_moves_are_in_the_units_that_they_state(folder):
    """Windows of half a second without motion were taken for a torque in mN·m, and the whole folder was refused."""
    assert np.isfinite(runs_of_flights(folder).sigma).all()


@pytest.fixture(scope="module")
def kept():
    return Kept()


def test_healthy_flights_show_nothing_that_other_healthy_flights_do_not(kept):
    result = diagnosed("normal", kept)
    assert result.verdict == "none"
    assert result.steps == ()


def test_a_weight_beside_the_centre_is_an_offset_of_the_thrust_towards_it(kept):
    """It was called a motor 23 % too strong: so it is in what the controller makes of draughts, not in mean torques."""
    result = diagnosed("weight_between_motors_3_4", kept)
    (step,) = result.steps
    offset = {each.name: each.value for each in step.quantities}
    assert repr(step).startswith("thrust_offset:platform")
    assert offset["offset_y_m"] > 0.001 > abs(offset["offset_x_m"])


def test_a_cut_propeller_is_a_weak_motor(kept):
    result = diagnosed("propeller_3_cut_3_mm", kept)
    (step,) = result.steps
    assert repr(step).startswith("actuator_weak:3")
    assert 0.1 < step.quantities[0].value < 0.5


def test_in_a_loop_what_acts_on_changes_alone_is_not_tested_for():
    grid = runs_of_flights().grid
    steady = {effect.id for effect in EFFECTS.values() if not effect.environment and acts_steadily(effect, grid)}
    assert steady >= {"actuator_weak", "actuator_misaligned", "thrust_offset", "body_torque", "gyro_drift"}
    assert steady.isdisjoint(
        {"actuator_lag", "actuator_delay", "rotor_acceleration_reaction", "telemetry_skew", "gyro_scale", "gyro_bias"}
        | {"gyro_latency", "viscous_drag", "quadratic_drag", "slosh", "contact", "dry_friction"}
    )


def test_in_a_loop_a_motors_constant_torque_is_left_to_the_trims():
    """Taken over as 0.0016 ± 1, a healthy motor's share explained 15 % that it lost later."""
    runs = with_mean_thrust(runs_of_flights())
    scenario_theta = theta_of(nominal_body(SCENARIO).inertia)
    weak = Hypothesis(effect=EFFECTS["actuator_weak"], component="3")
    delay = Hypothesis(effect=EFFECTS["actuator_delay"], component="actuators")
    model = fitted(runs, [delay, weak], scenario_theta, [np.array([0.03]), np.array([0.0016])])
    assert without_trims_by_name(runs, model).placed == (delay,)


def test_in_a_loop_each_motor_has_its_mean_thrust_and_all_have_the_torque_that_they_had():
    runs = runs_of_flights()
    steady = with_mean_thrust(runs)
    assert np.array_equal(steady.grid.applied_torque_B, runs.grid.applied_torque_B)
    for number in range(len(runs.record_names)):
        own = runs.record_of == number
        means = steady.grid.thrust[own].reshape(-1, 4)
        windows = np.concatenate([run.thrust for run, mine in zip(runs.grid.runs, own, strict=True) if mine])
        assert np.allclose(means, windows.mean(axis=0), rtol=1e-12)
    assert all(np.ptp(run.thrust, axis=0).max() == 0.0 for run in steady.grid.runs)
