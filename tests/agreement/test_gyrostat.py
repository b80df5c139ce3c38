"""The compiled equations of motion against MuJoCo, at the same step, in the closed loop and with driven motors."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

from support.platforms import ROTOR_MOMENTUM, initial, restless_torque
from testbed.assembly.platform import nominal_platform, true_plant, true_platform
from testbed.cmg.wheels import wheel_axes
from testbed.errors import InputError
from testbed.experiment.flying import Sortie, prepare_flight
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.profiles import basic_profile
from testbed.plant.build import build
from testbed.plant.geometry import total_momentum
from testbed.plant.gyrostat import uncovered
from testbed.plant.plant import Plant
from testbed.plant.properties import AirBearing, PlatformProperties, WheelProperties
from testbed.scenario.maneuver import Designed
from testbed.scenario.reader import read_scenario
from testbed.simulation.loop import fly

SCENARIOS = sorted((Path(__file__).resolve().parents[2] / "scenarios").glob("*.toml"))
LONGEST = 5.0
"""s, of the scenarios that fly for minutes."""
PERIOD = 0.0125
SCALE = 6.0 * ROTOR_MOMENTUM


def flyable(path):
    try:
        scenario = read_scenario(path)
        return not scenario.cabin
    except InputError:  # it is only measured
        return False


@pytest.mark.parametrize("path", [path for path in SCENARIOS if flyable(path)], ids=lambda path: path.stem)
def test_a_flight_of_every_shipped_scenario_is_that_of_mujoco(path):
    """At the shipped steps, where both have converged: body rates within 2.5e-10 rad/s (orbit), else 2e-11."""
    scenario = read_scenario(path)
    nominal, truth = nominal_platform(scenario), true_platform(scenario)
    designed = isinstance(scenario.maneuver, Designed)
    maneuver = basic_profile(duration=LONGEST) if designed else plan_maneuver(scenario, nominal).maneuver
    steering = scenario.controller.steering
    if designed and steering.preferred_gimbal_angle_rad == "maneuver":
        steering = steering.model_copy(update={"preferred_gimbal_angle_rad": "zero"})
    scenario = scenario.model_copy(
        update={
            "controller": scenario.controller.model_copy(update={"steering": steering}),
            "simulation": scenario.simulation.model_copy(update={"duration_s": LONGEST}),
        }
    )
    flight = prepare_flight(scenario, [Sortie(scenario=scenario, truth=truth, seed=3)], nominal, maneuver)
    logs, layout = {}, None
    for engine in ("mujoco", "compiled"):
        plant = true_plant([(scenario, truth)], engine=engine)
        (outcome,) = fly(plant, flight)
        assert not outcome.divergence
        logs[engine], layout = outcome.log, plant.layout
    apart = [np.abs(getattr(logs["mujoco"], name) - getattr(logs["compiled"], name)) for name in ("qvel", "qpos")]
    assert apart[0][:, layout.body_rate].max() < 1e-9
    assert apart[1][:, layout.attitude].max() < 1e-9
    assert apart[1][:, layout.position].max(initial=0.0) < 1e-9
    torques = np.abs(logs["mujoco"].joint_torque - logs["compiled"].joint_torque)
    assert torques.max() < 1e-5 * np.abs(logs["mujoco"].joint_torque).max()


def plant_of(properties, engine, *, rate=(0.1, -0.2, 0.15), threads=1, count=1, rotors="constant_speed"):
    model = build(properties)
    assert not list(uncovered(model))
    momentum = np.zeros(0) if not properties.units else np.full(properties.units, ROTOR_MOMENTUM)
    wheels = np.linspace(-0.001, 0.002, len(properties.wheels))
    start = initial(body_rate=np.array(rate), gimbal_angle=np.linspace(-0.4, 0.6, properties.units))
    return Plant(
        [model] * count,
        initial=[replace(start, attitude=np.array([0.8, 0.36, -0.48, 0.0])) for _ in range(count)],
        rotor_momentum=np.tile(momentum, (count, 1)),
        rotor_momentum_limit=0.0052,
        rotors=rotors,
        wheel_momentum=np.tile(wheels, (count, 1)),
        wheel_momentum_limit=np.full(len(wheels), 0.0022),
        threads=threads,
        engine=engine,
    )


def driven(plant, step, seconds=2.0, torque=1.0):
    """Drive all motors restlessly; returns body rates at every control period, and all states of the first platform."""
    units, wheels = len(plant.layout.gimbal_angle), len(plant.layout.wheel_angle)
    states = [(plant.qpos[0].copy(), plant.qvel[0].copy())]
    for tick in range(round(seconds / PERIOD)):
        now = torque * restless_torque(tick * PERIOD)
        plant.advance(now[:units], round(PERIOD / step), 3.0 * now[:wheels] if wheels else None)
        states.append((plant.qpos[0].copy(), plant.qvel[0].copy()))
    assert not plant.divergence
    qpos, qvel = map(np.array, zip(*states, strict=True))
    return qvel[:, plant.layout.body_rate], qpos, qvel


def wheels_with(**changes):
    stated = {"mass": 0.06, "spin_inertia": 1.5e-5, "transverse_inertia": 8e-6, "torque_limit": 1e-3}
    axes = wheel_axes("pyramid", 4, radians(54.74))
    return tuple(WheelProperties(axis_B=axis, position_B=0.05 * axis, **(stated | changes)) for axis in axes)


INERTIA = np.array([[0.022, 0.001, 0.0], [0.001, 0.024, 0.0005], [0.0, 0.0005, 0.027]])
BEARING = AirBearing(center_of_mass_B=np.array([1e-4, -2e-4, -5e-4]), gravity=9.81, drag=2e-4)
PLATFORMS = {
    "gyros that strike their limits": (PlatformProperties(gimbal_torque_limit=4e-4), 2.0),
    "misaligned gyros": (PlatformProperties(misalignment=np.linspace(-0.1, 0.1, 12).reshape(6, 2)), 1.0),
    "a roof": (PlatformProperties(units=4, array="roof", skew=0.6, mounting_radius=0.06), 1.0),
    "wheels with friction, a loop and a lag": (
        PlatformProperties(
            units=0,
            mass=4.0,
            inertia=INERTIA,
            wheels=wheels_with(viscous_friction=2e-6, speed_loop_bandwidth=4.0, motor_lag=0.05, torque_factor=0.9),
        ),
        1.0,
    ),
    "gyros and wheels on a bearing": (
        PlatformProperties(inertia=INERTIA, mass=4.0, wheels=wheels_with(), air_bearing=BEARING),
        1.0,
    ),
}


@pytest.mark.parametrize("name", PLATFORMS)
def test_driven_motors_move_a_platform_as_in_mujoco(name):
    """At a quarter of the shipped step; where a limit is struck within a step, either rule errs by its square."""
    properties, torque = PLATFORMS[name]
    step = 0.00125 / 4
    properties = replace(properties, step=step)
    theirs, ours = (driven(plant_of(properties, engine), step, torque=torque) for engine in ("mujoco", "compiled"))
    assert np.abs(theirs[0] - ours[0]).max() < (1e-7 if "limits" in name else 1e-9)
    moved = np.abs(np.ptp(theirs[0], axis=0)).min()
    assert moved > 0.01


@pytest.mark.parametrize("rotors", ["free", "constant_speed"])
def test_momentum_is_kept_to_rounding(rotors):
    properties = PlatformProperties(wheels=wheels_with(viscous_friction=2e-6))
    plant = plant_of(properties, "compiled", rotors=rotors)
    _, qpos, qvel = driven(plant, 0.00125, seconds=5.0)
    for momentum_N in (total_momentum(plant.models[0], qpos, qvel), plant.total_momentum(0, qpos, qvel)):
        assert np.linalg.norm(momentum_N - momentum_N[0], axis=1).max() / SCALE <= 1e-12
    assert np.abs(qvel[:, plant.layout.gimbal_rate]).max(axis=0).min() > 0.2, "every gimbal has to move"


def test_the_order_is_four():
    def rates(step):
        return driven(plant_of(PlatformProperties(step=step), "compiled", rotors="free"), step, seconds=2.0)[0]

    exact = rates(0.00125 / 4)
    errors = [np.abs(rates(step) - exact).max() for step in (0.00625, 0.003125)]
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.6
    assert errors[1] > 1e-12, "above rounding, or the order would say nothing"


def test_a_platform_alone_in_a_batch_and_on_threads_has_the_same_bits():
    alone = driven(plant_of(PlatformProperties(), "compiled"), 0.00125, seconds=0.5)
    for count, threads in ((7, 1), (7, 3)):
        together = driven(
            plant_of(PlatformProperties(), "compiled", count=count, threads=threads), 0.00125, seconds=0.5
        )
        for one, other in zip(alone, together, strict=True):
            np.testing.assert_array_equal(one, other)


def test_what_diverges_stays_in_its_last_finite_state():
    plant = plant_of(PlatformProperties(step=0.02), "compiled")  # the rotor servo's 300 1/s · 0.02 s is beyond 2.8
    for tick in range(200):
        plant.advance(restless_torque(tick * PERIOD), 10)
    assert "diverged between t =" in plant.divergence[0]
    assert np.isfinite(plant.qvel).all()


def test_what_the_equations_do_not_have_is_named():
    cases = {
        "cabin": PlatformProperties(cabin_size=np.full(3, 2.0)),
        "dry friction": PlatformProperties(wheels=wheels_with(coulomb_friction=1e-6)),
        "wheel2_rotor, whose centre of mass": PlatformProperties(
            wheels=tuple(
                replace(wheel, imbalance=1e-7) if index == 1 else wheel for index, wheel in enumerate(wheels_with())
            )
        ),
    }
    for words, properties in cases.items():
        (reason,) = uncovered(build(properties))
        assert words in reason


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda model: model.dof_armature.__setitem__(slice(6, 8), 1e-6), "armatures"),
        (lambda model: model.body_inertia.__setitem__((model.body("cmg1_rotor").id, 1), 6e-6), "cmg1_rotor, whose"),
        (lambda model: model.body_ipos.__setitem__((model.body("bus").id, 0), 1e-3), "centre of mass"),
        (lambda model: model.actuator_gear.__setitem__((0, 0), 2.0), "none of the usual"),
        (lambda model: model.actuator_biasprm.__setitem__((0, 1), 1.0), "none of the usual"),
        (lambda model: model.jnt_limited.__setitem__(1, 1), "joints with ends"),
        (lambda model: setattr(model.opt, "density", 1.2), "medium"),
    ],
)
def test_a_model_that_was_changed_by_hand_is_looked_at(change, words):
    model = build(PlatformProperties())
    assert not list(uncovered(model))
    change(model)
    assert any(words in reason for reason in uncovered(model))
