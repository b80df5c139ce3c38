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


def test_a_rig_of_one_wheel_is_diagnosed(tmp_path):
    """One wheel gives no torque about x and y, which no rig about z needs; a flown platform does."""
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
