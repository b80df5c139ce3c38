"""[[actuators]]: what a file may say of reaction wheels, and what is refused with its remedy."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from testbed.errors import InputError
from testbed.scenario.reader import read_scenario

SHIPPED = tomllib.loads((Path(__file__).parents[2] / "scenarios" / "cubesat_wheels.toml").read_text(encoding="utf-8"))
SINGLE = {key: value for key, value in SHIPPED["actuators"][0].items() if key not in {"array", "units", "skew_deg"}}


def written(tmp_path, change):
    tree = deepcopy(SHIPPED)
    change(tree)
    path = tmp_path / "scenario.toml"
    path.write_text(tomli_w.dumps(tree), encoding="utf-8")
    return path


def single(axis, **more):
    return SINGLE | {"axis": axis} | more


def test_arrays_and_single_wheels_are_numbered_in_the_order_of_the_file(tmp_path):
    def change(tree):
        tree["actuators"].append(single([0.0, 0.6, 0.8], position_m=[0.0, 0.0, 0.1]))
        tree["initial"]["wheel_momentum_N_m_s"] = [0.0] * 5

    actuators = read_scenario(written(tmp_path, change)).actuators
    assert [each.wheels for each in actuators] == [4, 1]
    np.testing.assert_array_equal(actuators[1].axes_B, [[0.0, 0.6, 0.8]])
    np.testing.assert_array_equal(actuators[1].positions_B, [[0.0, 0.0, 0.1]])
    np.testing.assert_allclose(np.linalg.norm(actuators[0].positions_B, axis=1), 0.03)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda tree: tree.update(actuators=[single([1.0, 1.0, 0.0])]), "axis: has the length 1.41421 instead of 1"),
        (lambda tree: tree.update(actuators=[single([0.0, 0.0, 0.0])]), "axis: is zero, which has no direction; give"),
        (
            lambda tree: tree.update(actuators=[single([1.0, 0.0, 0.0]), single([0.0, 1.0, 0.0])]),
            r"actuators: give no torque about \[0, 0, 1\] in body axes",
        ),
        (
            lambda tree: tree["initial"].update(wheel_momentum_N_m_s=[0.0, 0.02, 0.0, 0.0]),
            r"wheel_momentum_N_m_s: is 0.02 for wheel 2, beyond its momentum_limit_N_m_s = 0.01",
        ),
        (
            lambda tree: tree["initial"].update(wheel_momentum_N_m_s=[0.0] * 3),
            "wheel_momentum_N_m_s: has 3 entries instead of 4, one for each wheel",
        ),
        (lambda tree: tree["actuators"][0].update(axis=[0.0, 0.0, 1.0]), "array: and axis: state one of them"),
        (lambda tree: tree["actuators"][0].pop("skew_deg"), "skew_deg: is missing; add it"),
        (lambda tree: tree["actuators"][0].update(array="tetrahedron", units=5), "has 4 wheels; omit it"),
        (lambda tree: tree["actuators"][0].update(transverse_inertia_kg_m2=1e-6), "no rigid rotor has that"),
        (lambda tree: tree["actuators"][0].update(kind="thruster"), "actuators.*kind"),
        (lambda tree: tree["actuators"][0].update(skeww=1), "skeww"),
        (lambda tree: tree.update(actuators=[]), r"cluster: is missing; add it: .* or \[\[actuators\]\]"),
        (
            lambda tree: (
                tree["estimation"].update(initial_momentum="zero")
                or tree["initial"].update(wheel_momentum_N_m_s=[0.002] * 4)
            ),
            'initial_momentum: is "zero", but the flight starts with momentum of 0.00462',
        ),
    ],
)
def test_what_goes_not_together_is_refused_with_its_place(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        read_scenario(written(tmp_path, change))
