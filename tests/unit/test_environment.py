"""What acts on a platform from outside: its torques against theory, its keys and what is refused of them."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from scipy.spatial.transform import Rotation

from testbed.assembly.control import tilts_along
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.cli.check import check_scenario
from testbed.cli.conceal import conceal_effects
from testbed.dynamics.environment import (
    EARTH,
    EARTH_RADIUS,
    Orbiting,
    Pivoted,
    gravity_basis,
    gravity_torque,
    local_axes,
    outside_torque,
    parallel_axes,
)
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.experiment.conduct import conduct
from testbed.experiment.planning import plan_maneuver
from testbed.plant.build import build
from testbed.plant.plant import Plant
from testbed.plant.properties import AirBearing, InitialState, PlatformProperties
from testbed.scenario.reader import read_body_scenario, read_scenario
from testbed.scenario.shipped import shipped_scenario

BEARING = tomllib.loads(shipped_scenario("air_bearing").read_text(encoding="utf-8"))
CUBESAT = tomllib.loads(shipped_scenario("cubesat_wheels").read_text(encoding="utf-8"))
ORBIT = {"kind": "orbit", "altitude_m": 4e5}
REST = np.array([1.0, 0.0, 0.0, 0.0])


def written(keys: dict, folder: Path, **changes) -> Path:
    merged = keys | {name: keys.get(name, {}) | value for name, value in changes.items()}
    path = folder / "scenario.toml"
    path.write_text(tomli_w.dumps(merged), encoding="utf-8")
    return path


# Torques


def test_gravity_pulls_the_centre_of_mass_below_the_pivot():
    weight, offset_B = 200.0, np.array([0.0, 0.0, -1e-3])
    for axis in np.eye(3)[:2]:  # tilted by a right angle, gravity turns it back with its whole moment
        up_B = Rotation.from_rotvec(np.pi / 2 * axis).inv().apply([0.0, 0.0, 1.0])
        np.testing.assert_allclose(gravity_torque(weight, up_B, offset_B), -0.2 * axis, atol=1e-12)
        np.testing.assert_allclose(gravity_basis(weight, up_B) @ offset_B, -0.2 * axis, atol=1e-12)


def test_a_platform_on_a_pivot_swings_as_a_pendulum_of_its_weight_does():
    """Small swings about the y axis: ω² = m g c / (J22 + m c²)."""
    inertia, mass, below = np.diag([0.6, 0.65, 0.9]), 20.0, 5e-3
    bearing = AirBearing(center_of_mass_B=np.array([0.0, 0.0, -below]), gravity=9.81)
    properties = PlatformProperties(units=0, inertia=inertia, mass=mass, step=1e-3, air_bearing=bearing)
    start = Rotation.from_rotvec([0.0, 1e-4, 0.0]).as_quat(scalar_first=True)
    still = InitialState(
        body_rate=np.zeros(3), attitude=start, position=np.zeros(3), velocity=np.zeros(3), gimbal_angle=np.zeros(0)
    )
    plant = Plant([build(properties)], initial=[still], rotor_momentum=np.zeros((1, 0)))
    period = 2.0 * np.pi * np.sqrt((0.65 + mass * below**2) / (mass * 9.81 * below))
    plant.advance(np.zeros((1, 0)), round(period / 1e-3))
    np.testing.assert_allclose(plant.qpos[0], start, atol=1e-8)  # a thousandth of a step is left of the period


def test_an_added_inertia_is_that_of_the_whole_mass_at_its_offset():
    offset = np.array([1e-3, -2e-3, 4e-3])
    expected = 3.0 * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    np.testing.assert_allclose(parallel_axes(3.0, offset), expected, atol=1e-18)


def test_local_axes_go_around_the_orbit_forward_first():
    orbit = Orbiting(rate=1e-3, field_L=np.zeros(3), torque_L=np.zeros(3), dipole_B=np.zeros(3))
    np.testing.assert_array_equal(local_axes(orbit, np.array(0.0)), np.eye(3))
    quarter = local_axes(orbit, np.array(np.pi / 2 / 1e-3))
    np.testing.assert_allclose(-quarter[:, 2], [1.0, 0.0, 0.0], atol=1e-12)  # up is now where forward was
    np.testing.assert_allclose(quarter[:, 1], [0.0, 1.0, 0.0], atol=1e-12)


def test_a_dipole_and_a_constant_torque_act_in_local_axes():
    orbit = Orbiting(
        rate=1e-3,
        field_L=np.array([3e-5, 0.0, 0.0]),
        torque_L=np.array([0.0, 1e-6, 0.0]),
        dipole_B=np.array([0.0, 0.0, 0.02]),
    )
    torque = outside_torque(orbit, 0.03 * np.eye(3), np.zeros(1), np.eye(3)[None], np.zeros((1, 3)))
    np.testing.assert_allclose(torque[0], [0.0, 0.02 * 3e-5 + 1e-6, 0.0], atol=1e-15)


def test_a_satellite_in_orbit_swings_about_the_vertical_as_it_should(tmp_path):
    """Pitch libration: ω² = 3 n² (J11 - J33) / J22 about the orbit's normal, for a long axis that is upright."""
    rate = np.sqrt(EARTH / (EARTH_RADIUS + 4e5) ** 3)
    start = Rotation.from_rotvec([0.0, 1e-3, 0.0]).as_quat(scalar_first=True)
    still = {"body_rate_rad_s": [0.0, -rate, 0.0], "attitude_quat_NB": start.tolist()}
    wheels = {"wheel_momentum_N_m_s": [0.0] * 4}
    path = written(
        CUBESAT | {"truth": {}, "gyro": {"sample_rate_hz": 1.0, "noise_rad_s": 0.0}},
        tmp_path,
        environment=ORBIT,
        initial=still | wheels,
        controller={"feedback": False},
        maneuver={"duration_s": 1500.0, "body_rate_rad_s": [[0.0, -rate, 0.0]] * 4},
        simulation={"duration_s": 1500.0, "step_s": 0.1, "control_rate_hz": 1.0, "telemetry_rate_hz": 1.0},
    )
    scenario = read_scenario(path)
    truth = true_platform(scenario)
    assert isinstance(truth.environment, Orbiting)
    attitude = _coasted(scenario, truth)
    angle = 2.0 * np.arcsin(attitude[:, 2]) + rate * np.arange(len(attitude))
    libration = np.sqrt(3.0 * rate**2 * (0.035 - 0.007) / 0.035)
    np.testing.assert_allclose(angle, 1e-3 * np.cos(libration * np.arange(len(attitude))), atol=2e-6)


