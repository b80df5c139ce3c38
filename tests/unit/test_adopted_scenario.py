"""adopted.toml is what its model says; its flights are estimated from and diagnosed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import testbed as tb
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.findings import additions
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS

MODEL = Path(__file__).resolve().parents[2] / "models" / "smallsat.xml"


@pytest.fixture(scope="module")
def scenario():
    return tb.read_scenario("adopted")


def test_platform_and_wheels_are_those_of_the_model(scenario):
    adopted = tb.adopt(MODEL)
    assert scenario.platform == adopted.scenario.platform
    limits = {"momentum_limit_N_m_s"}  # not in the model
    ours, theirs = (
        [entry.model_dump(exclude=limits) for entry in each.actuators] for each in (scenario, adopted.scenario)
    )
    assert ours == theirs


def test_it_moves_as_the_model_under_the_same_torques():
    worst = tb.adopt(MODEL).difference
    print(f"adopted: body rate against the model's own {worst:.1e} rad/s over 10 s")
    assert worst <= 1e-8


def test_what_was_flown_is_estimated(scenario):
    run = tb.fly(scenario, seed=3)
    assert run.result["limits"]["saturated_s"] == 0.0
    estimate = run.estimates["output_error"]
    error = np.abs(estimate.theta - run.truth)
    assert np.all(error < 4.0 * estimate.noise_std)
    assert np.all(4.0 * estimate.noise_std < 0.01 * run.truth[:3].min())


SHORT = {
    "maneuver.duration_s": 30.0,
    "simulation.duration_s": 30.0,
    "gyro.sample_rate_hz": 2.5,
    "simulation.telemetry_rate_hz": 2.5,
}
"""A quarter of the time, at half the rates, so that the wheels can."""
ASKED = ("gyro_latency", "gyro_scale", "viscous_drag", "wheel_inertia", "wheel_misalignment")


def test_a_late_gyro_is_named(scenario):
    """The residual that remains is looked through after that, which takes a minute and is not waited for."""
    points = (0.5 * np.array(scenario.maneuver.body_rate_rad_s)).tolist()
    changes = SHORT | {"maneuver.body_rate_rad_s": points}
    nominal, late = tb.read_scenario("adopted", changes), tb.read_scenario("adopted", changes | {"gyro.latency_s": 0.1})
    platform = nominal_body(nominal)
    data = data_set_of([tb.fly(late, seed=seed).record for seed in (21, 22)], nominal, platform)
    effects = {name: EFFECTS[name] for name in ASKED}
    states = diagnosed(data.runs, data.heldout, effects, theta_of(platform.inertia))
    first = next(added for added in map(additions, states) if added)[0]
    assert first.effect.id == "gyro_latency"
    (latency,) = first.quantities
    assert latency.value == pytest.approx(0.1, abs=0.01)
