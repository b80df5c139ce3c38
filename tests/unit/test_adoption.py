"""Models of one's own: what is taken for what, the scenario that is written, and that it moves as the model does."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import testbed as tb
from testbed.assembly.platform import nominal_platform
from testbed.dynamics.inertia import inertia_of
from testbed.plant.geometry import composite_inertia
from testbed.scenario.reader import read_scenario

PROMISED = 1e-8
"""rad/s over 10 s."""
AXES = {"port": "0 1 0", "bow": "1 0 0", "keel": "0 0 -1"}


def wheel(name, axis, joint="", inside=""):
    return (
        f"<body name='{name}' pos='0.03 -0.02 0.01'><joint name='{name}' axis='{axis}' {joint}/>"
        f"<geom type='cylinder' size='0.02 0.004' zaxis='{axis}' mass='0.1'/>{inside}</body>"
    )


def gyro(name, place, gimbal="0 0 1", spin="1 0 0", rotor="", gimbal_joint=""):
    return (
        f"<body name='{name}_frame' pos='{place}'><joint name='{name}' axis='{gimbal}' {gimbal_joint}/>"
        f"<inertial pos='0 0 0' mass='0.02' diaginertia='3e-6 3e-6 3e-6'/>"
        f"<body><joint name='{name}_spin' axis='{spin}'/>"
        f"<geom type='cylinder' size='0.02 0.004' zaxis='{spin}' mass='0.05' {rotor}/></body></body>"
    )


def motors(*names, limits="ctrlrange='-0.001 0.001'"):
    return "".join(f"<motor joint='{name}' {limits}/>" for name in names)


def model(tmp_path, parts, actuators, joint="<freejoint/>", more=""):
    body = f"<body name='ship' euler='10 20 30'>{joint}<geom type='box' size='.1 .12 .15' mass='4'/>{parts}</body>"
    path = tmp_path / "ship.xml"
    actuators = f"<actuator>{actuators}</actuator>" if actuators else ""
    path.write_text(f"<mujoco><worldbody>{body}</worldbody>{actuators}{more}</mujoco>", encoding="utf-8")
    return path


def three_wheels(port=""):
    """Wheels along three axes; the joint of the first has attributes of its own."""
    return "".join(wheel(name, axis, joint=port if name == "port" else "") for name, axis in AXES.items())


def roles(adopted):
    return {name: role for name, role, _ in adopted.parts}


def check_flies(adopted, tmp_path):
    """The scenario is written, read again, and flown with its own numbers."""
    scenario = read_scenario(adopted.save(tmp_path / "written.toml"))
    run = tb.fly(scenario, seed=1)
    assert run.estimates["output_error"].theta == pytest.approx(run.truth, abs=0.05 * scenario_size(adopted))
    return scenario


def scenario_size(adopted):
    return float(np.linalg.eigvalsh(adopted.inertia)[0])


def test_three_wheels_are_found_with_their_axes_inertias_and_limits(tmp_path):
    adopted = tb.adopt(model(tmp_path, three_wheels(), motors(*AXES)))
    assert roles(adopted) == {"ship": "platform", "port": "wheel", "bow": "wheel", "keel": "wheel"}
    entries = adopted.scenario.actuators
    np.testing.assert_allclose([entry.axis for entry in entries], [[0, 1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-12)
    spin = 0.5 * 0.1 * 0.02**2
    np.testing.assert_allclose([entry.spin_inertia_kg_m2 for entry in entries], spin, rtol=1e-9)
    np.testing.assert_allclose([entry.torque_limit_N_m for entry in entries], 0.001)
    np.testing.assert_allclose([entry.momentum_limit_N_m_s for entry in entries], spin * 200.0 * np.pi, rtol=1e-9)
    assert adopted.text.count("not in the model: replace it; 6,000 turns a minute") == 3
    assert adopted.notes == ()
    check_flies(adopted, tmp_path)


def driven(tmp_path, gain, parts=""):
    """Wheels of which the first has a drive that holds a speed, by a gain against it in N·m·s/rad."""
    servo = f"<velocity joint='port' kv='{gain}' ctrlrange='-500 500'/>"
    return model(tmp_path, three_wheels() + parts, servo + motors("bow", "keel"))


@pytest.mark.parametrize(
    ("gain", "step"), [(0.001, 0.005), (0.01, 0.00125), (0.02, 0.000625), (2.0, 0.005 / 2**9)], ids=str
)
def test_the_step_follows_the_fastest_drive_and_divides_the_control_period(tmp_path, gain, step):
    adopted = tb.adopt(driven(tmp_path, gain))
    assert adopted.scenario.simulation.step_s == step
    assert adopted.scenario.actuators[0].speed_loop_bandwidth_rad_s == pytest.approx(gain / 2e-5)
    said = f"step_s = {step} # for the wheel drive of {gain / 2e-5:g} rad/s"
    assert (said in adopted.text) == (step < 0.005)


def test_a_platform_with_a_fast_drive_flies(tmp_path):
    check_flies(tb.adopt(driven(tmp_path, 0.02)), tmp_path)
    with_gyro = tb.adopt(driven(tmp_path, 0.02, gyro("aft", "0.05 0 0")))
    assert with_gyro.scenario.simulation.step_s == 0.000625


def test_a_refusal_names_the_model_and_no_line_of_what_is_not_written(tmp_path):
    with pytest.raises(tb.InputError) as refused:
        tb.adopt(driven(tmp_path, 3.0))
    heading, problem = str(refused.value).splitlines()
    assert heading.endswith("ship.xml: what was found in it makes no scenario that can be flown: 1 problem")
    assert problem.startswith("  actuators[1].speed_loop_bandwidth_rad_s: should be at most 100000")


def test_the_inertia_is_that_of_everything_locked_about_the_centre_of_mass_in_body_axes(tmp_path):
    path = model(tmp_path, three_wheels(), motors(*AXES))
    adopted = tb.adopt(path)
    own = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(own)
    mujoco.mj_forward(own, data)
    own_mass = np.zeros((own.nv, own.nv))
    mujoco.mj_fullM(own, data, own_mass)
    offset = data.xmat[1].reshape(3, 3).T @ (data.subtree_com[1] - data.xpos[1])
    about_origin, mass = own_mass[3:6, 3:6], own.body_subtreemass[1]
    expected = about_origin - mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    np.testing.assert_allclose(adopted.inertia, expected, atol=1e-12)
    np.testing.assert_allclose(composite_inertia(nominal_platform(adopted.scenario).model), expected, atol=1e-12)
    assert adopted.mass == pytest.approx(mass)


def test_wheels_move_as_the_users_own(tmp_path):
    adopted = tb.adopt(model(tmp_path, three_wheels(), motors(*AXES)))
    assert adopted.difference <= PROMISED


def test_gyros_and_a_wheel_are_found_and_move_as_the_users_own(tmp_path):
    parts = "".join(
        [
            gyro("aft", "0.05 0 0"),
            gyro("fore", "-0.05 0 0.02", gimbal="0 1 0", spin="0 0 1"),
            gyro("top", "0 0.04 0.05", gimbal="1 0 0", spin="0 1 0"),
            wheel("keel", "0 0 1"),
        ]
    )
    driven = motors("aft", "fore", "top", limits="forcerange='-0.02 0.02'") + motors("keel", "aft_spin")
    key = "<keyframe><key qvel='0 0 0 0 0 0  0 400 0 -400 0 400  30'/></keyframe>"
    adopted = tb.adopt(model(tmp_path, parts, driven, more=key))
    found = roles(adopted)
    assert [name for name, role in found.items() if role == "gimbal"] == ["aft", "fore", "top"]
    assert [name for name, role in found.items() if role == "rotor"] == ["aft_spin", "fore_spin", "top_spin"]
    assert found["keel"] == "wheel"
    gyros, spin = adopted.scenario.gyros, 0.5 * 0.05 * 0.02**2
    np.testing.assert_allclose(gyros.rotor_momentum, 400.0 * spin, rtol=1e-9)
    np.testing.assert_allclose(gyros.places.spin_axis_B, [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-12)
    assert gyros.gimbal_torque_limit == 0.02
    assert gyros.rotors == "constant_speed"
    np.testing.assert_allclose(adopted.scenario.initial.wheel_momentum_N_m_s, [30.0 * 0.5 * 0.1 * 0.02**2])
    assert adopted.notes == ()
    assert adopted.difference <= PROMISED
    check_flies(adopted, tmp_path)


def urdf(tmp_path, effort="effort='0.002' velocity='500'", root="<link name='base'>"):
    inertial = (
        "<inertial><origin xyz='{}'/><mass value='{}'/><inertia ixx='{}' iyy='{}' izz='{}' ixy='0' ixz='0' iyz='0'/>"
    )
    base = inertial.format("0.01 0 0", 4, 0.02, 0.03, 0.025) + "</inertial>"
    looks = "<visual><geometry><mesh filename='package://nowhere/hull.dae'/></geometry></visual>"
    links = "".join(
        f"<link name='l_{name}'>{inertial.format('0 0 0', 0.1, 1e-5, 1e-5, 2e-5)}</inertial></link>"
        f"<joint name='{name}' type='continuous'><parent link='base'/><child link='l_{name}'/>"
        f"<origin xyz='0.05 0 0.01' rpy='{turn}'/><axis xyz='0 0 1'/><limit {effort}/></joint>"
        for name, turn in {"a": "0 1.5707963267948966 0", "b": "1.5707963267948966 0 0", "c": "0 0 0"}.items()
    )
    path = tmp_path / "sat.urdf"
    path.write_text(f"<robot name='sat'>{root}{base}{looks}</link>{links}</robot>", encoding="utf-8")
    return path


def test_a_urdf_is_free_at_its_root_and_states_efforts_and_speeds(tmp_path):
    adopted = tb.adopt(urdf(tmp_path))
    assert roles(adopted) == {"base": "platform", "a": "wheel", "b": "wheel", "c": "wheel"}
    entries = adopted.scenario.actuators
    np.testing.assert_allclose([entry.torque_limit_N_m for entry in entries], 0.002)
    np.testing.assert_allclose([entry.momentum_limit_N_m_s for entry in entries], 2e-5 * 500.0)
    np.testing.assert_allclose(entries[0].axis, [1, 0, 0], atol=1e-12)
    assert adopted.difference <= PROMISED
    check_flies(adopted, tmp_path)


def test_a_urdf_of_two_roots_is_refused_with_their_names(tmp_path):
    inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
    with pytest.raises(tb.InputError) as refused:
        tb.adopt(urdf(tmp_path, root=f"<link name='antenna'>{inertial}</link><link name='base'>"))
    said = str(refused.value)
    assert said.endswith(
        "sat.urdf: has 2 root links, antenna, base, where the only one would be the platform; "
        "join the others to it by joints, or delete them"
    )
    assert "freejoint" not in said
    fixed = "<joint name='boom' type='fixed'><parent link='base'/><child link='antenna'/></joint>"
    joined = tb.adopt(urdf(tmp_path, root=f"<link name='antenna'>{inertial}</link>{fixed}<link name='base'>"))
    assert joined.mass == pytest.approx(5.3)


def test_a_ball_joint_is_an_air_bearing_with_the_pivot_and_gravity_of_the_model(tmp_path):
    joint = "<joint name='cup' type='ball' pos='1e-5 -2e-5 2e-4' damping='1e-4'/>"
    gravity = "<option gravity='0 0 -9.7'/>"
    path = model(tmp_path, three_wheels(), motors(*AXES, limits="ctrlrange='-0.02 0.02'"), joint=joint, more=gravity)
    adopted = tb.adopt(path)
    environment = adopted.scenario.environment
    assert (environment.kind, environment.gravity_m_s2, environment.drag_N_m_s_rad) == ("air_bearing", 9.7, 1e-4)
    own = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(own)
    mujoco.mj_forward(own, data)
    offset = data.xmat[1].reshape(3, 3).T @ (data.subtree_com[1] - data.xanchor[0])
    np.testing.assert_allclose(environment.center_of_mass_offset_m, offset, atol=1e-12)
    np.testing.assert_allclose(adopted.scenario.initial.attitude_quat_NB, data.xquat[1], atol=1e-12)
    assert adopted.difference <= PROMISED
    assert tb.fly(adopted.scenario, seed=1).result["outcome"] == "completed"


def test_an_estimated_platform_is_adopted_from_its_mjcf_and_its_urdf(tmp_path):
    scenario = tb.read_scenario("mixed")
    estimate = tb.estimate(scenario, tb.Records((tb.fly(scenario, seed=1).record,)))
    for written in (estimate.to_mjcf(tmp_path / "out.xml"), estimate.to_urdf(tmp_path / "out.urdf")):
        adopted = tb.adopt(written)
        assert sorted(roles(adopted).values()) == sorted(["platform", *["gimbal", "rotor"] * 2, *["wheel"] * 3])
        np.testing.assert_allclose(adopted.inertia, estimate_inertia(estimate), atol=1e-9)
        assert adopted.difference <= PROMISED


def estimate_inertia(estimate):
    return inertia_of(estimate.combined["output_error"].theta)


def test_what_turns_no_rotor_is_locked_and_may_be_corrected(tmp_path):
    shape = "<geom type='box' size='.1 .1 .003' mass='.3'/>"
    panel = f"<body name='panel' pos='0 0.2 0'><joint name='drive' axis='1 0 0'/>{shape}</body>"
    spare = wheel("spare", "0 1 0")
    path = model(tmp_path, three_wheels() + panel + spare, motors(*AXES, "spare"))
    adopted = tb.adopt(path)
    assert roles(adopted)["drive"] == "locked"
    assert roles(adopted)["spare"] == "wheel"
    assert roles(tb.adopt(path, ignore=["spare"]))["spare"] == "locked"
    forced = tb.adopt(path, wheel=["panel"])
    assert roles(forced)["drive"] == "wheel"
    assert any(note.startswith("drive: it is not symmetric about its axis") for note in forced.notes)
    assert forced.difference > PROMISED  # and it is said by how much


def test_what_a_scenario_cannot_say_is_noted(tmp_path):
    parts = three_wheels() + "".join(
        [
            gyro("aft", "0.05 0 0", gimbal_joint="armature='1e-6' range='-60 60' damping='1e-5'"),
            gyro("fore", "-0.05 0 0", rotor="pos='0.002 0.0005 0'"),
        ]
    )
    adopted = tb.adopt(model(tmp_path, parts, motors(*AXES, "aft", "fore")))
    said = "\n".join(adopted.notes)
    for part in (
        "aft: its armature of 1e-06 kg·m² is left out",
        "aft: its stops are left out",
        "aft: its damping of 1e-05 N·m·s/rad is left out",
        "fore_spin: its centre of mass is 0.0005 m off its axis",
        "fore: what it turns is 0.0021 m off its axis",
    ):
        assert part in said


def test_dry_friction_is_flown_and_its_softness_about_standstill_is_noted(tmp_path):
    rubbed = "damping='1e-6' frictionloss='1e-5'"
    as_flown = tb.adopt(model(tmp_path, three_wheels(f"{rubbed} solreffriction='0.01 1'"), motors(*AXES)))
    assert [entry.coulomb_friction_N_m for entry in as_flown.scenario.actuators] == [1e-5, 0.0, 0.0]
    assert as_flown.notes == ()
    assert as_flown.difference < 1e-12
    softer = tb.adopt(model(tmp_path, three_wheels(rubbed), motors(*AXES)))
    assert softer.difference > PROMISED
    assert softer.notes == (
        "port: the softness of its dry friction of 1e-05 N·m about standstill, solreffriction 0.02 1, is left out; "
        "0.01 1 is flown",
    )


@pytest.mark.parametrize(
    ("attributes", "note"),
    [
        ("stiffness='0.001' springref='10'", "port: its spring of 0.001 N·m/rad is left out"),
        ("stiffness='0 0.002'", "port: its spring of 0 0.002 N·m/rad is left out"),
        ("armature='1e-6'", "port: its armature of 1e-06 kg·m² is left out"),
        ("damping='1e-6 1e-7'", "port: its damping of 1e-06 1e-07 N·m·s/rad, but for the first number, is left out"),
    ],
)
def test_what_acts_on_a_wheel_and_is_not_flown_is_noted(tmp_path, attributes, note):
    adopted = tb.adopt(model(tmp_path, three_wheels(attributes), motors(*AXES)))
    assert adopted.notes == (note,)
    assert adopted.difference > PROMISED


@pytest.mark.parametrize(
    ("motor", "notes"),
    [
        ("<general joint='port' gear='2' biastype='affine' biasprm='0.1'/>", ["constant torque of 0.2 N·m"]),
        ("<position joint='port' kp='0.1'/>", ["loop about its angle, 0.1 N·m/rad,"]),
        ("<general joint='port' biastype='affine' biasprm='0 0 1'/>", ["loop about its speed, -1 N·m·s/rad,"]),
        ("<general joint='port' dyntype='filter' dynprm='0.2'/>", ["activation, dyntype filter 0.2,"]),
        ("<damper joint='port' kv='1' ctrlrange='0 1'/>", ["law, gaintype affine and biastype none,"]),
        (
            "<motor joint='port' gear='2' delay='0.1' nsample='3' armature='1e-4' damping='1'/>",
            ["delay of 0.1 s", "armature of 0.0004 kg·m²", "damping of 4 N·m·s/rad"],
        ),
        ("<motor joint='port' ctrlrange='0 0.02'/>", ["one-sided range, 0 to 0.02 in place of ±0.02,"]),
        ("<general joint='port' biasprm='1 1 -1'/>", []),  # which act with a biastype only
    ],
)
def test_what_a_motor_does_beside_its_torque_is_noted(tmp_path, motor, notes):
    adopted = tb.adopt(model(tmp_path, three_wheels(), motor + motors("bow", "keel")))
    assert adopted.notes == tuple(f"port: its motor's {note} is left out" for note in notes)


def test_what_acts_on_gyros_and_on_the_platform_itself_is_noted(tmp_path):
    spun = gyro("aft", "0.05 0 0").replace("name='aft_spin'", "name='aft_spin' damping='1e-6' frictionloss='1e-4'")
    servo = "<velocity joint='aft' kv='0.01'/><motor name='jet' site='nozzle' gear='1 0 0 0 0 0'/>"
    path = model(
        tmp_path,
        three_wheels() + spun + "<site name='nozzle'/>",
        motors(*AXES) + servo,
        joint="<joint name='orbit' type='free' damping='0.1'/>",
        more="<option density='1.2' viscosity='1e-5'/>",
    )
    assert tb.adopt(path).notes == (
        "orbit: its damping of 0.1 N·m·s/rad is left out",
        "aft_spin: its damping of 1e-06 N·m·s/rad is left out",
        "aft_spin: its dry friction of 0.0001 N·m is left out",
        "aft: its motor's loop about its speed, 0.01 N·m·s/rad, is left out",
        "actuators that turn no wheel, gimbal or rotor are left out: jet",
        "a medium of 1.2 kg/m³ and 1e-05 Pa·s is left out",
    )


def test_what_else_moves_in_the_world_is_noted(tmp_path):
    pole = "<body name='pole'><joint axis='1 0 0'/><geom size='.1' mass='2'/>{}</body>"
    lamp = "<body name='lamp'><joint axis='0 1 0'/><geom size='.1' mass='1'/></body>"
    floor = "<body name='floor'><geom size='.1' mass='9'/></body>"
    other = "<body name='other'><freejoint/><geom size='.1' mass='300'/></body>"
    unnamed = "<body><joint name='float' type='free'/><geom size='.1' mass='4'/></body>"
    world = f"<worldbody>{pole.format(lamp)}{floor}{other}{unnamed}</worldbody>"
    adopted = tb.adopt(model(tmp_path, three_wheels(), motors(*AXES), more=world))
    assert adopted.notes == (
        "pole: it is no part of the platform, and is left out with its 3 kg",
        "other: it is no part of the platform, and is left out with its 300 kg",
        "float: it is no part of the platform, and is left out with its 4 kg",
    )
    assert adopted.mass == pytest.approx(4.3)
    assert adopted.difference < 1e-12


def test_bodies_without_weight_on_a_bearing_are_noted(tmp_path):
    parts = three_wheels().replace("<body name='port'", "<body name='port' gravcomp='1'")
    joint = "<joint name='cup' type='ball' pos='0 0 1e-4' frictionloss='1e-4'/>"
    assert tb.adopt(model(tmp_path, parts, motors(*AXES), joint=joint)).notes == (
        "cup: its dry friction of 0.0001 N·m is left out",
        "the gravcomp of bodies is left out: port",
    )


def test_what_the_model_switches_off_is_neither_flown_nor_noted(tmp_path):
    rubbed = three_wheels("damping='1' frictionloss='1e-3' stiffness='1'")
    off = "<option><flag damper='disable' frictionloss='disable' spring='disable'/></option>"
    adopted = tb.adopt(model(tmp_path, rubbed, motors(*AXES), more=off))
    assert adopted.notes == ()
    assert adopted.difference < 1e-12


@pytest.mark.parametrize(
    ("parts", "actuators", "joint", "message"),
    [
        (
            three_wheels(),
            motors(*AXES),
            "",
            "lacks a body that is free to turn: give that of the platform a <freejoint/>",
        ),
        ("", "", "<freejoint/>", "lacks what a platform needs:\n  actuators: a reaction wheel is a hinge"),
        (
            "<body name='arm'><joint name='elbow' axis='1 0 0'/><geom type='box' size='.1 .1 .1' pos='0 .2 0'/></body>",
            "",
            "<freejoint/>",
            "the joint elbow is none: it turns what has its centre of mass 0.2 m off the axis\n  where a joint is one",
        ),
        (
            wheel("port", "0 1 0") + wheel("bow", "1 0 0"),
            motors("port", "bow"),
            "<freejoint/>",
            r"give no torque about \[0, 0, 1\] in body axes",
        ),
        (
            three_wheels().replace("mass='0.1'", "mass='1e-13' "),
            motors(*AXES),
            "<freejoint/>",
            "mass and inertia of moving bodies must be larger",
        ),
    ],
)
def test_a_model_that_lacks_something_is_refused_with_all_of_it(tmp_path, parts, actuators, joint, message):
    with pytest.raises(tb.InputError, match=message):
        tb.adopt(model(tmp_path, parts, actuators, joint=joint))


def test_a_name_that_is_not_there_is_answered_with_the_nearest(tmp_path):
    with pytest.raises(tb.InputError, match=r"^wheel prot: .* has no such joint or body; did you mean port\?"):
        tb.adopt(model(tmp_path, three_wheels(), motors(*AXES)), wheel=["prot"])


def test_corrections_that_no_joint_can_follow_are_refused(tmp_path):
    panel = f"<body name='panel'><joint name='drive' axis='1 0 0'/><geom size='.01'/>{wheel('spare', '0 1 0')}</body>"
    path = model(tmp_path, three_wheels() + panel, motors(*AXES))
    with pytest.raises(tb.InputError, match=r"^wheel spare: it turns on drive, .* ignore drive, which locks that"):
        tb.adopt(path, wheel=["spare"], rotor=[])
    assert roles(tb.adopt(path, wheel=["spare"], ignore=["drive"]))["spare"] == "wheel"
    with pytest.raises(tb.InputError, match=r"^rotor port: a gyro's rotor is carried by a hinge"):
        tb.adopt(path, rotor=["port"])
    with pytest.raises(
        tb.InputError, match=r"^wheel ship: the platform of .* has no such joint or body; they are port,"
    ):
        tb.adopt(path, wheel=["ship"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<html/>", r"begins with <html>; give an MJCF \(<mujoco>\) or a URDF \(<robot>\)"),
        ("<mujoco><worldbody>", "not a readable MJCF"),
        ("<mujoco><worldbody><replicate count='99999'><geom size='1'/></replicate></worldbody></mujoco>", "copies"),
        ("<robot name='a'><link name='b'/></robot>", "MuJoCo cannot read it: .* mass and inertia of moving bodies"),
        (
            "<mujoco><worldbody><body><freejoint/><geom size='1' mass='1e300'/></body></worldbody></mujoco>",
            r"has a body of more than 1e\+09 kg or kg·m²",
        ),
        (
            "<mujoco><worldbody><body><freejoint/>"
            + "<geom size='1'/><body><joint/><geom size='1'/></body>" * 200
            + "</body></worldbody></mujoco>",
            "has 201 joints; at most 200 are read",
        ),
        ("<robot name='a'><link name='world'/></robot>", "has no link that could be the platform"),
        ("<robot name='a'><link name='b'></robot>", "not a readable MJCF"),
    ],
)
def test_a_file_that_is_no_model_is_refused(tmp_path, text, message):
    path = tmp_path / "model.xml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(tb.InputError, match=message):
        tb.adopt(path)


def test_a_scenario_that_is_there_is_not_replaced(tmp_path):
    adopted = tb.adopt(model(tmp_path, three_wheels(), motors(*AXES)))
    adopted.save(tmp_path / "there.toml")
    with pytest.raises(tb.InputError, match=r"there.toml: exists"):
        adopted.save(tmp_path / "there.toml")


def test_a_joint_that_is_locked_with_a_spring_and_a_motor_is_noted(tmp_path):
    boom = (
        "<body name='boom' pos='0.1 0 0'><joint name='slide' type='slide' stiffness='4'/>"
        "<geom type='box' size='.02 .01 .01' mass='0.1'/></body>"
    )
    adopted = tb.adopt(model(tmp_path, three_wheels() + boom, motors(*AXES) + "<motor name='reel' joint='slide'/>"))
    assert adopted.notes == (
        "slide: it is locked as drawn, and its spring is left out",
        "actuators that turn no wheel, gimbal or rotor are left out: reel",
    )


def test_a_model_in_millimetres_is_refused(tmp_path):
    path = model(tmp_path, three_wheels(), motors(*AXES))
    path.write_text(path.read_text(encoding="utf-8").replace(".1 .12 .15", "100 120 150"), encoding="utf-8")
    with pytest.raises(tb.InputError, match=r"lengths in metres: .* more than of any spacecraft"):
        tb.adopt(path)


def test_motors_without_a_gear_turn_nothing(tmp_path):
    geared = "".join(f"<motor joint='{name}' gear='0' ctrlrange='-1 1'/>" for name in AXES)
    with pytest.raises(tb.InputError, match="the joint port is none: it has no motor"):
        tb.adopt(model(tmp_path, three_wheels(), geared))


def test_which_joints_are_locked_is_said_where_the_others_do_not_suffice(tmp_path):
    with pytest.raises(tb.InputError, match=r"give no torque about (.|\n)*the joint bow is locked: it as ignore says"):
        tb.adopt(model(tmp_path, three_wheels(), motors(*AXES)), ignore="bow")


def test_what_xacro_has_made_is_read_whatever_its_comments_say(tmp_path):
    path = model(tmp_path, three_wheels(), motors(*AXES))
    text = path.read_text(encoding="utf-8").replace("<worldbody>", "<!-- <xacro:wheel/> --><worldbody>")
    path.write_text(text, encoding="utf-8")
    assert list(roles(tb.adopt(path)).values()).count("wheel") == len(AXES)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"<robot xmlns:xacro='http://x'><xacro:wheel/></robot>", r"is a xacro.*run `xacro ship\.urdf`"),
        ("<mujoco/>".encode("utf-16"), "is UTF-16 text, which MuJoCo does not read; save it as UTF-8"),
    ],
)
def test_models_that_are_nearly_readable_are_named(tmp_path, text, words):
    path = tmp_path / "ship.urdf"
    path.write_bytes(text)
    with pytest.raises(tb.InputError, match=words):
        tb.adopt(path)
