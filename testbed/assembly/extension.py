"""A scenario and its platform with effects built in, as files that fly as they stand."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import tomli_w

from testbed.arrays import Matrix3
from testbed.assembly.platform import nominal_properties
from testbed.effects.contract import Extension
from testbed.files import whole_file
from testbed.plant.extended import extended_platform
from testbed.scenario.body import scenario_keys
from testbed.scenario.maneuver import CsvManeuver
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario

Keys: TypeAlias = dict[str, Any]
"""A scenario's keys as TOML has them."""

PLATFORM = "platform.xml"
SCENARIO = "scenario.toml"

_CARRIED = {
    "platform": ("inertia_kg_m2", "mass_kg", "edge_m"),
    "truth": ("inertia_kg_m2", "mass_kg"),
    "cluster": (
        "skew_deg",
        "mounting_radius_m",
        "rotor_spin_inertia_kg_m2",
        "rotor_transverse_inertia_kg_m2",
        "rotor_mass_kg",
        "gimbal_inertia_kg_m2",
        "gimbal_mass_kg",
    ),
}
"""Keys that the MJCF carries; beside it they would be written over what the effects put there."""


def write_extended(scenario: Scenario, extensions: Sequence[Extension], inertia: Matrix3, folder: Path) -> Path:
    """Write platform.xml and scenario.toml, and return the path of the scenario.

    Args:
        scenario: the nominal one.
        extensions: of the effects, in order; where two change one key the later one's value stands, so that its effect
            has to be asked with `extended` by the earlier ones.
        inertia: J of the whole platform as estimated together with the effects, kg·m², body axes.
        folder: where; made where it is missing.

    Raises:
        InputError: the platform cannot carry an addition, or the scenario with the effects is none that can be flown.
    """
    properties = replace(nominal_properties(scenario), inertia=inertia, cabin_size=None)  # the scenario keeps its cabin
    additions = [addition for extension in extensions for addition in extension.platform]
    platform = extended_platform(properties, scenario.platform.model, additions)
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / PLATFORM, platform)
    keys = _flown_keys(scenario, extensions)
    if isinstance(scenario.maneuver, CsvManeuver):
        keys["maneuver"]["file"] = Path(shutil.copy(scenario.maneuver.file, folder)).name
    question = "# What does the platform do with the effects that were found in it?\n"
    _write(folder / SCENARIO, question + tomli_w.dumps(keys))
    read_scenario(folder / SCENARIO)
    return folder / SCENARIO


def extended(scenario: Scenario, extension: Extension) -> Scenario:
    """Return a scenario with an effect's keys, for the next effect to be added to; its platform stays as it is."""
    return Scenario.model_validate(_merged(scenario_keys(scenario), extension.scenario))


def _flown_keys(scenario: Scenario, extensions: Sequence[Extension]) -> Keys:
    keys = scenario_keys(scenario)
    for section, carried in _CARRIED.items():
        for key in carried:
            keys.get(section, {}).pop(key, None)
    for extension in extensions:
        keys = _merged(keys, extension.scenario)
    return _merged(keys, {"platform": {"model": PLATFORM}})


def _merged(keys: Keys, changes: Mapping[str, Mapping[str, Any]]) -> Keys:
    """Return keys with changes; units that are not alike hold a momentum at the start, which is then estimated.

    A scenario that says nothing of estimates has it estimated by default.
    """
    merged = deepcopy(keys)
    for section, values in changes.items():
        merged.setdefault(section, {}).update(values)
    if "truth" in changes and "estimation" in merged:
        merged["estimation"]["initial_momentum"] = "estimated"
    return merged


def _write(path: Path, text: str) -> None:
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
