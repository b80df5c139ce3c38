"""The concealing engine's craft with wheels: conservation laws, MuJoCo beside it, what the testbed says of effects."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from concealing.effect import HiddenEffect
from concealing.integration import step
from concealing.wheel_case import WheelCase, WheelRun, platform_of
from concealing.wheel_effects import OF_BEARINGS, OF_WHEELS, WHEELS
from concealing.wheel_flight import fly_wheels, left_unexplained, planned, signal
from concealing.wheel_set import wheel_record
from concealing.wheels import WheelInputs, WheelMechanics
from testbed.assembly.platform import nominal_platform, true_plant, true_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.cmg.wheels import turned_wheel_axes, wheel_axes
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.prediction.grid import grid_of
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario

SCENARIOS = Path(__file__).parents[2] / "scenarios"
FREE, STANDING = SCENARIOS / "cubesat_wheels.toml", SCENARIOS / "air_bearing.toml"
BOTH = pytest.mark.parametrize("scenario", [FREE, STANDING], ids=["free", "bearing"])


def case_of(scenario, *effects, runs=1, seconds=8.0, at_rest=False):
    moment = platform_of(scenario).inertia[2, 2]
    return WheelCase(
        scenario=scenario,
        seed=1,
        runs=tuple(
            WheelRun(duration=seconds, motion=index, at_rest=at_rest, release_error=(0.002, -0.003, 0.001))
            for index in range(runs)
        ),
        effects=effects,
        theta_error=tuple(moment * np.array([0.03, -0.02, 0.04, 0.01, -0.02, 0.01])),
    )


def total_momentum(flown):
    """L in inertial axes of every run, from rates and speeds."""
    log, wheels = flown.log, flown.craft.wheels
    attitude = log.state[..., :9].reshape(*log.state.shape[:2], 3, 3)
    held = (wheels.spin_inertia * log.wheel_speed) @ wheels.axis
    return np.einsum("kbij,kbj->kbi", attitude, log.body_rate @ flown.craft.turned_inertia + held), attitude


def test_a_free_craft_keeps_its_momentum_and_its_frame():
    flown = fly_wheels(case_of(FREE, runs=2, seconds=60.0), quiet=True)
    momentum, attitude = total_momentum(flown)
    drift = np.abs(momentum - momentum[0]).max() / np.abs(momentum[0]).max()
    assert drift < 1e-10
    assert np.abs(attitude @ np.swapaxes(attitude, -1, -2) - np.eye(3)).max() < 1e-10


def test_on_a_bearing_gravity_alone_changes_the_momentum_and_not_about_the_vertical():
    flown = fly_wheels(case_of(STANDING, seconds=30.0), quiet=True)
    momentum, attitude = total_momentum(flown)
    momentum, attitude = momentum[:, 0], attitude[:, 0]
    assert np.ptp(momentum[:, 2]) < 1e-10
    weight_N = np.cross(attitude @ flown.craft.weight_arm, [0.0, 0.0, -1.0])
    period = flown.clock.period
    # Simpson's rule over two periods, exact to the fourth derivative of a pendulum's torque.
    gained = (weight_N[:-2:2] + 4.0 * weight_N[1:-1:2] + weight_N[2::2]).sum(axis=0) * period / 3.0
    assert np.abs(momentum[-1] - momentum[0] - gained).max() < 1e-9
    assert np.abs(gained).max() > 1e-3


@BOTH
def test_the_energy_grows_by_the_work_of_the_motors(scenario):
    """Without friction: ½ ωᵀ (J - Σ Js a aᵀ) ω + Σ l² / (2 Js) + m g c·u, and τ Ω integrated beside the states."""
    flown = fly_wheels(case_of(scenario), quiet=True)
    still = replace(flown.craft.wheels, viscous=np.zeros(4))
    craft = replace(flown.craft, wheels=still)
    mechanics = WheelMechanics(
        craft=craft, epoch=np.zeros(1), release_attitude=np.eye(3)[None], wheel_speed=flown.log.wheel_speed[0]
    )
    torque = 0.3 * craft.wheels.torque_limit * np.array([[1.0, -0.5, 0.7, 0.2]])

    def energy(state):
        rate, held = mechanics.velocities(0.0, state).body_rate[0], state[0, mechanics.slices["wheel"]]
        inertia = craft.turned_inertia - np.einsum("w,wi,wj->ij", still.spin_inertia, still.axis, still.axis)
        weight = 0.0 if craft.pivot is None else state[0, 6:9] @ craft.weight_arm
        return 0.5 * rate @ inertia @ rate + (held**2 / (2.0 * still.spin_inertia)).sum() + weight

    def derivative(time, states):
        change = mechanics.derivative(time, states[:, :-1], WheelInputs(torque))
        work = (torque * mechanics.speeds(time, states[:, :-1])).sum(axis=1, keepdims=True)
        return np.concatenate([change, work], axis=1)

    state = mechanics.start(flown.log.body_rate[0], np.zeros((1, 0)))
    states = np.concatenate([state, np.zeros((1, 1))], axis=1)
    for index in range(200):
        states = step(derivative, 0.02 * index, states, 0.02)
    gained = energy(states[:, :-1]) - energy(state)
    assert gained == pytest.approx(states[0, -1], rel=1e-9)
    assert abs(gained) > 1e-4 * energy(state)


@BOTH
def test_mujoco_flies_the_same_under_the_same_motor_torques(scenario):
    """At the shipped step of 5 ms both are exact to rounding: 2e-14 rad/s were found."""
    flown = fly_wheels(case_of(scenario, seconds=10.0), quiet=True)
    shipped, log = read_scenario(scenario), flown.log
    keys = shipped.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    keys["truth"] = {"inertia_kg_m2": flown.craft.inertia.tolist()}
    keys["initial"] = {
        "body_rate_rad_s": log.body_rate[0, 0].tolist(),
        "wheel_momentum_N_m_s": (flown.craft.wheels.spin_inertia * log.wheel_speed[0, 0]).tolist(),
    }
    changed = Scenario.model_validate(keys)
    plant = true_plant([(changed, true_platform(changed))])
    layout, steps, error = plant.layout, round(flown.clock.period / shipped.simulation.step_s), 0.0
    for tick in range(flown.clock.ticks):
        plant.advance(np.zeros((1, 0)), steps, log.torque[tick + 1])
        error = max(error, float(np.abs(plant.qvel[0, layout.body_rate] - log.body_rate[tick + 1, 0]).max()))
    print(f"body rate against MuJoCo, 10 s: {error:.1e} rad/s")
    assert error < 1e-12


@BOTH
def test_wheels_stand_where_the_testbed_has_them(scenario):
    wheels = platform_of(scenario).wheels
    believed = nominal_platform(read_scenario(scenario)).wheels
    assert wheels.axis == pytest.approx(wheel_axes("pyramid", 4, np.deg2rad(54.74)), abs=1e-15)
    assert wheels.spin_inertia == pytest.approx(believed.spin_inertia)
    turned = hidden("wheel_misalignment", "wheel2", about_first=0.02, about_second=-0.01)
    moved = fly_wheels(case_of(scenario, turned, seconds=0.1), quiet=True).craft.wheels.axis
    turns = np.zeros((4, 2))
    turns[1] = 0.02, -0.01
    assert moved == pytest.approx(turned_wheel_axes(wheels.axis, turns), abs=1e-15)


def hidden(effect, component, **parameters):
    return HiddenEffect(effect=effect, component=component, parameters=parameters)


@BOTH
def test_without_an_effect_the_nominal_model_leaves_nothing_and_motions_keep_the_limits(scenario):
    case = case_of(scenario, runs=3, seconds=25.0, at_rest=True)
    assert signal(case) < 0.2  # sigma, of a thousand samples and more
    flown, platform = fly_wheels(case, quiet=True), platform_of(scenario)
    assert np.abs(left_unexplained(flown)).max() < 0.01 * platform.sensors.gyro_noise
    assert np.abs(flown.log.command).max() < platform.wheels.torque_limit[0]
    tilt = np.arccos(flown.log.state[:, :, 8].min())
    assert tilt < platform.tilt_limit
    plan = planned(platform, case.runs[0], flown.clock)
    assert np.abs(flown.log.body_rate[:, 0]).max() > 0.03  # it turns
    assert np.abs(plan.speed[:, 0] - flown.log.wheel_speed[:, 0, 0]).max() < 0.05 * np.ptp(plan.speed[:, 0])


TYPICAL = {
    "wheel_inertia": {"relative_error": 0.01},
    "wheel_misalignment": {"about_first": 0.01, "about_second": -0.007},
    "wheel_speed_bias": {"bias": 5.0},
    "center_of_mass_offset": {"offset_x": 2e-5, "offset_y": -1e-5, "offset_z": 3e-5},
    "air_drag": {"coefficient": 1e-3},
}
SIGNED = [
    *((FREE, each, "wheel3") for each in OF_WHEELS),
    *((STANDING, each, "wheel2") for each in OF_WHEELS),
    *((STANDING, each, "platform") for each in OF_BEARINGS),
]


@pytest.mark.parametrize(("scenario", "effect", "component"), SIGNED)
def test_the_testbed_explains_an_effect_by_the_same_parameters(scenario, effect, component):
    """Its prediction with them leaves next to nothing of what it leaves without."""
    case = case_of(scenario, hidden(effect, component, **TYPICAL[effect]))
    flown, read = fly_wheels(case, quiet=True), read_scenario(scenario)
    telemetry = telemetry_of(wheel_record(flown, 0), read, nominal_platform(read))
    grid = grid_of([telemetry])

    def missed(hooks, *sizes):
        values = Values(
            theta=theta_of(flown.craft.inertia)[None],
            initial_rate=flown.log.body_rate[:1],
            effects=tuple(np.array([each]) for each in sizes),
        )
        reading = predicted(grid, hooks, values)[0][0]
        return float(np.abs(telemetry.body_rate - reading).max())

    alone = missed([])
    explained = missed([EFFECTS[effect].hooks(component)], list(TYPICAL[effect].values()))
    print(f"{effect}: {alone:.1e} rad/s without, {explained:.1e} with")
    assert explained < 5e-6 + 0.01 * alone
    assert alone > 1e-5


def test_wheels_are_as_many_as_effects_know():
    assert len(platform_of(FREE).wheels.axis) == len(platform_of(STANDING).wheels.axis) == len(WHEELS)
