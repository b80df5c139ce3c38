"""Maneuvers that wheels cannot follow, however momentum is shared among them."""

from __future__ import annotations

import re

import numpy as np
import pytest
import scipy.optimize

import testbed as tb
from testbed.assembly.platform import initial_momentum, nominal_platform
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.scenario.shipped import shipped_scenario

BODY_RATE = """[maneuver]
kind = "design"
parametrization = "body_rate"
constraint = "hard"
criterion = "A"
metric = "momentum"
duration_s = 60.0
control_points = 12
starts = 1
seed = 3
sample_rate_hz = 10.0
prefilter_time_constant_s = 2.0
envelope_fraction = 0.9

[simulation]"""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The CubeSat, with a design of the body rate inside the limits of each axis by itself."""
    text = shipped_scenario("cubesat_wheels").read_text(encoding="utf-8")
    changed = re.sub(r"\[maneuver\].*?\[simulation\]", BODY_RATE, text, flags=re.DOTALL)
    file = tmp_path_factory.mktemp("scenario") / "cubesat_wheels.toml"
    file.write_text(changed, encoding="utf-8")
    return file


def least_share(wheels, momentum_B):
    """Return the least share of its limit that the most loaded wheel can have, by a linear program."""
    limited = np.concatenate([np.eye(len(wheels.axis_B)), -np.eye(len(wheels.axis_B))])
    bounds = np.concatenate([limited, -np.tile(wheels.momentum_limit, 2)[:, None]], axis=1)
    cost = np.append(np.zeros(len(wheels.axis_B)), 1.0)
    equal = np.concatenate([wheels.axis_B.T, np.zeros((3, 1))], axis=1)
    return scipy.optimize.linprog(
        cost, bounds, np.zeros(len(bounds)), equal, momentum_B, [(None, None)] * len(cost)
    ).fun


def test_a_design_of_the_body_rate_says_that_wheels_cannot_follow_it(path):
    scenario = tb.read_scenario(path)
    maneuver = tb.design(scenario)
    (notice,) = maneuver.notices
    percent, instant = map(float, re.match(r"the maneuver needs (\d+) % .* at ([\d.]+) s", notice).groups())
    nominal = nominal_platform(scenario)
    assert np.allclose(initial_momentum(scenario, nominal), 0.0)  # so that the attitude does not count
    rate = maneuver.plan.maneuver.reference(np.array([instant])).body_rate[0]
    share = least_share(nominal.wheels, -nominal.turned_inertia @ rate)
    assert abs(100.0 * share - percent) < 1.0
    assert share > 1.1


def test_of_a_maneuver_that_they_can_follow_it_says_nothing():
    scenario = tb.read_scenario("cubesat_wheels")
    assert tb.design(scenario).notices == ()


def test_the_command_prints_it(path, tmp_path, capsys):
    assert exit_code_of(lambda: app(["design", str(path), "--out", str(tmp_path / "out")])) == 0
    assert "so that they cannot follow it" in " ".join("".join(capsys.readouterr()).split())