def _coasted(scenario, truth):
    """Attitudes every second of a platform whose wheels are left alone."""
    from testbed.assembly.platform import true_plant

    plant = true_plant([(scenario, truth)])
    rows = []
    for _ in range(1500):
        rows.append(plant.qpos[0, plant.layout.attitude].copy())
        plant.advance(np.zeros((1, 0)), 10, np.zeros((1, 4)))
    return np.array(rows)


# Keys


def test_the_flown_centre_of_mass_is_that_of_truth(tmp_path):
    scenario = read_scenario(written(BEARING, tmp_path))
    nominal, true = nominal_platform(scenario).environment, true_platform(scenario).environment
    assert isinstance(nominal, Pivoted)
    assert isinstance(true, Pivoted)
    assert nominal.mass == pytest.approx(20.0)
    np.testing.assert_array_equal(nominal.offset_B, BEARING["environment"]["center_of_mass_offset_m"])
    np.testing.assert_array_equal(true.offset_B, BEARING["truth"]["center_of_mass_offset_m"])


@pytest.mark.parametrize(
    ("keys", "changes", "message"),
    [
        (CUBESAT, {"environment": {"kind": "free", "center_of_mass_offset_m": [0, 0, 0]}}, "unknown key"),
        (
            CUBESAT,
            {"truth": {"center_of_mass_offset_m": [1e-5, 0.0, 0.0]}},
            r'truth\.center_of_mass_offset_m: is of environment\.kind = "air_bearing", but it is "free"',
        ),
        (
            BEARING,
            {"truth": {"magnetic_dipole_A_m2": [0.0, 0.0, 0.1]}},
            r'is of environment\.kind = "orbit", but it is',
        ),
        (CUBESAT, {"environment": {"kind": "orbit", "altitude_m": -1e4}}, "greater than 0"),
        (CUBESAT, {"environment": {"kind": "orbit", "mean_motion_rad_s": 0.01}}, "an orbit below the ground"),
        (CUBESAT, {"environment": {"kind": "orbit"}}, "state one of them"),
        (CUBESAT, {"environment": ORBIT | {"mean_motion_rad_s": 1e-3}}, "state one of them"),
        (CUBESAT, {"environment": {"kind": "bearing"}}, "is 'bearing', which is unknown; use one of"),
        (BEARING, {"environment": {"gravity_m_s2": -9.81}}, r"should be at least 0\.01"),
        (BEARING, {"initial": {"position_m": [0.0, 0.0, 0.1]}}, "stands on a bearing; omit it"),
        (BEARING, {"initial": {"attitude_quat_NB": [0.8, 0.6, 0.0, 0.0]}}, r"is tilted by 1\.29 rad, more than"),
        (BEARING, {"estimation": {"alignments": True}}, "whose momentum is conserved"),
    ],
)
def test_what_does_not_belong_together_is_refused(keys, changes, message, tmp_path):
    with pytest.raises(InputError, match=message):
        read_scenario(written(keys, tmp_path, **changes))


