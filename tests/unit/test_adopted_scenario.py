"""adopted.toml is what its model says, and is flown and estimated from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import testbed as tb

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
