"""[[actuators]] of kind cmg: arrays and single gyros of any axes fly as stated; what goes not together is refused."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
import tomli_w

import testbed as tb
from testbed.assembly.platform import nominal_platform
from testbed.cmg.cluster import cluster_momentum, inertia_change, momentum_jacobian
from testbed.cmg.wheels import wheel_momentum
from testbed.errors import InputError
from testbed.plant.geometry import composite_inertia, total_momentum
from testbed.plant.layout import layout_of
from testbed.scenario.reader import read_scenario

SHIPPED = tomllib.loads((Path(__file__).parents[2] / "scenarios" / "pyramid4.toml").read_text(encoding="utf-8"))
ARRAY = {"kind": "cmg"} | {key: value for key, value in SHIPPED["cluster"].items() if key != "failed"}
SINGLE = {
    key: value for key, value in ARRAY.items() if key not in {"array", "units", "skew_deg", "mounting_radius_m"}
} | {"gimbal_axis": [0.0, 0.0, 1.0], "spin_axis": [1.0, 0.0, 0.0]}
WHEEL = {
    "kind": "reaction_wheel",
    "axis": [0.0, 0.6, 0.8],
    "mass_kg": 0.06,
    "spin_inertia_kg_m2": 1.5e-5,
    "momentum_limit_N_m_s": 0.01,
    "torque_limit_N_m": 0.001,
}
BASIC = {"kind": "basic", "duration_s": 5.0, "scale": 0.5}
LAW = {"law": "singularity_robust", "damping": 0.01, "decay": 10.0}


def written(tmp_path, entries, **changes):
    tree = {key: value for key, value in deepcopy(SHIPPED).items() if key != "cluster"} | {"maneuver": BASIC}
    tree["actuators"] = entries
    tree["controller"]["steering"] = LAW
    tree["initial"].pop("gimbal_angle_rad")
    tree["estimation"]["initial_momentum"] = "estimated"
    for section, values in changes.items():
        tree.setdefault(section, {}).update(values)
    path = tmp_path / "scenario.toml"
    path.write_text(tomli_w.dumps(tree), encoding="utf-8")
    return path


def turned(seed):
    """A unit of axes that no array has."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return {
        "gimbal_axis": axes[0].tolist(),
        "spin_axis": axes[1].tolist(),
        "position_m": rng.uniform(-0.05, 0.05, 3).tolist(),
    }


def unlike():
    """Gyros of two sizes in three entries, one of them an array, and a wheel between them."""
    small = {"rotor_momentum_N_m_s": 0.002, "rotor_spin_inertia_kg_m2": 6e-6, "rotor_transverse_inertia_kg_m2": 4e-6}
    more = {"rotor_mass_kg": 0.02, "gimbal_inertia_kg_m2": 2e-6, "gimbal_mass_kg": 0.01}
    return [SINGLE | turned(1), WHEEL, ARRAY | {"units": 3} | small | more, SINGLE | turned(2)]


