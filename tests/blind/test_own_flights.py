"""Flights of shipped scenarios, as anybody would try first: nothing is hidden in them, and nothing gets a name.

Their telemetry is sampled five times more slowly than their commands change; that of basic and mixed has no noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import testbed as tb

FARTHEST_STD = 4.5
"""Standard errors of an entry of the inertia: beyond it by chance in one of 6,000 flights of four scenarios."""


GYROS = {"basic": {"gyro.noise_rad_s": 5e-4}}
"""The gentle profile of basic stands out of the noise that it has by hardly more than a record needs."""


def flown(name: str) -> list[tb.Run]:
    scenario = tb.read_scenario(name, GYROS.get(name))
    return [tb.fly(scenario, seed=seed) for seed in (301, 302, 303)]


def diagnosed(runs: list[tb.Run]) -> tb.DiagnosisResult:
    records = [each.record for each in runs]
    named = [replace(each, details=replace(each.details, name=f"run{n}")) for n, each in enumerate(records, start=1)]
    return tb.diagnose(runs[0].scenario, tb.Records(tuple(named)), propose=False)


@pytest.mark.parametrize("name", ["basic", "failed_cmg", "mixed", "momentum_bias"])
def test_nothing_is_missing_in_what_the_testbed_flies_itself(name):
    runs = flown(name)
    found = diagnosed(runs)
    assert found.verdict == "none"
    model = found.state.model
    error = np.abs(model.theta - runs[0].truth)
    assert np.all(error < FARTHEST_STD * np.sqrt(np.diag(model.covariance)[:6]))


def test_torques_without_noise_are_left_out_and_said_to_be():
    found = diagnosed(flown("basic"))
    assert any("gimbal_torque has less noise than its prediction resolves" in each for each in found.notices)
    assert "gimbal_coulomb_friction" in {each.effect for each in found.state.untestable}


def test_the_last_sample_of_a_command_is_what_is_asked_for_then():
    """A zero there would be a jump that nobody commanded, of which every flight of a maneuver makes the same error."""
    record = tb.fly(tb.read_scenario("mixed"), seed=301).record
    for name in ("gimbal_rate_command", "wheel_torque_command"):
        sampled = np.isfinite(record.channels[name]).all(axis=1)
        assert np.all(record.channels[name][sampled][-1] != 0.0)


def test_a_noise_that_is_stated_too_large_is_no_good_estimate():
    scenario = tb.read_scenario("momentum_bias")
    record = tb.fly(scenario, seed=301).record
    stated = [replace(record, details=replace(record.details, gyro_noise=share * 0.001658)) for share in (1.0, 3.0)]
    plain, overstated = (tb.estimate(scenario, tb.Records((each,))).verdict for each in stated)
    assert "in doubt" not in plain
    assert "1 finding below put it in doubt" in overstated
