"""A platform with gyros or wheels that is only measured: its scenario needs no maneuver, controller or simulation."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from textwrap import dedent

import mujoco
import numpy as np
import pytest
import tomli_w

import testbed as tb
from support.few_effects import know_only
from support.thrusters import body_scenario
from testbed.assembly.platform import nominal_body
from testbed.assembly.telemetry import telemetry_of
from testbed.errors import InputError
from testbed.library.scenarios import require_flyable
from testbed.records.record import Record, RunDetails
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario

OF_A_FLIGHT = Scenario.model_fields.keys() - BodyScenario.model_fields.keys()
GUIDE = (Path(__file__).parents[2] / "docs" / "how-to" / "own-data.md").read_text(encoding="utf-8")
RIG = dedent(GUIDE.split("```toml")[1].split("```")[0])
"""The guide's rig of one wheel."""


def measured_only(name):
    """A shipped scenario as one of a platform that is only measured; and itself with the same estimators."""
    text = tb.read_scenario(name).file.text
    tree = tomllib.loads(text)
    tree["estimation"] = {"estimators": ["iv_momentum", "output_error"], "initial_momentum": "estimated"}
    flown = body_scenario(tomli_w.dumps(tree), f"{name}.toml")
    bare = {key: value for key, value in tree.items() if key not in OF_A_FLIGHT}
    return flown, body_scenario(tomli_w.dumps(bare), "measured.toml")


@pytest.mark.parametrize("name", ["gimbal_d_optimal", "mixed", "cubesat_wheels"])
def test_records_are_estimated_as_with_the_scenario_of_a_flight(name):
    flown, measured = measured_only(name)
    assert isinstance(flown, Scenario)
    assert not isinstance(measured, Scenario)
    assert measured.stores_momentum
    record = tb.fly(require_flyable(flown), seed=5).record
    details = replace(record.details, source="measured")
    records = tb.Records((replace(record, details=details),))
    ours, theirs = (tb.estimate(scenario, records) for scenario in (measured, flown))
    for estimator, estimate in theirs.combined.items():
        np.testing.assert_array_equal(ours.combined[estimator].theta, estimate.theta)
        np.testing.assert_array_equal(ours.combined[estimator].covariance, estimate.covariance)


@pytest.mark.parametrize(("stated", "period"), [(None, 0.1), (25.0, 1.0 / 30.0), (3.0, 0.1)])
def test_the_scenario_states_how_fast_the_controller_commands(stated, period):
    """Wheels' commands of a flight whose telemetry is sampled at 10 Hz."""
    _, measured = measured_only("cubesat_wheels")
    time = np.arange(20) / 10.0
    wheels = np.zeros((20, 4))
    channels = {"body_rate": np.zeros((20, 3)), "wheel_speed": wheels, "wheel_torque_command": wheels}
    details = RunDetails(name="flight")
    scenario = measured.model_copy(
        update={"diagnosis": measured.diagnosis.model_copy(update={"control_rate_hz": stated})}
    )
    telemetry = telemetry_of(Record(time=time, channels=channels, details=details), scenario, nominal_body(scenario))
    assert telemetry.wheels.motors.period == pytest.approx(period)


def commanded(time, rows, command, stated=None):
    """What is known of a wheel whose speed is sampled at all times, and its command in some rows."""
    scenario = body_scenario(
        RIG + ("" if stated is None else f"\n[diagnosis]\ncontrol_rate_hz = {stated}\n"), "rig.toml"
    )
    torque = np.full((len(time), 1), np.nan)
    torque[rows, 0] = command
    rate = np.sin(time)[:, None] * [np.nan, np.nan, 1.0]
    channels = {"body_rate": rate, "wheel_speed": np.zeros((len(time), 1)), "wheel_torque_command": torque}
    record = Record(time=time, channels=channels, details=RunDetails(name="flight"))
    wheels = telemetry_of(record, scenario, nominal_body(scenario)).wheels
    return wheels.torque_command[:, 0], wheels.motors.period


def test_a_command_that_is_recorded_where_it_changes_holds_until_then():
    """A healthy rig's motor seemed to be late by half of an interval between speeds, as commands went on lines."""
    time = np.arange(20) / 20.0
    torque, period = commanded(time, [0, 4, 6, 15], [1e-3, 2e-3, -1e-3, 5e-4])
    np.testing.assert_allclose(torque, np.repeat([1e-3, 2e-3, -1e-3, 5e-4], [4, 2, 9, 5]), rtol=1e-12)
    assert period == pytest.approx(0.05)


