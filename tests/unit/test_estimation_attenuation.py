"""Errors in variables: noise of the actuators' telemetry makes an inertia that is hardly turned look larger."""

from __future__ import annotations

import numpy as np
import pytest

import testbed as tb
from testbed.report.measured import identification_doubts

STILL = [[0.0, 0.0, 0.0], *([[0.015, 0.0, 0.0]] * 6), *([[0.0, 0.0, 0.0]] * 2), *([[-0.015, 0.0, 0.0]] * 6), [0.0] * 3]
"""rad/s: about x only; about y and z the wheels' noise is a seventh of the motion."""


def found_by(run):
    return run.experiment.estimation.checks.attenuation


@pytest.fixture(scope="module")
def still():
    scenario = tb.read_scenario("air_bearing", {"maneuver.body_rate_rad_s": STILL})
    maneuver = tb.design(scenario)
    return [tb.fly(scenario, maneuver, seed=seed) for seed in (1, 2, 3)]


def test_a_bias_by_the_wheels_noise_is_foretold_and_puts_the_estimate_in_doubt(still):
    """Of six flights with other seeds J22 had been 3.2 standard deviations too large in the mean, and called good."""
    for run in still:
        found = found_by(run)
        assert abs(found.axis_B[1]) > 0.9
        assert 1.5 < found.in_std < 5.0
        assert "Do not rely on it yet" in run.verdict
        assert "as chance has it" not in run.verdict
    true = run.scenario.truth.inertia_kg_m2[1][1]
    errors = [
        (estimate.theta[1] - true) / np.sqrt(estimate.covariance[1, 1])
        for estimate in (run.estimates["output_error"] for run in still)
    ]
    assert np.mean(errors) == pytest.approx(np.mean([found_by(run).in_std for run in still]), abs=1.5)


def test_measured_records_are_doubted_likewise(still):
    scenario = tb.read_scenario("air_bearing", {"diagnosis.accept": ["inertia"]})
    estimate = tb.estimate(scenario, tb.Records((still[0].record,)))
    assert "Noise of the actuators' telemetry" in " ".join(identification_doubts(estimate.identification))


@pytest.mark.parametrize("name", ["air_bearing", "cubesat_wheels", "basic"])
def test_maneuvers_that_turn_the_platform_are_not_doubted(name):
    assert found_by(tb.fly(tb.read_scenario(name), seed=1)).in_std < 0.1