def test_an_array_in_the_list_flies_as_the_short_form(tmp_path):
    short = tb.read_scenario("pyramid4", {"maneuver": BASIC, "controller.steering": LAW})
    listed = read_scenario(written(tmp_path, [ARRAY], estimation={"initial_momentum": "zero"}))
    ours, theirs = (tb.fly(each, seed=3) for each in (listed, short))
    for channel in ("true_body_rate", "true_gimbal_angle", "true_rotor_speed"):
        ahead, reference = ours.record.channels[channel], theirs.record.channels[channel]
        np.testing.assert_allclose(ahead, reference, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(ours.estimates["output_error"].theta, theirs.estimates["output_error"].theta, atol=1e-10)


def test_units_are_numbered_through_all_entries_and_stand_where_they_are_stated(tmp_path):
    scenario = read_scenario(written(tmp_path, unlike()))
    platform = nominal_platform(scenario)
    assert scenario.gyros.units == 5
    np.testing.assert_allclose(scenario.gyros.rotor_momentum, [0.004714, 0.002, 0.002, 0.002, 0.004714])
    np.testing.assert_allclose(platform.cluster.rotor_momentum, scenario.gyros.rotor_momentum, rtol=1e-12)
    np.testing.assert_allclose(platform.cluster.gimbal_axis_B, scenario.gyros.places.gimbal_axis_B, atol=1e-12)
    np.testing.assert_allclose(platform.cluster.spin_axis_B, scenario.gyros.places.spin_axis_B, atol=1e-12)
    np.testing.assert_allclose(platform.cluster.position_B[0], turned(1)["position_m"], atol=1e-12)
    np.testing.assert_allclose(platform.cluster.position_B[4], turned(2)["position_m"], atol=1e-12)
    np.testing.assert_allclose(composite_inertia(platform.model), scenario.platform.inertia_kg_m2, atol=1e-12)


def test_momentum_of_any_axes_is_mujocos(tmp_path):
    platform = nominal_platform(read_scenario(written(tmp_path, unlike())))
    cluster, model, rng = platform.cluster, platform.model, np.random.default_rng(1)
    layout = layout_of(model)
    qpos, qvel = np.zeros((6, model.nq)), np.zeros((6, model.nv))
    qpos[:, layout.attitude.start] = 1.0
    qpos[:, layout.gimbal_angle] = angle = rng.uniform(-np.pi, np.pi, (6, 5))
    qvel[:, layout.gimbal_rate] = rate = rng.uniform(-1.0, 1.0, (6, 5))
    qvel[:, layout.body_rate] = body_rate = rng.uniform(-0.5, 0.5, (6, 3))
    qvel[:, layout.rotor_speed] = cluster.rotor_momentum / cluster.rotor_spin_inertia
    qvel[:, layout.wheel_speed] = speed = rng.uniform(-300.0, 300.0, (6, 1))
    expected = np.matvec(platform.inertia + inertia_change(cluster, angle), body_rate)
    expected += cluster_momentum(cluster, angle, rate) + wheel_momentum(platform.wheels, 1.5e-5 * speed)
    np.testing.assert_allclose(total_momentum(model, qpos, qvel), expected, atol=1e-12)


def test_the_jacobian_of_any_axes_is_the_difference_of_mujocos_momentum(tmp_path):
    platform = nominal_platform(read_scenario(written(tmp_path, unlike())))
    cluster, model = platform.cluster, platform.model
    layout, step = layout_of(model), 1e-4
    angle = np.random.default_rng(2).uniform(-np.pi, np.pi, 5)
    moved = angle + step * np.concatenate([np.eye(5), -np.eye(5)])
    qpos, qvel = np.zeros((10, model.nq)), np.zeros((10, model.nv))
    qpos[:, layout.attitude.start] = 1.0
    qpos[:, layout.gimbal_angle] = moved
    qvel[:, layout.rotor_speed] = cluster.rotor_momentum / cluster.rotor_spin_inertia
    held = total_momentum(model, qpos, qvel)
    differences = ((held[:5] - held[5:]) / (2.0 * step)).T
    np.testing.assert_allclose(momentum_jacobian(cluster, angle), differences, atol=1e-2 * step * 0.0047)


def test_gyros_of_two_sizes_and_a_wheel_are_flown_and_estimated(tmp_path):
    run = tb.fly(read_scenario(written(tmp_path, unlike())), seed=1)
    assert max(run.result["tracking"]["rms_rad_s"]) < 0.01
    assert run.estimates["output_error"].theta == pytest.approx(run.truth, abs=2e-3)


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ([SINGLE | {"gimbal_axis": [0.0, 1.0, 1.0]}], "gimbal_axis: has the length 1.41421 instead of 1; divide it"),
        (
            [SINGLE | {"gimbal_axis": [0.0, 0.0, 1.0], "spin_axis": [0.6, 0.0, 0.8]}],
            r"spin_axis: is 36.87° from gimbal_axis, and must be 90° .* nearest axis that is so is \[1, 0, 0\]",
        ),
        ([SINGLE | {"spin_axis": [0.0, 0.0, -1.0]}], "is 180° from gimbal_axis.* state an axis normal to it"),
        ([{k: v for k, v in SINGLE.items() if k != "spin_axis"}], "spin_axis: is missing; add it, or state an array"),
        ([SINGLE | {"units": 2}], "units: belongs to an array"),
        ([ARRAY | {"gimbal_axis": [0.0, 0.0, 1.0]}], "gimbal_axis: belongs to a single unit"),
        ([ARRAY | {"array": "box"}], "skew_deg: has no effect on a box"),
        ([ARRAY | {"array": "box", "units": 3}], "units: is 3, but a box has two equal rows"),
        (
            [SINGLE] * 3,
            r"actuators: give no torque about \[0, 0, 1\] in body axes at any gimbal angles; add an actuator",
        ),
        (
            [SINGLE, SINGLE | turned(1)],
            "actuators: give torque about no more than two axes at a time: with all gimbals at zero not about",
        ),
        (
            [SINGLE, SINGLE, WHEEL | {"axis": [1.0, 0.0, 0.0]}],
            r"give no torque about \[0, 0, 1\] in body axes at any gimbal angles",
        ),
        (
            [ARRAY, SINGLE | {"gimbal_rate_limit_rad_s": 1.0}],
            "of kind cmg have 1.0 and 2.0 for gimbal_rate_limit_rad_s; state one value: it is shared by all gyros",
        ),
        ([ARRAY | {"rotor_momentum_N_m_s": 0.006}], "rotor_momentum_N_m_s: 0.006 exceeds rotor_momentum_limit_N_m_s"),
        ([ARRAY | {"rotor_transverse_inertia_kg_m2": 1e-6}], "no rigid rotor has that"),
        ([ARRAY | {"units": 22}, ARRAY], "have 26 control moment gyros in all; at most 24"),
    ],
)
def test_what_goes_not_together_is_refused_with_its_place(tmp_path, entries, message):
    with pytest.raises(InputError, match=message):
        read_scenario(written(tmp_path, entries))


def test_three_parallel_gimbals_fly_beside_a_wheel_along_them(tmp_path):
    along = WHEEL | {"axis": [0.0, 0.0, 1.0]}
    assert read_scenario(written(tmp_path, [SINGLE, SINGLE, along])).gyros.units == 2


def test_gyros_are_stated_in_one_form_only(tmp_path):
    path = written(tmp_path, [SINGLE | turned(1)], cluster=SHIPPED["cluster"])
    with pytest.raises(InputError, match=r"of kind cmg and \[cluster\].* state all gyros as \[\[actuators\]\]"):
        read_scenario(path)


def test_a_failed_unit_is_counted_within_its_entry(tmp_path):
    entries = [SINGLE | turned(1), ARRAY | {"failed": [2]}]
    scenario = read_scenario(written(tmp_path, entries))
    assert scenario.gyros.failed == (3,)
    assert nominal_platform(scenario).cluster.rotor_momentum[2] == 0.0
