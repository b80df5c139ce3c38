"""Diagnoses of a table on an air bearing: the offset of its centre of mass is named, and of none nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from testbed.assembly.platform import nominal_platform, true_platform
from testbed.diagnosis.data import chosen
from testbed.diagnosis.gate import Gate, require_explicable
from testbed.diagnosis.keeping import hash_of
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.prediction.hooks import Instant
from testbed.records.selection import telemetry_only
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

FEW = {name: EFFECTS[name] for name in ("center_of_mass_offset", "body_torque")}
NOMINAL_OFFSET = [0.0, 0.0, -1e-4]


def measured(offset: list[float]):
    """Three runs of five seconds, and the inertia of the platform that is believed."""
    keys = short("air_bearing")
    keys["truth"]["center_of_mass_offset_m"] = offset
    return flown(keys)


def short(name: str):
    """The keys of a shipped scenario, of flights of five seconds."""
    shipped = read_scenario(shipped_scenario(name))
    keys = shipped.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    keys["simulation"] |= {"duration_s": 5.0, "control_rate_hz": 100.0, "telemetry_rate_hz": 100.0}
    keys["gyro"]["sample_rate_hz"] = 20.0
    return keys


def flown(keys):
    scenario = Scenario.model_validate(keys)
    nominal, true = nominal_platform(scenario), true_platform(scenario)
    maneuver = plan_maneuver(scenario, nominal).maneuver
    records = [fly_maneuver(scenario, nominal, true, maneuver, seed).record for seed in (11, 12, 13)]
    named = [replace(each, details=replace(each.details, name=f"run {at}")) for at, each in enumerate(records)]
    return data_set_of([telemetry_only(each) for each in named], scenario, nominal), theta_of(nominal.inertia)


def test_an_offset_is_named_first_with_its_size():
    offset = [2.4e-5, -1.7e-5, -4e-4]
    data, theta = measured(offset)
    *_, final = diagnosed(data.runs, data.heldout, FEW, theta)
    assert final.model.placed[0].key == "center_of_mass_offset:platform"
    own = final.model.own(final.model.placed[0])
    std = np.sqrt(np.diag(final.model.covariance))[6:][own]
    error = final.model.effect_values[own] - np.subtract(offset, NOMINAL_OFFSET)
    np.testing.assert_array_less(np.abs(error), 4.0 * std)


def test_a_single_run_that_an_offset_explains_is_of_the_platform():
    """It gets no name, so that its model keeps the whole gap: the gate looks at what was compared."""
    data, theta = measured([6e-5, -5e-5, -2e-4])
    *_, final = diagnosed(chosen(data.runs, [0]), None, FEW, theta, alone=True)
    assert final.model.placed == ()
    with pytest.raises(InputError, match="are not of the scenario's platform"):
        require_explicable(final.runs, final.gap_before.fit, final.model, Gate())
    require_explicable(final.runs, final.gap_before.fit, final.nearest, Gate())


def test_nothing_is_named_where_the_centre_of_mass_is_as_believed():
    data, theta = measured(NOMINAL_OFFSET)
    *_, final = diagnosed(data.runs, data.heldout, FEW, theta)
    assert final.model.placed == ()


def test_effects_of_another_environment_are_not_asked_for():
    data, _ = measured(NOMINAL_OFFSET)
    testable, untestable = hypotheses(data.runs, EFFECTS)
    asked = {each.effect.id for each in testable} | {each.effect for each in untestable}
    assert {"center_of_mass_offset", "air_drag"} <= asked
    assert asked.isdisjoint({"gravity_gradient", "magnetic_dipole"})


@pytest.mark.parametrize("name", ["air_bearing", "orbit_wheels"])
def test_what_is_kept_of_a_diagnosis_is_kept_by_the_content_of_its_surroundings(name):
    """They hold splines, of the attitude and the field; a hash of their addresses would never be found again."""
    keys = short(name)
    (one, _), (same, _) = flown(keys), flown(keys)
    around = one.runs.grid.runs[0].surroundings
    turns = around.attitude.turns
    turned = replace(around.attitude, turns=CubicSpline(turns.x, turns(turns.x)[::-1]))
    runs = tuple(replace(run, surroundings=replace(around, attitude=turned)) for run in one.runs.grid.runs)
    other = replace(one.runs, grid=replace(one.runs.grid, runs=runs))
    assert hash_of(one.runs) == hash_of(same.runs)
    assert hash_of(one.runs) != hash_of(other)


def test_a_torque_that_is_fixed_in_space_is_the_same_for_runs_that_begin_in_other_attitudes():
    first, since = (Rotation.random(2, random_state=seed).as_matrix() for seed in (1, 2))
    torque, still = np.array([1e-5, -2e-5, 3e-5]), np.zeros((2, 1, 3))
    at = Instant(
        time=still[..., 0], body_rate=still, attitude=since[:, None], state=still[..., :0], first_NB=first[:, None]
    )
    found = EFFECTS["inertial_torque"].hooks("platform").torque(torque[None], at)
    np.testing.assert_allclose(
        found[:, 0], [(start @ turned).T @ torque for start, turned in zip(first, since, strict=True)]
    )


def test_in_orbit_the_inertia_is_no_effect_beside_itself():
    """As one on which gravity does not act it was set aside, with a notice, in every healthy set."""
    data, _ = flown(short("orbit_wheels"))
    testable, _ = hypotheses(data.runs, EFFECTS)
    keys = {each.key for each in testable}
    assert "gravity_gradient:platform" in keys
    assert "inertia:platform" not in keys
