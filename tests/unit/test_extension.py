"""A nominal model with effects in it, whatever sections its scenario has."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from testbed.assembly.extension import write_extended
from testbed.assembly.platform import nominal_platform
from testbed.effects.registry import EFFECTS
from testbed.scenario.reader import read_scenario

SHIPPED = Path(__file__).parents[2] / "scenarios" / "cubesat_wheels.toml"


@pytest.mark.parametrize("sections", [(), ("estimation",), ("estimation", "truth")], ids=str)
def test_what_changes_the_truth_needs_no_other_section(tmp_path, sections):
    tree = tomllib.loads(SHIPPED.read_text(encoding="utf-8"))
    for section in sections:
        tree.pop(section, None)
    path = tmp_path / "own.toml"
    path.write_text(tomli_w.dumps(tree), encoding="utf-8")
    scenario = read_scenario(path)
    extension = EFFECTS["wheel_viscous_friction"].extension("wheel3", np.array([1e-6]), scenario)
    inertia = nominal_platform(scenario).inertia
    extended = read_scenario(write_extended(scenario, [extension], inertia, tmp_path / "extended"))
    assert extended.estimation.initial_momentum == "estimated"
    hidden, flown = extension.scenario["truth"], extended.truth.model_dump()
    assert hidden
    assert {key: flown[key] for key in hidden} == {key: tuple(values) for key, values in hidden.items()}
