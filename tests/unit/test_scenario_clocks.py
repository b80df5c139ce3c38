"""Clocks that divide, clocks that do not, and where a key stands in a file."""

from fractions import Fraction

import pytest

from testbed.scenario.clocks import (
    duration_conflicts,
    exact,
    nearest_steps,
    order_conflicts,
    rate_conflicts,
    step_conflicts,
)
from testbed.scenario.places import key_lines, line_of

SHIPPED = {"gyro.sample_rate_hz": 16.0, "simulation.control_rate_hz": 80.0, "simulation.telemetry_rate_hz": 16.0}


@pytest.mark.parametrize(
    ("value", "ratio"),
    [
        (0.00125, Fraction(1, 800)),
        (0.1, Fraction(1, 10)),
        (1 / 60, Fraction(1, 60)),
        (16.0, Fraction(16)),
        (1e-7, Fraction(1, 10**7)),
        (0.016667, Fraction(16667, 10**6)),
    ],
)
def test_exact_is_what_was_written(value, ratio):
    assert exact(value) == ratio


@pytest.mark.parametrize("step", [0.00125, 0.000625, 0.0005, 0.0125])
def test_steps_that_a_16_hz_gyro_and_an_80_hz_loop_bear(step):
    assert not list(step_conflicts(step, SHIPPED))


@pytest.mark.parametrize("step", [0.001, 0.002, 0.0013, 0.025, 0.00125001])
def test_steps_that_they_do_not_bear(step):
    """int(1 / 16 / 0.001) would accept 0.001 s and drift by half a step per sample."""
    assert [conflict.key for conflict in step_conflicts(step, SHIPPED)] == ["simulation.step_s"]


def test_a_step_of_a_third_is_no_rounding_matter():
    """30 Hz and a step written as a repeating decimal: exact only when read as the ratio that was meant."""
    assert not list(step_conflicts(0.0033333333333333335, {"rate": 30.0}))
    assert list(step_conflicts(0.003333, {"rate": 30.0}))


def test_rates_divide_each_other():
    assert not list(rate_conflicts(SHIPPED))
    assert [conflict.key for conflict in rate_conflicts({"slow": 16.0, "fast": 40.0})] == ["fast"]
    assert not list(rate_conflicts({"slow": 0.5, "fast": 40.0}))


def test_the_loop_is_the_fastest_clock():
    assert not list(order_conflicts(SHIPPED, "simulation.control_rate_hz"))
    conflicts = order_conflicts(SHIPPED | {"gyro.sample_rate_hz": 160.0}, "simulation.control_rate_hz")
    assert [conflict.key for conflict in conflicts] == ["simulation.control_rate_hz"]


def test_duration_is_whole_control_periods():
    assert not list(duration_conflicts(5.0, 80.0))
    assert "use 0.0125" in next(duration_conflicts(0.001, 80.0)).text


def test_nearest_steps_are_those_a_person_would_write():
    assert nearest_steps(0.001, SHIPPED) == [0.00125, 0.00078125]
    assert nearest_steps(1.0, {"rate": 16.0}) == [0.0625]


TEXT = '''# comment
name = "x"
description = """
seed = 1
[gyro]
"""
[platform]  # with a comment
inertia = [
  [1.0],
  # [gyro]
]
mass.kg = 4

[a.b]
seed = 1

[[wheels]]
axis = 1

[[wheels]]
mass = 2
axis = 3

[wheels.bearing]
friction = 4

[[wheels.bearing.balls]]
mass = 5
'''


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (("name",), 2),
        (("description",), 3),
        (("platform",), 7),
        (("platform", "inertia"), 8),
        (("platform", "inertia", 0, 0), 8),
        (("platform", "mass", "kg"), 12),
        (("platform", "missing"), 7),
        (("a", "b"), 14),
        (("a", "b", "seed"), 15),
        (("wheels",), 17),
        (("wheels", 0), 17),
        (("wheels", 0, "axis"), 18),
        (("wheels", 0, "mass"), 17),
        (("wheels", 1), 20),
        (("wheels", 1, "axis"), 22),
        (("wheels", 1, "bearing", "friction"), 25),
        (("wheels", 1, "bearing", "balls", 0, "mass"), 28),
        (("wheels", 2), 17),
        (("gyro", "noise"), None),
        (("seed",), None),
    ],
)
def test_line_of_a_key(place, line):
    """Strings and arrays over several lines contain what looks like keys and tables, and are neither."""
    assert line_of(place, key_lines(TEXT)) == line
