"""Designs of gimbal angles and wheel momenta together: checked by MuJoCo, by NumPy alone, and flown."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from pathlib import Path

import casadi as ca
import mujoco
import numpy as np
import pytest
import tomli_w

import testbed as tb
from testbed.assembly.maneuver import design_problem, gimbal_limits
from testbed.assembly.platform import each_wheel, nominal_platform
from testbed.cmg.cluster import cluster_momentum, platform_momentum
from testbed.cmg.singularity import singularity_measure
from testbed.cmg.wheels import wheel_momentum
from testbed.errors import InputError
from testbed.maneuver.cluster_motion import MOTION_OUTPUTS, motion_function
from testbed.maneuver.gimbal_design import _held_points, _program
from testbed.maneuver.profiles import read_profile
from testbed.outputs.design_folder import maneuver_section
from testbed.plant.layout import layout_of
from testbed.scenario.reader import read_scenario

SHIPPED = Path(__file__).parents[2] / "scenarios"
DESIGN = {
    "kind": "design",
    "parametrization": "actuator",
    "criterion": "D",
    "metric": "momentum",
    "duration_s": 5.0,
    "control_points": 10,
    "starts": 1,
    "seed": 1,
    "sample_rate_hz": 16.0,
    "prefilter_time_constant_s": 0.8,
    "envelope_fraction": 0.95,
}
START = [0.001, 0.0, -0.001]
BETWEEN = 1.02
"""Limits without a convex hull are kept at instants; in between they bend by up to 2 %."""


def written(tmp_path, shipped, change):
    tree = tomllib.loads((SHIPPED / f"{shipped}.toml").read_text(encoding="utf-8"))
    change(tree)
    path = tmp_path / f"{shipped}.toml"
    path.write_text(tomli_w.dumps(tree), encoding="utf-8")
    return path


def actuator_design(tree):
    tree["maneuver"] = deepcopy(DESIGN)
    tree["initial"]["wheel_momentum_N_m_s"] = START
    tree["controller"]["wheels"] = {"null_motion": "maneuver"}
    tree["controller"]["steering"] |= {"preferred_gimbal_angle_rad": "maneuver", "null_motion_gain_1_s": 2.0}
    tree["estimation"]["initial_momentum"] = "estimated"


@pytest.fixture(scope="module")
def designed(tmp_path_factory):
    """Two gyros and three wheels that start with momentum in them."""
    scenario = tb.read_scenario(written(tmp_path_factory.mktemp("mixed"), "mixed", actuator_design))
    return scenario, tb.design(scenario)


def test_the_limits_jacobian_is_casadis_own(tmp_path):
    """With momentum in the wheels at the start: L turns with the body, and depends on all of the motion so far."""
    scenario = read_scenario(written(tmp_path, "mixed", actuator_design))
    nominal = nominal_platform(scenario)
    problem = design_problem(scenario, scenario.maneuver, nominal)
    program = _program(problem, "D", gimbal_limits(scenario, scenario.maneuver), _held_points(problem))
    own = [limit for limit in program.constraints if limit.jacobian is not None]
    assert {"gimbal torque", "wheel torque", "momentum envelope", "rest at the end"} <= {limit.name for limit in own}
    pairs = [(limit.jacobian, ca.jacobian(limit.expression, program.variables)) for limit in own]
    evaluate = ca.Function("pairs", [program.variables], [entry for pair in pairs for entry in pair])
    values = evaluate(np.random.default_rng(8).uniform(-0.5, 0.5, program.variables.numel()))
    for limit, ours, casadis in zip(own, values[::2], values[1::2], strict=True):
        scale = np.abs(casadis.full()).max()
        assert scale > 0.0
        np.testing.assert_allclose(ours.full(), casadis.full(), atol=1e-11 * scale, err_msg=limit.name)


def test_torques_are_those_with_which_mujoco_has_this_motion(tmp_path):
    """MuJoCo is given the motion, and asked for the forces that make it: none on the bus, these on the motors."""
    scenario = read_scenario(SHIPPED / "mixed.toml")
    nominal, rng = nominal_platform(scenario), np.random.default_rng(5)
    problem = design_problem(scenario, read_scenario(written(tmp_path, "mixed", actuator_design)).maneuver, nominal)
    motion, rate, acceleration = (rng.uniform(-1.0, 1.0, 5) for _ in range(3))
    total, friction = np.array([0.004, -0.003, 0.006]), np.full(3, 2e-9)
    balance = motion_function(problem.actuators, problem.inertia, friction)

    def found(motion, rate, acceleration, total):
        outputs = balance(motion, rate, acceleration, total)
        return {name: output.full().ravel() for name, output in zip(MOTION_OUTPUTS, outputs, strict=True)}

    now, wheels, step = found(motion, rate, acceleration, total), problem.wheels, 1e-6
    turned = [sign * step * np.cross(now["body_rate"], total) for sign in (-1.0, 1.0)]
    ahead, behind = (
        found(motion + sign * step * rate, rate + sign * step * acceleration, acceleration, total + change)
        for sign, change in zip((1.0, -1.0), turned, strict=True)
    )
    model = nominal.model
    layout, data = layout_of(model), mujoco.MjData(model)
    data.qpos[layout.gimbal_angle] = motion[:2]
    data.qvel[layout.gimbal_rate], data.qacc[layout.gimbal_rate] = rate[:2], acceleration[:2]
    data.qvel[layout.rotor_speed] = problem.cluster.rotor_momentum / problem.cluster.rotor_spin_inertia
    data.qvel[layout.wheel_speed] = wheels.momentum_limit * motion[2:] / wheels.spin_inertia
    data.qacc[layout.wheel_speed] = wheels.momentum_limit * rate[2:] / wheels.spin_inertia
    data.qvel[layout.body_rate] = now["body_rate"]
    data.qacc[layout.body_rate] = (ahead["body_rate"] - behind["body_rate"]) / (2.0 * step)
    mujoco.mj_inverse(model, data)
    np.testing.assert_allclose(data.qfrc_inverse[layout.body_rate], 0.0, atol=1e-9)
    np.testing.assert_allclose(data.qfrc_inverse[layout.gimbal_rate], now["gimbal_torque"], atol=1e-9)
    torque = now["wheel_torque"] * wheels.torque_limit  # bearings included, whose friction MuJoCo counts as passive
    np.testing.assert_allclose(data.qfrc_inverse[layout.wheel_speed], torque, atol=1e-9)


def test_the_motion_conserves_momentum_and_keeps_all_limits(designed):
    scenario, maneuver = designed
    nominal, plan = nominal_platform(scenario), maneuver.plan.maneuver
    limits, problem = gimbal_limits(scenario, scenario.maneuver), design_problem(scenario, scenario.maneuver, nominal)
    time = np.linspace(0.0, 5.0, 1601)
    reference = plan.reference(time)
    held_B = cluster_momentum(problem.cluster, reference.gimbal_angle, reference.gimbal_rate)
    held_B = held_B + wheel_momentum(problem.wheels, reference.wheel_momentum)
    zero = np.zeros_like(reference.gimbal_angle)
    total_B = (
        platform_momentum(problem.cluster, problem.inertia, reference.body_rate, reference.gimbal_angle, zero)
        - cluster_momentum(problem.cluster, reference.gimbal_angle, zero)
        + held_B
    )
    length = np.linalg.norm(total_B, axis=1)
    np.testing.assert_allclose(length, length[0], rtol=1e-5)
    assert length[0] > 1e-3  # it is not the easy case of no momentum
    np.testing.assert_allclose(reference.body_rate[[0, -1]], 0.0, atol=1e-7)
    np.testing.assert_allclose(reference.wheel_momentum[0], START, atol=1e-15)
    np.testing.assert_allclose(reference.wheel_momentum_rate[[0, -1]], 0.0, atol=1e-12)
    assert np.abs(reference.wheel_momentum / problem.wheels.momentum_limit).max() <= 0.9 + 1e-6
    along = plan.body_rate(time, nu=1) @ problem.wheels.axis_B.T
    friction = each_wheel(scenario, "viscous_friction_N_m_s_rad") / problem.wheels.spin_inertia
    torque = reference.wheel_momentum_rate + problem.wheels.spin_inertia * along + friction * reference.wheel_momentum
    assert np.abs(torque / problem.wheels.torque_limit).max() <= 0.8 * BETWEEN
    assert np.abs(reference.gimbal_rate).max() <= limits.gimbal_rate * (1.0 + 1e-6)
    assert np.abs(torque).max() > 0.2 * problem.wheels.torque_limit.max()  # the wheels are used


def test_it_is_flown_as_designed(designed):
    scenario, maneuver = designed
    run = tb.fly(scenario, maneuver, seed=3)
    channels = run.record.channels
    assert np.abs(channels["true_body_rate"] - channels["reference_body_rate"]).max() < 0.02
    largest = np.abs(channels["reference_wheel_speed"]).max()
    assert np.abs(channels["true_wheel_speed"] - channels["reference_wheel_speed"]).max() < 0.1 * largest


def test_a_design_taken_up_again_is_the_same_motion(designed, tmp_path):
    scenario, maneuver = designed

    def take_up(tree):
        actuator_design(tree)
        tree["maneuver"] = tomllib.loads(maneuver_section(maneuver.plan.design))["maneuver"]

    again = tb.design(tb.read_scenario(written(tmp_path, "mixed", take_up)))
    time = np.linspace(0.0, 5.0, 200)
    one, other = (each.plan.maneuver.reference(time) for each in (maneuver, again))
    np.testing.assert_allclose(other.body_rate, one.body_rate, atol=1e-12)
    np.testing.assert_allclose(other.wheel_momentum, one.wheel_momentum, atol=1e-16)
    maneuver.to_pandas().to_csv(tmp_path / "table.csv", index=False)
    table = read_profile(tmp_path / "table.csv", 2, each_wheel(scenario, "spin_inertia_kg_m2")).reference(time)
    np.testing.assert_allclose(table.wheel_momentum, one.wheel_momentum, atol=1e-7)


def test_the_singularity_measure_counts_gyros_and_wheels_as_a_flight_does(designed):
    scenario, _ = designed
    problem = design_problem(scenario, scenario.maneuver, nominal_platform(scenario))
    actuators = problem.actuators
    outputs = motion_function(actuators, problem.inertia, np.zeros(3))(*(np.zeros(5),) * 3, np.zeros(3))
    gyros_B = np.cross(problem.cluster.gimbal_axis_B, problem.cluster.spin_axis_B) * problem.cluster.rotor_momentum[0]
    jacobian = np.concatenate([gyros_B.T, actuators.wheel_columns], axis=1)
    strengths = np.concatenate([problem.cluster.rotor_momentum, actuators.wheel_scale])
    dexterity = float(outputs[MOTION_OUTPUTS.index("dexterity")])
    assert np.sqrt(dexterity) == pytest.approx(float(singularity_measure(jacobian, strengths)), rel=1e-12)


def spline(tree, **rows):
    tree["maneuver"] = {"kind": "control_points", "parametrization": "actuator", "duration_s": 5.0} | rows


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda tree: tree["maneuver"].update(
                parametrization="gimbal", gimbal_rate_fraction=0.9, min_singularity_measure=0.1
            ),
            'maneuver.parametrization: is "gimbal", but the platform has wheels; use "actuator"',
        ),
        (
            lambda tree: spline(
                tree, wheel_momentum_N_m_s=[[0.001, 0.0, -0.001]] * 4, gimbal_angle_rad=[[0.0, 0.0]] * 3
            ),
            "gimbal_angle_rad: has 3 rows instead of 4, as many as of the wheels' momenta",
        ),
        (
            lambda tree: spline(tree, wheel_momentum_N_m_s=[[0.002, 0.0, 0.0]] * 4, gimbal_angle_rad=[[0.0, 0.0]] * 4),
            r"wheel_momentum_N_m_s: starts at \[0.002, 0.0, 0.0\], the wheels at \[0.001, 0.0, -0.001\]; make them",
        ),
        (
            lambda tree: spline(tree, wheel_momentum_N_m_s=[[0.001, 0.0]] * 4, gimbal_angle_rad=[[0.0, 0.0]] * 4),
            "wheel_momentum_N_m_s: row 1 has 2 entries instead of 3, one for each wheel",
        ),
        (
            lambda tree: tree.update(maneuver={"kind": "basic", "duration_s": 5.0, "scale": 1.0}),
            'controller.wheels.null_motion: is "maneuver", but this maneuver leaves the wheels open',
        ),
    ],
)
def test_what_does_not_go_together_is_refused_with_its_remedy(tmp_path, change, message):
    def changed(tree):
        actuator_design(tree)
        tree["controller"]["steering"]["preferred_gimbal_angle_rad"] = "zero"
        change(tree)

    with pytest.raises(InputError, match=message):
        read_scenario(written(tmp_path, "mixed", changed))


def test_a_single_gyro_among_wheels_needs_no_margin_to_its_envelope_on_which_it_always_is(tmp_path):
    """One gyro and wheels along all axes, the wheels' momentum against the rotor's at the start."""

    def single(tree):
        actuator_design(tree)
        gyro = tree.pop("cluster")
        for key in ("array", "units", "skew_deg", "mounting_radius_m"):
            del gyro[key]
        gyro |= {
            "kind": "cmg",
            "gimbal_axis": [1.0, 0.0, 0.0],
            "spin_axis": [0.0, 1.0, 0.0],
            "position_m": [0.05, 0.0, 0.0],
        }
        tree["actuators"] = [gyro, *tree["actuators"]]
        tree["initial"] |= {
            "gimbal_angle_rad": [0.0],
            "wheel_momentum_N_m_s": [0.0, -gyro["rotor_momentum_N_m_s"], 0.0],
        }

    design = tb.design(tb.read_scenario(written(tmp_path, "mixed", single)))
    reference = design.plan.maneuver.reference(np.linspace(0.0, 5.0, 101))
    assert np.abs(reference.gimbal_angle).max() > 0.1
    np.testing.assert_allclose(reference.body_rate[[0, -1]], 0.0, atol=1e-7)


def test_a_table_without_wheel_speeds_leaves_null_motion_nowhere_to_go(tmp_path):
    (tmp_path / "table.csv").write_text(
        "time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s\n" + "".join(f"{k},0,0,0\n" for k in range(6))
    )

    def changed(tree):
        actuator_design(tree)
        tree["maneuver"] = {"kind": "csv", "file": "table.csv"}
        tree["controller"]["steering"]["preferred_gimbal_angle_rad"] = "zero"

    scenario = tb.read_scenario(written(tmp_path, "mixed", changed))
    with pytest.raises(InputError, match="prescribes no momenta of wheels"):
        tb.fly(scenario, seed=1)