def test_an_air_bearing_needs_a_mass(tmp_path):
    keys = BEARING | {"platform": {"inertia_kg_m2": BEARING["platform"]["inertia_kg_m2"]}}
    with pytest.raises(
        InputError, match=r"platform\.mass_kg: is missing; add it: on an air bearing gravity acts on it"
    ):
        read_scenario(written(keys, tmp_path))


def test_a_platform_that_is_only_measured_may_stand_on_a_bearing(tmp_path):
    sections = ("schema", "name", "description", "seed", "platform", "environment", "gyro", "estimation")
    scenario = read_body_scenario(written({name: BEARING[name] for name in sections}, tmp_path))
    assert scenario.environment.kind == "air_bearing"


def test_a_maneuver_that_tilts_too_far_is_refused_when_it_is_checked_and_flown(tmp_path):
    path = written(BEARING, tmp_path, environment={"tilt_limit_rad": 0.05})
    scenario = read_scenario(path)
    with pytest.raises(InputError, match=r"tilts the platform by 0\.\d+ rad at .* beyond environment\.tilt_limit_rad"):
        plan_maneuver(scenario, nominal_platform(scenario))
    with pytest.raises(InputError, match="lower its rates about x and y"):
        check_scenario(str(path), ())


def test_a_design_keeps_within_the_tilt_that_the_bearing_allows(tmp_path):
    design = {
        "kind": "design",
        "parametrization": "body_rate",
        "criterion": "D",
        "constraint": "hard",
        "envelope_fraction": 0.7,
        "body_rate_limit_rad_s": 0.3,
        "duration_s": 10.0,
        "control_points": 10,
        "starts": 1,
        "seed": 1,
        "sample_rate_hz": 10.0,
        "prefilter_time_constant_s": 1.0,
    }
    keys = BEARING | {"maneuver": design}
    scenario = read_scenario(written(keys, tmp_path, simulation={"duration_s": 10.0}))
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    largest = tilts_along(scenario, maneuver, np.linspace(0.0, 10.0, 1001)).max()
    assert 0.9 * scenario.environment.tilt_limit_rad < largest < scenario.environment.tilt_limit_rad


def test_the_momentum_of_a_flight_on_a_bearing_changes_by_gravity_alone(tmp_path):
    """About the pivot, by MuJoCo's own momentum and gravity against the formula along the attitude as flown."""
    scenario = read_scenario(written(BEARING, tmp_path, estimation={"estimators": ["ls"]}))
    flown = conduct(scenario, seed=1).flown
    momentum_N = flown.record.channels["true_total_momentum"]
    assert np.abs(momentum_N - momentum_N[0]).max() > 0.05
    assert flown.summary.momentum_drift < 1e-9
    assert flown.summary.largest_tilt < scenario.environment.tilt_limit_rad


def test_the_concealing_engine_says_that_it_flies_freely(tmp_path):
    with pytest.raises(InputError, match=r'environment\.kind is "air_bearing", but the concealing engine'):
        conceal_effects(str(written(BEARING, tmp_path)), tmp_path / "out", (), 1, drawn=True, size=None, runs=2)


def test_the_cubesat_in_orbit_learns_its_inertia_beside_what_its_environment_does():
    scenario = read_scenario(shipped_scenario("orbit_wheels"))
    experiment = conduct(scenario, seed=90051)
    assert experiment.outcome == "completed"
    true = theta_of(np.array(scenario.truth.inertia_kg_m2))
    for name, estimate in experiment.estimation.by_name.items():
        std = np.sqrt(np.diag(estimate.covariance)[:6])
        print(name, ((estimate.theta - true) / std).round(2), (1e6 * std).round(2), "1e-6 kg·m²")
        np.testing.assert_array_less(np.abs(estimate.theta - true), 4.0 * std)
