"""The concealing engine's own mechanics: momentum and energy body by body, its integrator, and MuJoCo beside it."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from concealing.case import Case, Run
from concealing.craft import PlatformNumbers, nominal_craft
from concealing.flight import follow
from concealing.flown import fly_case
from concealing.guidance import planned_maneuver, software_of
from concealing.integration import step
from concealing.mechanics import Inputs, Mechanics
from support.platforms import initial, plant, restless_torque
from testbed.experiment.flying import fly_maneuver
from testbed.plant.build import build
from testbed.plant.properties import PlatformProperties

SCENARIO = Path(__file__).parents[2] / "scenarios" / "diagnose.toml"
NUMBERS = PlatformNumbers(
    inertia=np.array([[0.022, 0.0004, 0.0], [0.0004, 0.023, -0.0002], [0.0, -0.0002, 0.027]]),
    mass=4.0,
    units=6,
    skew_deg=63.9,
    mounting_radius=0.06,
    rotor_momentum=0.004714,
    spin_inertia=1e-5,
    transverse_inertia=5.3e-6,
    gimbal_inertia=3e-6,
    torque_limit=0.015,
    servo_bandwidth=50.0,
)
PERIOD = 0.0125
RELEASED = np.array([0.05, -0.1, 0.08])
FINE_STEP = PERIOD / 40  # MuJoCo's RK4 is within 3e-12 rad/s of its limit there, 7e-10 at the shipped 1.25 ms


def mechanics(craft=None, runs=1):
    return Mechanics(
        craft=nominal_craft(NUMBERS) if craft is None else craft,
        epoch=np.zeros(runs),
        release_attitude=np.broadcast_to(np.eye(3), (runs, 3, 3)),
    )


def momentum_and_energy(craft, angle, body_rate, gimbal_rate, rotor_speed):
    """Sum over bus, gimbals and rotors, each with its own angular velocity; body axes."""
    units = craft.units
    change = (units.spin_inertia - units.transverse_inertia)[:, None, None]
    round_part = (units.transverse_inertia + units.gimbal_inertia)[:, None, None] * np.eye(3)
    bus = craft.inertia - (round_part + change * np.einsum("mi,mj->mij", units.spin_axis, units.spin_axis)).sum(0)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    spin = units.spin_axis * cos + units.transverse_axis * sin
    rotor = units.transverse_inertia[:, None, None] * np.eye(3) + change * np.einsum("mi,mj->mij", spin, spin)
    gimbal_velocity = body_rate + gimbal_rate[:, None] * units.gimbal_axis
    rotor_velocity = gimbal_velocity + rotor_speed[:, None] * spin
    momenta = [
        bus @ body_rate,
        *(units.gimbal_inertia[:, None] * gimbal_velocity),
        *np.einsum("mij,mj->mi", rotor, rotor_velocity),
    ]
    rates = [body_rate, *gimbal_velocity, *rotor_velocity]
    return np.sum(momenta, axis=0), 0.5 * sum(float(np.dot(*pair)) for pair in zip(momenta, rates, strict=True))


def at(engine, state, time=0.0):
    """Momentum in inertial axes and kinetic energy of the one run."""
    angle = state[0, engine.slices["angle"]]
    velocities = engine.velocities(time, state)
    momentum_B, energy = momentum_and_energy(engine.craft, angle, *(value[0] for value in velocities))
    return state[0, engine.slices["attitude"]].reshape(3, 3) @ momentum_B, energy


@pytest.fixture(scope="module")
def driven():
    """One second of restless gimbals."""
    engine = mechanics()
    start = engine.start(RELEASED[None], np.full((1, 6), 0.3))
    return engine, follow(engine, start, lambda tick: restless_torque(tick * PERIOD)[None], PERIOD, 80)


def test_momentum_summed_over_the_bodies_is_conserved(driven):
    engine, states = driven
    momenta = np.array([at(engine, state)[0] for state in states])
    # The state's own momentum is constant by construction; the bodies' sum follows it to rounding.
    drift = np.abs(momenta - momenta[0]).max() / (6 * NUMBERS.rotor_momentum)
    assert np.abs(engine.velocities(0.0, states[-1]).gimbal_rate).max() > 0.5  # something moved
    assert drift <= 1e-12


def test_power_of_motors_and_servos_is_the_change_of_energy(driven):
    engine, states = driven
    for tick in (10, 40, 70):
        state, inputs = states[tick], Inputs(restless_torque(tick * PERIOD)[None])
        slope = engine.derivative(0.0, state, inputs)
        _, gimbal_rate, rotor_speed = (value[0] for value in engine.velocities(0.0, state))
        motor = engine.motor_torque(state, gimbal_rate[None], inputs.gimbal_torque)[0]
        power = motor @ gimbal_rate + slope[0, engine.slices["l"]] @ rotor_speed
        nudge = 1e-4
        ahead, behind = (at(engine, state + sign * nudge * slope)[1] for sign in (1.0, -1.0))
        # Central differences: rounding of 6.7 J over the nudge is 1e-11 W, of a power of 1e-4 to 1e-3 W.
        assert (ahead - behind) / (2.0 * nudge) == pytest.approx(power, abs=2e-9)
        assert abs(power) > 1e-5


def test_order_of_the_integrator():
    def error(size):
        state, matrix = np.array([1.0, 0.0]), np.array([[0.0, 1.0], [-1.0, 0.0]])
        for index in range(round(4.0 / size)):
            state = step(lambda _, value: matrix @ value, index * size, state, size)
        return np.abs(state - [np.cos(4.0), -np.sin(4.0)]).max()

    assert np.log2(error(1.0) / error(0.5)) == pytest.approx(8.0, abs=1.0)


def test_fixed_steps_are_exact_enough(driven):
    engine, states = driven
    start, inputs = states[20], Inputs(restless_torque(20 * PERIOD)[None])
    exact = (
        solve_ivp(
            lambda time, flat: engine.derivative(time, flat.reshape(start.shape), inputs).ravel(),
            (20 * PERIOD, 21 * PERIOD),
            start.ravel(),
            method="DOP853",
            rtol=1e-12,
            atol=1e-16,
        )
        .y[:, -1]
        .reshape(start.shape)
    )
    error = engine.velocities(0.0, exact).body_rate - engine.velocities(0.0, states[21]).body_rate
    assert np.abs(error).max() <= 1e-12  # in one period; over 5 s halving the steps changes the rate by 8e-12
    flown = engine.start(RELEASED[None], np.full((1, 6), 0.3))
    finer = follow(engine, flown, lambda tick: restless_torque(tick * PERIOD)[None], PERIOD, 80, refinement=2)
    change = engine.velocities(0.0, finer[-1]).body_rate - engine.velocities(0.0, states[-1]).body_rate
    assert np.abs(change).max() <= 1e-10


def test_given_torques_fly_as_in_mujoco():
    properties = PlatformProperties(
        inertia=NUMBERS.inertia, mass=4.0, rotor_momentum=np.full(6, 0.004714), step=FINE_STEP
    )
    craft = plant(build(properties), initial(body_rate=RELEASED))
    engine, rates = mechanics(), [RELEASED]
    for tick in range(400):
        craft.advance(restless_torque(tick * PERIOD), 40)
        rates.append(craft.body_rate.copy())
    start = engine.start(RELEASED[None], np.zeros((1, 6)))
    states = follow(engine, start, lambda tick: restless_torque(tick * PERIOD)[None], PERIOD, 400)
    flown = [engine.velocities(0.0, state).body_rate[0] for state in states]
    error = np.abs(np.array(rates) - flown).max()
    print(f"body rate against MuJoCo, given torques, 5 s: {error:.1e} rad/s")
    assert error <= 1e-10


def test_closed_loop_flies_as_in_mujoco():
    case = Case(scenario=SCENARIO, seed=1, runs=(Run(duration=5.0, maneuver=0, planned_spin=(0.1, 0.0, -0.1)),))
    flown, known = fly_case(case, quiet=True), software_of(SCENARIO)
    scenario, spin = known.scenario, case.runs[0].planned_spin
    scenario = scenario.model_copy(
        update={
            "gyro": scenario.gyro.model_copy(update={"noise_rad_s": 0.0}),
            "encoder": scenario.encoder.model_copy(update={"noise_rad": 0.0}),
            "initial": scenario.initial.model_copy(update={"body_rate_rad_s": spin}),
            "controller": scenario.controller.model_copy(
                update={"feedback_gain_1_s": known.controller(80.0, 16.0, feedback=True).tracker.gain}
            ),
        }
    )
    maneuver = planned_maneuver(SCENARIO, 0, spin)
    rate = fly_maneuver(scenario, known.nominal, known.nominal, maneuver, 1).record.channels["true_body_rate"]
    error = np.abs(rate - flown.log.body_rate[:, 0]).max()
    print(f"body rate against MuJoCo, closed loop, 5 s: {error:.1e} rad/s")
    # The shipped 1.25 ms step is within 1e-9 rad/s; at 0.31 ms the two differ by 6e-12.
    assert error <= 1e-8


def test_physics_effects_and_sensors_use_nothing_of_the_testbed():
    package = Path(__file__).parents[2] / "concealing"
    users = {
        path.name
        for path in package.glob("*.py")
        if re.search(r"^\s*(from|import) testbed", path.read_text(), re.MULTILINE)
    }
    # The controller and its maneuvers, writing records, also of a rig, and the nominal MJCF that another engine flies.
    assert users == {
        "guidance.py",
        "make_maneuvers.py",
        "files.py",
        "sealing.py",
        "wheel_set.py",
        "rig.py",
        "mujoco_craft.py",
    }
