"""Torques by formulas on the flown platform: what no step can follow is refused, and what runs away ends the flight."""

from __future__ import annotations

import pytest

import testbed as tb
from testbed.errors import InputError

ORBIT = {"environment.kind": "orbit", "environment.altitude_m": 4e5}


def with_torque(tmp_path, formula, coefficient=1e-4):
    path = tmp_path / "torque.toml"
    text = tb.read_scenario("basic").file.text
    path.write_text(
        f'{text}\n[[truth.torque]]\nformula = "{formula}"\naxis = "z"\ncoefficient = {coefficient}\n', encoding="utf-8"
    )
    return tb.read_scenario(path)


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("lag(w_x, 1e-9)", r"has a lag of 1e-09 s, too short for steps of 0\.00125 s; above 0\.000449 s"),
        ("delay(w_x, 0.001)", r"has a delay of 0\.001 s, too short for steps of 0\.00125 s; above 0\.00155 s"),
    ],
)
def test_a_memory_too_short_for_the_step_is_refused(tmp_path, formula, words):
    with pytest.raises(InputError, match=words):
        with_torque(tmp_path, formula)


@pytest.mark.parametrize("formula", ["lag(w_x, 0.00046)", "delay(w_x, 0.0016)", "hysteresis(w_x, 1e-3)"])
def test_the_shortest_memory_that_is_taken_is_integrated(tmp_path, formula):
    assert tb.fly(with_torque(tmp_path, formula), seed=1).experiment.outcome == "completed"


def test_a_torque_that_runs_away_ends_the_flight_with_what_was_recorded(tmp_path):
    run = tb.fly(with_torque(tmp_path, "w_z", 1e5), seed=1)
    assert run.experiment.outcome == "diverged"
    assert len(run.record.time)


def test_so_does_one_of_an_orbit():
    run = tb.fly(tb.read_scenario("basic", {**ORBIT, "environment.torque_N_m": [1e6, 1e6, 1e6]}), seed=1)
    assert run.experiment.outcome == "diverged"


def test_a_gyro_that_shows_nothing_of_the_motion_leaves_the_flight():
    """Its estimates are none, for reasons that are kept; the flight had been lost with an error on units."""
    run = tb.fly(tb.read_scenario("basic", {"gyro.bias_rad_s": [1e4, 0.0, 0.0]}), seed=1)
    assert run.experiment.outcome == "completed"
    assert not run.estimates
    assert "no estimator gave an estimate" in str(run)


def test_without_noise_no_distance_to_a_bound_is_stated():
    assert "inf" not in str(tb.fly(tb.read_scenario("basic", {"gyro.noise_rad_s": 0.0}), seed=1))
