"""Arrays of control moment gyros: where their units stand, and that MuJoCo builds what the formulas say."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest

import testbed as tb
from testbed.assembly.platform import nominal_platform
from testbed.cmg.arrays import unit_places
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change, momentum_jacobian
from testbed.cmg.singularity import singularity_measure
from testbed.plant.geometry import composite_inertia, total_momentum
from testbed.plant.layout import layout_of

ARRAYS = [("pyramid", 3), ("pyramid", 4), ("pyramid", 5), ("pyramid", 8), ("roof", 4), ("roof", 6), ("box", 4)]
SKEW = radians(50.0)


def cluster(kind, units):
    places = unit_places(kind, units, SKEW)
    same = np.ones(units)
    return Cluster(
        gimbal_axis_B=places.gimbal_axis_B,
        spin_axis_B=places.spin_axis_B,
        rotor_momentum=same,
        rotor_spin_inertia=same,
        rotor_transverse_inertia=same,
        gimbal_inertia=same,
    )


@pytest.mark.parametrize(("kind", "units"), [*ARRAYS, ("line", 4)])
def test_axes_are_unit_vectors_normal_to_each_other_and_no_momentum_is_held_at_zero(kind, units):
    places = unit_places(kind, units, SKEW)
    for axes in (places.gimbal_axis_B, places.spin_axis_B):
        np.testing.assert_allclose(np.linalg.norm(axes, axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose((places.gimbal_axis_B * places.spin_axis_B).sum(axis=1), 0.0, atol=1e-14)
    np.testing.assert_allclose(places.spin_axis_B.sum(axis=0), 0.0, atol=1e-14)


@pytest.mark.parametrize(("kind", "units"), ARRAYS)
def test_at_zero_torque_can_be_given_about_every_axis(kind, units):
    array = cluster(kind, units)
    measure = singularity_measure(momentum_jacobian(array, np.zeros(units)), array.rotor_momentum)
    assert 0.3 < measure <= 1.0


def test_a_line_gives_no_torque_about_its_axis():
    angle = np.random.default_rng(1).uniform(-pi, pi, (20, 4))
    jacobian = momentum_jacobian(cluster("line", 4), angle)
    np.testing.assert_allclose(jacobian[:, 2], 0.0, atol=1e-15)


def test_a_pyramid_is_the_textbooks():
    """Momentum of four units at 54.74 degrees, Wie, ch. 7.4: h_x = -cβ sin x1 - cos x2 + cβ sin x3 + cos x4, ..."""
    x, skew = np.array([0.3, -0.2, 0.7, 1.1]), radians(54.74)
    places = unit_places("pyramid", 4, skew)
    turned = places.spin_axis_B * np.cos(x)[:, None]
    turned += np.cross(places.gimbal_axis_B, places.spin_axis_B) * np.sin(x)[:, None]
    beta = cos(skew)
    expected = [
        -beta * sin(x[0]) - cos(x[1]) + beta * sin(x[2]) + cos(x[3]),
        cos(x[0]) - beta * sin(x[1]) - cos(x[2]) + beta * sin(x[3]),
        sin(skew) * np.sin(x).sum(),
    ]
    np.testing.assert_allclose(turned.sum(axis=0), expected, atol=1e-14)


def scenario(kind, units):
    more = {} if kind == "box" else {"cluster.skew_deg": 50.0}
    name = "box_roof" if kind == "box" else "pyramid4"
    none = {"initial.gimbal_angle_rad": [], "cluster.array": kind, "cluster.units": units}
    return tb.read_scenario(name, none | more)


@pytest.mark.parametrize(("kind", "units"), ARRAYS)
def test_mujoco_builds_it(kind, units):
    """Axes, places, the whole inertia as stated, and MuJoCo's own momentum at random angles and rates."""
    asked = scenario(kind, units)
    platform = nominal_platform(asked)
    places = unit_places(kind, units, pi / 4.0 if kind == "box" else SKEW)
    np.testing.assert_allclose(platform.cluster.gimbal_axis_B, places.gimbal_axis_B, atol=1e-12)
    np.testing.assert_allclose(platform.cluster.spin_axis_B, places.spin_axis_B, atol=1e-12)
    np.testing.assert_allclose(platform.cluster.position_B, 0.06 * places.direction_B, atol=1e-12)
    np.testing.assert_allclose(composite_inertia(platform.model), asked.platform.inertia_kg_m2, atol=1e-12)
    rng, layout = np.random.default_rng(units), layout_of(platform.model)
    qpos, qvel = np.zeros((3, platform.model.nq)), np.zeros((3, platform.model.nv))
    qpos[:, layout.attitude.start] = 1.0
    qpos[:, layout.gimbal_angle] = angle = rng.uniform(-pi, pi, (3, units))
    qvel[:, layout.gimbal_rate] = rate = rng.uniform(-1.0, 1.0, (3, units))
    qvel[:, layout.body_rate] = body_rate = rng.uniform(-0.5, 0.5, (3, 3))
    qvel[:, layout.rotor_speed] = platform.cluster.rotor_momentum / platform.cluster.rotor_spin_inertia
    turning = np.matvec(platform.inertia + inertia_change(platform.cluster, angle), body_rate)
    expected = turning + cluster_momentum(platform.cluster, angle, rate)
    np.testing.assert_allclose(total_momentum(platform.model, qpos, qvel), expected, atol=1e-12)


def test_records_have_a_column_for_each_unit_and_are_refused_by_another_platform():
    four = tb.read_scenario("pyramid4")
    flown = tb.fly(four, tb.design(four), seed=1).record
    table = tb.frame_of(flown)
    assert [name for name in table if name.startswith("gimbal_angle_")] == [
        f"gimbal_angle_{n}_rad" for n in range(1, 5)
    ]
    records = tb.records_from(table)
    assert tb.estimate(four, records).combined["output_error"].theta.shape == (6,)
    with pytest.raises(
        tb.InputError, match=r"4 units, but the scenario has 6; add gimbal_angle_5_rad, gimbal_angle_6_rad, or use"
    ):
        tb.estimate(tb.read_scenario("basic"), records)


DAMPED = {"damping": 0.01, "decay": 10.0}
DITHERED = {**DAMPED, "dither": 0.1, "dither_rate_rad_s": 1.6}


@pytest.mark.parametrize(
    ("law", "tuning"),
    [
        ("moore_penrose", {}),
        ("singularity_robust", DAMPED),
        ("generalized_singularity_robust", DITHERED),
        ("off_diagonal_singularity_robust", DITHERED),
    ],
)
def test_every_steering_law_tracks_a_body_rate_with_four_units(law, tuning):
    profile = {"kind": "basic", "duration_s": 5.0, "scale": 0.5}
    run = tb.fly(
        tb.read_scenario("pyramid4", {"maneuver": profile, "controller.steering": {"law": law, **tuning}}), seed=1
    )
    assert max(run.result["tracking"]["rms_rad_s"]) < 0.005
    assert run.estimates["output_error"].theta == pytest.approx(run.truth, abs=2e-3)


def test_a_record_whose_channels_differ_in_units_is_refused():
    flown = tb.frame_of(tb.fly(tb.read_scenario("basic"), seed=1).record)
    columns = {name: flown[name] for name in flown if name != "rotor_speed_6_rad_s" and not name.startswith("true_")}
    with pytest.raises(tb.InputError, match=r"channels differ in the number of units: gimbal_angle 6, .*rotor_speed 5"):
        tb.records_from(columns)