def test_commands_between_speeds_count_by_their_mean():
    """Rows of the gyro at 40 Hz, speeds at 20 Hz, and a command that changes in a row between two of them."""
    record_time = np.arange(40) / 40.0
    speed, torque = np.full((40, 1), np.nan), np.full((40, 1), np.nan)
    speed[::2] = 0.0
    torque[[0, 7], 0] = 1e-3, 3e-3
    rate = np.sin(record_time)[:, None] * [np.nan, np.nan, 1.0]
    channels = {"body_rate": rate, "wheel_speed": speed, "wheel_torque_command": torque}
    scenario = body_scenario(RIG, "rig.toml")
    record = Record(time=record_time, channels=channels, details=RunDetails(name="flight"))
    wheels = telemetry_of(record, scenario, nominal_body(scenario)).wheels
    np.testing.assert_allclose(wheels.torque_command[:, 0], [1e-3] * 3 + [2e-3] + [3e-3] * 16, rtol=1e-12)


def test_a_command_of_several_goes_on_lines():
    """One row in four of what a controller commands at 20 Hz."""
    time, rows = np.arange(20) / 20.0, [0, 4, 8, 12, 16]
    torque, period = commanded(time, rows, np.arange(5) * 1e-3, stated=20.0)
    np.testing.assert_allclose(torque[:17], time[:17] * 5e-3, atol=1e-12)
    assert period == pytest.approx(0.05)


def test_what_needs_a_flight_says_which_sections_it_needs(tmp_path):
    _, measured = measured_only("cubesat_wheels")
    with pytest.raises(InputError, match=r"has none of \[controller\], \[limits\], \[maneuver\], \[simulation\]"):
        tb.fly(measured)
    path = tmp_path / "half.toml"
    path.write_text(measured.file.text + "\n[simulation]\nstep_s = 0.001\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"controller: is missing"):
        tb.read_scenario(path)


def test_without_a_stated_inertia_no_model_gives_one():
    tree = tomllib.loads(RIG)
    del tree["platform"]["inertia_kg_m2"]
    scenario = body_scenario(tomli_w.dumps(tree), "rig.toml")
    with pytest.raises(InputError, match=r"platform\.inertia_kg_m2 is missing"):
        tb.estimate(scenario, tb.Records((rig_run(1),)))


def rig_run(seed: int, inertia: float = 0.055, drag: float = 3e-3) -> Record:
    """A table of another inertia with drag, J w' = -h' - c w, where h' = a cos(bt + p): solved in closed form."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 20.0, 0.05)
    momentum, rate, phase = 0.015, 0.7, 1.3 * seed
    forced = -momentum * rate / np.hypot(drag, inertia * rate)
    lag = np.arctan2(inertia * rate, drag)
    body = forced * (np.cos(rate * time + phase - lag) - np.cos(phase - lag) * np.exp(-drag / inertia * time))
    rates = np.full((len(time), 3), np.nan)
    rates[:, 2] = body + rng.normal(0.0, 1e-3, len(time))
    speed = momentum * np.sin(rate * time + phase) / 1e-4
    return Record(
        time=time,
        channels={"body_rate": rates, "wheel_speed": speed[:, None]},
        details=RunDetails(name=f"run{seed}", gyro_noise=1e-3),
    )


def test_a_rig_of_one_wheel_is_diagnosed(tmp_path, monkeypatch):
    """One wheel gives no torque about x and y, which no rig about z needs; a flown platform does."""
    know_only(monkeypatch, "viscous_drag", "quadratic_drag", "dry_friction", "wheel_inertia", "gyro_latency")
    scenario = body_scenario(RIG, "rig.toml")
    diagnosis = tb.diagnose(scenario, tb.Records(tuple(rig_run(seed) for seed in range(1, 6))))
    assert diagnosis.state.model.placed[0].effect.id == "viscous_drag"
    fit = diagnosis.state.model
    assert fit.theta[2] == pytest.approx(0.055, abs=4.0 * np.sqrt(fit.covariance[2, 2]))
    diagnosis.save(tmp_path / "out")
    said = (tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8")
    assert "a platform that is only measured is not flown" in said


def test_the_estimated_platform_is_written_with_its_actuators(tmp_path):
    _, measured = measured_only("cubesat_wheels")
    record = tb.fly(tb.read_scenario("cubesat_wheels"), seed=3).record
    path = tb.estimate(measured, tb.Records((record,))).to_mjcf(tmp_path / "craft.xml")
    model = mujoco.MjModel.from_xml_path(str(path))
    assert sum("wheel" in model.joint(index).name for index in range(model.njnt)) == 4


def test_wheels_that_the_record_lacks_are_refused_by_name():
    _, measured = measured_only("cubesat_wheels")
    of_one = measured.model_copy(update={"platform": body_scenario(RIG, "rig.toml").platform})
    with pytest.raises(InputError, match="add wheel_speed_2_rad_s, wheel_speed_3_rad_s, wheel_speed_4_rad_s"):
        tb.diagnose(of_one, tb.Records((rig_run(1),)))
