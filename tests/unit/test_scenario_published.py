"""What is published for people and editors says what the models say."""

import re
from pathlib import Path

import pytest

from testbed.scenario.keys import DISCRIMINATORS
from testbed.scenario.published import published
from testbed.scenario.schema import scenario_schema, schema_text
from testbed.scenario.tables import UNITS, unit_of

DOCS = Path(__file__).parents[2] / "docs"
PURE_NUMBERS = {
    "noise_correlation",
    "noise_uncertainty",
    "null_prior_odds",
    "axis",
    "gimbal_axis",
    "spin_axis",
    "wheel_spin_inertia_factor",
    "wheel_torque_factor",
    "attitude_quat_NB",
    "coefficient",
    "cluster_torque_fraction",
    "wheel_torque_fraction",
    "wheel_momentum_fraction",
    "control_points",
    "damping",
    "decay",
    "direction",
    "dither",
    "inertia_uncertainty",
    "envelope_fraction",
    "failed",
    "gimbal_rate_fraction",
    "gimbal_servo_damping_ratio",
    "gravity_gradient_factor",
    "gyro_scale_factor",
    "min_singularity_measure",
    "applied_torque_relative",
    "rotor_momentum_relative",
    "scale",
    "scale_factor_error",
    "schema",
    "seed",
    "starts",
    "units",
    "unmodelled_prior_odds",
}


def tables(schema):
    return [schema, *(part for part in schema["$defs"].values() if "properties" in part)]


def numeric(node):
    parts = [*node.get("oneOf", ()), *node.get("prefixItems", ()), *([node["items"]] if "items" in node else ())]
    return node.get("type") in ("number", "integer") or any(numeric(part) for part in parts)


@pytest.mark.parametrize("path", published(DOCS), ids=lambda path: path.name)
def test_is_current(path):
    """If this fails: python -m testbed.scenario.published."""
    assert path.read_text(encoding="utf-8") == published(DOCS)[path]


def test_every_key_is_described():
    for table in tables(scenario_schema()):
        assert table["description"]
        for key, node in table["properties"].items():
            assert node["description"].endswith("."), key


def test_every_number_says_its_unit_or_is_known_to_have_none():
    keys = {key for table in tables(scenario_schema()) for key, node in table["properties"].items() if numeric(node)}
    assert {key for key in keys if not unit_of(key)} == PURE_NUMBERS


def test_a_unit_is_not_mistaken_for_its_ending():
    """A key that ends in N_m_s also ends in m_s and in s: the longest unit has to be tried first."""
    for end, unit in UNITS.items():
        assert unit_of(f"key{end}") == unit


def test_every_key_stands_in_the_page():
    page = (DOCS / "scenarios.md").read_text(encoding="utf-8")
    rows = set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))
    keys = {key for table in tables(scenario_schema()) for key in table["properties"]}
    assert rows == keys - set(DISCRIMINATORS)


def test_schema_has_no_null():
    """TOML has none: a key that may be absent is just not required."""
    assert '"null"' not in schema_text()
    assert ": null" not in schema_text()
