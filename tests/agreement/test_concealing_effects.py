"""The concealing engine's effects, each against its own physics: sign, size, and what has to be conserved."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from concealing.case import Case, Run
from concealing.craft import nominal_craft
from concealing.effect import HiddenEffect, scaled
from concealing.files import record
from concealing.flight import follow
from concealing.flown import fly_case
from concealing.library import KINDS, LISTED, with_effects
from concealing.mechanics import Inputs
from support.platforms import initial, plant
from testbed.cmg.misalignment import turned_axes
from testbed.plant.build import shipped_model, specification
from testbed.plant.properties import PlatformProperties
from tests.agreement.test_concealing import FINE_STEP, NUMBERS, PERIOD, RELEASED, SCENARIO, mechanics

SPIN_Z = np.array([[0.0, 0.0, 0.4]])
INERTIA_Z = 0.027
BARE = nominal_craft(NUMBERS._replace(units=0, inertia=np.diag([0.022, 0.022, INERTIA_Z])))
UNIT = "cmg3"


def with_one(craft, effect, component="platform", **parameters):
    return with_effects(craft, [HiddenEffect(effect=effect, component=component, parameters=parameters)])


def xyz(stem, *values):
    return dict(zip((f"{stem}_x", f"{stem}_y", f"{stem}_z"), values, strict=True))


def free_flight(craft, released=SPIN_Z, seconds=1.0):
    """Fly a craft whose motors ask for nothing; return the engine, tick times and states."""
    engine = mechanics(craft)
    units = len(craft.units.spin_inertia)
    ticks = round(seconds / PERIOD)
    states = follow(engine, engine.start(released, np.zeros((1, units))), lambda _: np.zeros((1, units)), PERIOD, ticks)
    return engine, np.arange(ticks + 1) * PERIOD, states


def rates(engine, times, states):
    return np.array([engine.velocities(time, state).body_rate[0] for time, state in zip(times, states, strict=True)])


def momenta_N(engine, states):
    return states[:, 0, engine.slices["momentum"]]


# --- all effects alike ---------------------------------------------------------------------------------------------


def case_with(effects=(), actuation="cmg", duration=0.5):
    run = Run(duration=duration, maneuver=0, planned_spin=(0.2, -0.2, 0.2))
    return Case(scenario=SCENARIO, seed=5, runs=(run,), effects=tuple(effects), actuation=actuation)


@pytest.fixture(scope="module")
def undisturbed():
    return {
        actuation: fly_case(case_with(actuation=actuation, duration=0.3)) for actuation in ("cmg", "applied_torque")
    }


def shown(flown):
    log = flown.log
    return np.concatenate([log.gyro[~np.isnan(log.gyro)], *(part.ravel() for part in (log.encoder, log.motor_torque))])


def typical(effect):
    kind = KINDS[effect]
    parameters = kind.draw(np.random.default_rng(1))
    for name, value in {"time": 0.2, "first": 0.2, "limit": 0.1}.items():
        parameters = parameters | ({name: value} if name in parameters else {})
    return kind, HiddenEffect(effect=effect, component=kind.components[-1], parameters=parameters)


@pytest.mark.parametrize("effect", sorted(set(KINDS) - {"telemetry_skew", "gyro_clock_drift"}))
def test_size_zero_changes_nothing_and_a_typical_size_something(effect, undisturbed):
    kind, hidden = typical(effect)
    assert set(hidden.parameters) == set(kind.units)
    actuation = kind.actuation[0]
    zero = HiddenEffect(effect=effect, component=hidden.component, parameters=scaled(kind, hidden.parameters, 0.0))
    without, nothing, something = (
        undisturbed[actuation],
        fly_case(case_with([zero], actuation, 0.3)),
        fly_case(case_with([hidden], actuation, 0.3)),
    )
    # Rounding only: a step of another length, an identity rotation.
    np.testing.assert_allclose(shown(nothing), shown(without), rtol=0, atol=1e-11)
    assert np.abs(shown(something) - shown(without)).max() > 1e-7


def test_every_row_of_the_published_table_is_there():
    rows = """
        inertia viscous_drag quadratic_drag body_torque inertial_torque tether contact flexible_appendage slosh
        rotor_speed rotor_spin_down gimbal_zero gimbal_misalignment gimbal_lag gimbal_viscous_friction
        gimbal_coulomb_friction gimbal_backlash rotor_imbalance actuator_lag actuator_delay gyro_bias gyro_drift
        gyro_scale gyro_misalignment gyro_latency gyro_bandwidth gyro_noise gyro_quantization gyro_saturation
    """
    assert set(LISTED) == set(rows.split())


def test_late_telemetry_shows_what_was_so_before_and_leaves_the_flight_alone(undisturbed):
    late = HiddenEffect(effect="telemetry_skew", component="actuators", parameters={"late": 0.025})
    prompt, skewed = undisturbed["cmg"], fly_case(case_with([late], duration=0.3))
    np.testing.assert_array_equal(shown(skewed), shown(prompt))
    ticks = np.arange(len(prompt.log.time))  # at 80 Hz, of which 25 ms are two
    channels, before = record(skewed, 0).channels, prompt.log.encoder[ticks[::5], 0]
    np.testing.assert_allclose(channels["gimbal_angle"][1:], prompt.log.encoder[ticks[5::5] - 2, 0], atol=1e-12)
    np.testing.assert_array_equal(channels["body_rate"], prompt.log.gyro[::5, 0])
    assert np.abs(channels["gimbal_angle"][1:] - before[1:]).max() > 1e-4


def test_a_gyro_whose_clock_is_fast_stamps_what_it_read_before_and_leaves_the_flight_alone(undisturbed):
    fast = HiddenEffect(effect="gyro_clock_drift", component="gyro", parameters={"drift": 0.2})
    prompt, drifting = undisturbed["cmg"], fly_case(case_with([fast], duration=0.3))
    np.testing.assert_array_equal(shown(drifting), shown(prompt))
    stamped = np.arange(0, len(prompt.log.time), prompt.clock.gyro_ticks)  # every five ticks, of which four have passed
    before = prompt.log.body_rate[stamped * 4 // 5, 0] - prompt.log.body_rate[stamped, 0]
    late = record(drifting, 0).channels["body_rate"] - record(prompt, 0).channels["body_rate"]
    np.testing.assert_allclose(late, before, atol=1e-9)
    assert np.abs(before).max() > 1e-3


def test_an_averaging_gyro_shows_the_mean_over_its_period():
    whole = HiddenEffect(effect="gyro_averaging", component="gyro", parameters={"share_of_period": 1.0})
    flown = fly_case(replace(case_with([whole], duration=0.3), feedback=False), quiet=True)
    rates, every = flown.log.body_rate, flown.clock.gyro_ticks
    for tick in range(every, len(rates), every):
        over = rates[tick - every : tick + 1]
        mean = (0.5 * (over[:-1] + over[1:])).mean(axis=0)
        np.testing.assert_allclose(flown.log.gyro[tick], mean, atol=1e-12)


def test_dry_friction_slows_a_spin_by_the_same_every_second():
    engine, times, states = free_flight(with_one(BARE, "dry_friction", **xyz("torque", 0.0, 0.0, 1e-3)))
    np.testing.assert_allclose(rates(engine, times, states)[:, 2], 0.4 - 1e-3 / INERTIA_Z * times, rtol=1e-9)


# --- platform ------------------------------------------------------------------------------------------------------


def test_inertia_enters_entry_by_entry():
    entries = dict(zip(("dJ11", "dJ22", "dJ33", "dJ23", "dJ13", "dJ12"), np.arange(1.0, 7.0) * 1e-4, strict=True))
    change = with_one(BARE, "inertia", **entries).inertia - BARE.inertia
    np.testing.assert_allclose(change, 1e-4 * np.array([[1, 6, 5], [6, 2, 4], [5, 4, 3]]), atol=1e-18)


def test_viscous_drag_slows_exponentially():
    engine, times, states = free_flight(with_one(BARE, "viscous_drag", **xyz("coefficient", 0.0, 0.0, 0.01)))
    expected = 0.4 * np.exp(-0.01 * times / INERTIA_Z)
    np.testing.assert_allclose(rates(engine, times, states)[:, 2], expected, rtol=1e-12)


def test_quadratic_drag_slows_hyperbolically():
    engine, times, states = free_flight(with_one(BARE, "quadratic_drag", **xyz("coefficient", 0.0, 0.0, 0.05)))
    expected = 1.0 / (1.0 / 0.4 + 0.05 * times / INERTIA_Z)
    np.testing.assert_allclose(rates(engine, times, states)[:, 2], expected, rtol=1e-12)


def test_body_torque_accelerates_about_its_axis():
    engine, times, states = free_flight(with_one(BARE, "body_torque", **xyz("torque", 0.0, 0.0, 1e-3)))
    np.testing.assert_allclose(rates(engine, times, states)[:, 2], 0.4 + 1e-3 / INERTIA_Z * times, rtol=1e-12)


def test_inertial_torque_adds_to_the_momentum_in_inertial_axes():
    torque = np.array([1e-3, -2e-3, 5e-4])
    engine, times, states = free_flight(with_one(BARE, "inertial_torque", **xyz("torque", *torque)))
    gained = momenta_N(engine, states) - momenta_N(engine, states)[0]
    np.testing.assert_allclose(gained, times[:, None] * torque, atol=1e-15)


def test_tether_swings_back():
    stiffness, damping = 0.05, 0.004
    engine, times, states = free_flight(with_one(BARE, "tether", stiffness=stiffness, damping=damping), seconds=2.0)
    decay = damping / INERTIA_Z / 2.0
    swing = np.sqrt(stiffness / INERTIA_Z - decay**2)
    angle = Rotation.from_matrix(states[:, 0, engine.slices["attitude"]].reshape(-1, 3, 3)).as_rotvec()[:, 2]
    np.testing.assert_allclose(angle, 0.4 / swing * np.exp(-decay * times) * np.sin(swing * times), atol=1e-12)


def test_contact_adds_its_impulse_once_and_in_one_run():
    impulse = np.array([1e-4, 2e-4, -1e-4])
    blow = HiddenEffect(
        effect="contact", component="platform", parameters={"time": 0.1234, "run": 1.0, **xyz("impulse", *impulse)}
    )
    case = case_with([blow])
    flown = fly_case(replace(case, runs=case.runs * 2), quiet=True)
    momenta = flown.log.state[:, :, flown.mechanics.slices["momentum"]]
    attitude = flown.log.state[10, 1, flown.mechanics.slices["attitude"]].reshape(3, 3)  # 1.6 ms after: 5e-4 rad
    np.testing.assert_allclose(momenta[:, 0] - momenta[0, 0], 0.0, atol=1e-18)
    np.testing.assert_allclose(momenta[9, 1], momenta[0, 1], atol=1e-18)
    np.testing.assert_allclose(momenta[10:, 1] - momenta[0, 1], np.tile(attitude @ impulse, (31, 1)), atol=3e-7)
    assert np.linalg.norm(momenta[10, 1] - momenta[0, 1]) == pytest.approx(np.linalg.norm(impulse), rel=1e-9)


# --- inside --------------------------------------------------------------------------------------------------------

HINGED = {"frequency": 2.0, "damping_ratio": 0.03, "inertia": 3e-3, **xyz("axis", 0.0, 0.6, 0.8)}
LOOSE = {"mass": 0.3, "frequency": 1.0, "damping_ratio": 0.1, **xyz("place", 0.05, -0.04, 0.03)}
SWINGING = {
    "mass": 0.2,
    "frequency": 0.7,
    "phase": 0.0,
    **xyz("place", 0.0, 0.08, 0.0),
    **xyz("stroke", 0.05, 0.0, 0.0),
}


def hinged_sums(item, craft, body_rate, state, rate):
    momentum_B = craft.inertia @ body_rate + item.inertia * item.axis * rate[1]
    whole = item.axis @ body_rate + rate[1]
    rest = craft.inertia - item.inertia * np.outer(item.axis, item.axis)
    energy = 0.5 * (body_rate @ rest @ body_rate + item.inertia * whole**2 + item.stiffness * state[1] ** 2)
    return momentum_B, energy, -item.damping * rate[1] ** 2


def loose_sums(item, craft, body_rate, state, rate):
    place, start = item.place + state[3:], item.place
    rest = craft.inertia - item.mass * (start @ start * np.eye(3) - np.outer(start, start))
    velocity = rate[3:] + np.cross(body_rate, place)
    momentum_B = rest @ body_rate + item.mass * np.cross(place, velocity)
    stored = item.stiffness * state[3:] @ state[3:]
    energy = 0.5 * (body_rate @ rest @ body_rate + item.mass * velocity @ velocity + stored)
    return momentum_B, energy, -item.damping * rate[3:] @ rate[3:]


@pytest.mark.parametrize(
    ("effect", "parameters", "sums"), [("flexible_appendage", HINGED, hinged_sums), ("slosh", LOOSE, loose_sums)]
)
def test_what_moves_inside_keeps_the_momentum_and_loses_energy_to_its_damper(effect, parameters, sums):
    released = np.array([[0.3, -0.2, 0.4]])
    engine = mechanics(with_one(BARE, effect, **parameters))
    item, part = engine.craft.attachments[0], engine.slices["attachment0"]
    start = engine.start(released, np.zeros((1, 0)))
    start[:, part.stop - 1] = 0.02  # drawn back, so that it swings
    states = follow(engine, start, lambda _: np.zeros((1, 0)), PERIOD, 160)

    def conserved(state):
        body_rate = engine.velocities(0.0, state).body_rate[0]
        rate = engine.derivative(0.0, state, Inputs(np.zeros((1, 0))))[0, part]
        momentum_B, energy, power = sums(item, engine.craft, body_rate, state[0, part], rate)
        return state[0, engine.slices["attitude"]].reshape(3, 3) @ momentum_B, energy, power

    momenta = np.array([conserved(state)[0] for state in states])
    assert np.ptp(states[:, 0, part.stop - 1]) > 0.01  # it swings
    np.testing.assert_allclose(momenta, np.tile(momenta[0], (161, 1)), atol=1e-13)
    for state in states[20::40]:
        slope = engine.derivative(0.0, state, Inputs(np.zeros((1, 0))))
        change = (conserved(state + 1e-5 * slope)[1] - conserved(state - 1e-5 * slope)[1]) / 2e-5
        assert change == pytest.approx(conserved(state)[2], abs=1e-10)
    assert conserved(states[-1])[1] < conserved(states[0])[1]


def test_a_hinged_mode_on_a_free_platform_swings_faster_than_on_a_held_one():
    craft = with_one(BARE, "flexible_appendage", **HINGED | xyz("axis", 0.0, 0.0, 1.0) | {"damping_ratio": 0.0})
    engine = mechanics(craft)
    start = engine.start(np.zeros((1, 3)), np.zeros((1, 0)))
    start[:, engine.slices["attachment0"].stop - 1] = 0.01
    states = follow(engine, start, lambda _: np.zeros((1, 0)), PERIOD, 160)
    angle = states[:, 0, engine.slices["attachment0"].stop - 1]
    rate = 2.0 * np.pi * 2.0 / np.sqrt(1.0 - 3e-3 / INERTIA_Z)
    np.testing.assert_allclose(angle, 0.01 * np.cos(rate * np.arange(161) * PERIOD), atol=1e-12)


def test_a_driven_mass_turns_the_platform_the_other_way():
    engine, times, states = free_flight(with_one(BARE, "moving_mass", **SWINGING), released=np.zeros((1, 3)))
    mass = 0.2 * (1.0 - 0.2 / 4.0)
    rate = 2.0 * np.pi * 0.7
    along, speed = 0.05 * np.sin(rate * times), 0.05 * rate * np.cos(rate * times)
    # At release the platform stands still with the mass moving: L = -μ y ẋ is kept.
    total = -mass * 0.08 * speed[0]
    inertia = INERTIA_Z + mass * along**2
    np.testing.assert_allclose(rates(engine, times, states)[:, 2], (total + mass * 0.08 * speed) / inertia, atol=1e-12)


# --- units ---------------------------------------------------------------------------------------------------------


def test_rotor_speed_changes_the_momentum_and_not_the_tachometer():
    craft = with_one(nominal_craft(NUMBERS), "rotor_speed", UNIT, relative_error=0.02)
    momentum = craft.units.spin_inertia * craft.units.rotor_speed
    np.testing.assert_allclose(momentum / 0.004714, [1.0, 1.0, 1.02, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(craft.units.rotor_speed / craft.tachometer_scale, 471.4)


def test_a_rotor_spins_down_and_the_body_takes_its_momentum():
    engine, _, states = free_flight(with_one(nominal_craft(NUMBERS), "rotor_spin_down", UNIT, decay=0.1))
    speed = np.array([engine.velocities(0.0, state).rotor_speed[0] for state in states])
    # The servo's lag of 3.3 ms is 3.3e-4 of the decay's 10 s.
    np.testing.assert_allclose(speed[-1, 2] / speed[0, 2], np.exp(-0.1), rtol=5e-4)
    np.testing.assert_allclose(engine.shown_speed(1.0, speed[-1])[2], speed[0, 2], rtol=5e-4)
    assert np.abs(speed[-1, [0, 1, 3, 4, 5]] / speed[0, 0] - 1.0).max() < 1e-3
    np.testing.assert_allclose(momenta_N(engine, states), momenta_N(engine, states)[[0]].repeat(81, 0), atol=1e-18)


def test_encoder_zero_and_backlash():
    zero = [HiddenEffect(effect="gimbal_zero", component=UNIT, parameters={"zero": 0.02})]
    loose = [HiddenEffect(effect="gimbal_backlash", component=UNIT, parameters={"dead_zone": 0.004})]
    angle = slice(None), 0, 2
    flown = fly_case(case_with(zero), quiet=True)
    true = flown.log.state[:, 0, flown.mechanics.slices["angle"]]
    np.testing.assert_allclose(flown.log.encoder[angle] - true[:, 2], 0.02, atol=1e-15)
    flown = fly_case(case_with(loose), quiet=True)
    true = flown.log.state[:, 0, flown.mechanics.slices["angle"]]
    lead = np.concatenate([[0.0], np.sign(np.diff(true[:, 2]))])
    np.testing.assert_allclose(flown.log.encoder[angle] - true[:, 2], 0.002 * lead, atol=1e-15)
    others = np.delete(flown.log.encoder[:, 0] - true, 2, axis=1)
    np.testing.assert_allclose(others, 0.0, atol=1e-15)


def test_a_gimbal_axis_is_tilted_as_the_testbed_tilts_it():
    craft = nominal_craft(NUMBERS)
    tilted = with_one(craft, "gimbal_misalignment", UNIT, about_spin_axis=0.03, about_transverse_axis=-0.02).units
    angles = np.zeros((6, 2))
    angles[2] = 0.03, -0.02
    expected = turned_axes(craft.units.gimbal_axis, craft.units.spin_axis, angles)
    np.testing.assert_allclose(tilted.gimbal_axis, expected.gimbal_axis_B, atol=1e-15)
    np.testing.assert_allclose(tilted.spin_axis, expected.spin_axis_B, atol=1e-15)
    np.testing.assert_allclose(tilted.transverse_axis, expected.transverse_axis_B, atol=1e-15)


def test_a_lagging_motor_follows_its_demand_exponentially():
    engine = mechanics(with_one(nominal_craft(NUMBERS), "gimbal_lag", UNIT, time_constant=0.02))
    start = engine.start(np.zeros((1, 3)), np.zeros((1, 6)))
    states = follow(engine, start, lambda _: np.full((1, 6), 1e-3), PERIOD, 8)
    torque = engine.motor_torque(states[-1], np.zeros((1, 6)), np.full((1, 6), 1e-3))[0]
    np.testing.assert_allclose(torque[2], 1e-3 * (1.0 - np.exp(-8 * PERIOD / 0.02)), rtol=1e-9)
    np.testing.assert_allclose(np.delete(torque, 2), 1e-3)


@pytest.mark.parametrize(
    ("effect", "parameters", "torque"),
    [
        ("gimbal_viscous_friction", {"coefficient": 3e-4}, lambda rate: -3e-4 * rate),
        (
            "gimbal_coulomb_friction",
            {"torque": 2e-4, "stribeck_torque": 1e-4, "stribeck_rate": 0.05},
            lambda rate: -np.sign(rate) * (2e-4 + 1e-4 * np.exp(-((rate / 0.05) ** 2))),
        ),
    ],
)
def test_friction_brakes_one_gimbal_and_leaves_the_momentum(effect, parameters, torque):
    engines = [
        mechanics(craft)
        for craft in (nominal_craft(NUMBERS), with_one(nominal_craft(NUMBERS), effect, UNIT, **parameters))
    ]
    state = engines[0].start(RELEASED[None], np.full((1, 6), 0.3))
    for rate in (0.06, -0.06, 1.0, -1.0):  # from 0.06 rad/s on, the rounded sign is 1 within 2e-5
        moving = state.copy()
        moving[:, engines[0].slices["p"]] += rate * engines[0].craft.units.turning_inertia
        true_rate = engines[0].velocities(0.0, moving).gimbal_rate[0]
        slopes = [engine.derivative(0.0, moving, Inputs(np.zeros((1, 6))))[0] for engine in engines]
        felt = (slopes[1] - slopes[0])[engines[0].slices["p"]]
        assert felt[2] == pytest.approx(torque(true_rate[2]), rel=5e-4)
        np.testing.assert_allclose(np.delete(felt, 2), 0.0, atol=1e-18)
        np.testing.assert_allclose(slopes[1][engines[0].slices["momentum"]], 0.0, atol=1e-18)


def shaken_in_mujoco(static, dynamic, ticks):
    """Body rates at the ticks with an off-centre, tilted rotor in unit 3."""
    properties = PlatformProperties(
        inertia=NUMBERS.inertia, mass=4.0, rotor_momentum=np.full(6, 0.004714), step=FINE_STEP
    )
    spec = specification(properties, shipped_model())
    rotor = spec.body(f"{UNIT}_rotor")
    rotor.ipos = [0.0, static / rotor.mass, 0.0]
    rotor.inertia, rotor.iquat = np.zeros(3), [1.0, 0.0, 0.0, 0.0]
    rotor.fullinertia = [1e-5, 5.3e-6, 5.3e-6, dynamic, 0.0, 0.0]
    craft, flown = plant(spec.compile(), initial(body_rate=RELEASED)), [RELEASED]
    for _ in range(ticks):
        craft.advance(np.zeros(6), 40)
        flown.append(craft.body_rate.copy())
    return np.array(flown)


@pytest.mark.parametrize(("static", "dynamic"), [(1e-6, 0.0), (0.0, 5e-9)])
def test_an_unbalanced_rotor_shakes_the_body_as_in_mujoco(static, dynamic):
    parameters = {"static": static, "dynamic": dynamic, "phase": 0.0}
    craft = with_one(nominal_craft(NUMBERS), "rotor_imbalance", UNIT, **parameters)
    ours = [rates(*free_flight(each, RELEASED[None], 0.25)) for each in (craft, nominal_craft(NUMBERS))]
    theirs = [shaken_in_mujoco(*sizes, 20) for sizes in ((static, dynamic), (0.0, 0.0))]
    shaking, expected = ours[0] - ours[1], theirs[0] - theirs[1]
    assert np.abs(expected).max() > 1e-4
    # Terms in body rate and gimbal rate over rotor speed are left out: 1e-3 of the shaking.
    np.testing.assert_allclose(shaking, expected, atol=5e-3 * np.abs(expected).max())


# --- gyro ----------------------------------------------------------------------------------------------------------


def gyro_of(effect, component="gyro", **parameters):
    hidden = HiddenEffect(effect=effect, component=component, parameters=parameters)
    flown = fly_case(case_with([hidden]), quiet=True)
    read = ~np.isnan(flown.log.gyro[:, 0, 0])
    return flown, flown.log.time[read], flown.log.gyro[read, 0], flown.log.body_rate[read, 0]


def test_gyro_bias_drift_and_scale():
    _, _, shown_rate, true = gyro_of("gyro_bias", **xyz("bias", 1e-3, -2e-3, 3e-3))
    np.testing.assert_allclose(shown_rate - true, np.tile([1e-3, -2e-3, 3e-3], (len(true), 1)), atol=1e-15)
    _, time, shown_rate, true = gyro_of("gyro_drift", random_walk=0.0, **xyz("drift", 1e-3, 0.0, -1e-3))
    np.testing.assert_allclose(shown_rate - true, time[:, None] * [1e-3, 0.0, -1e-3], atol=1e-15)
    _, _, shown_rate, true = gyro_of("gyro_scale", "y", scale_factor_error=0.05)
    np.testing.assert_allclose(shown_rate, true * [1.0, 1.05, 1.0], atol=1e-15)


def test_a_misaligned_gyro_reads_the_rate_in_other_axes():
    angles = {"yz": 1e-3, "xz": -2e-3, "xy": 3e-3}
    _, _, shown_rate, true = gyro_of("gyro_misalignment", **angles)
    turned = true - np.cross([1e-3, -2e-3, 3e-3], true)
    np.testing.assert_allclose(shown_rate, turned, atol=1e-5)  # second order in 3e-3, at 0.4 rad/s
    _, _, shown_rate, true = gyro_of("gyro_misalignment", "gyro_cross_axis", **angles)
    x, y, z = true.T
    oblique = np.stack([x + 3e-3 * y - 2e-3 * z, y + 3e-3 * x + 1e-3 * z, z - 2e-3 * x + 1e-3 * y], axis=1)
    np.testing.assert_allclose(shown_rate, oblique, atol=1e-15)


@pytest.mark.parametrize("delay", [0.005, PERIOD, 0.04])
def test_a_late_gyro_shows_the_past(delay):
    flown, time, shown_rate, _ = gyro_of("gyro_latency", delay=delay)
    states, seen = flown.log.fine_state, time - delay
    fine = np.array([flown.mechanics.velocities(0.0, state).body_rate[0] for state in states])
    past = np.stack([np.interp(seen, flown.log.fine_time, column) for column in fine.T], axis=1)
    # Between points 4 ms apart a line strays by 1e-5 at most; before release the body turns as it is released.
    np.testing.assert_allclose(shown_rate[seen >= 0.0], past[seen >= 0.0], atol=2e-5)
    np.testing.assert_allclose(shown_rate[seen < 0.0], np.tile([0.2, -0.2, 0.2], ((seen < 0.0).sum(), 1)), atol=1e-12)


def test_a_slow_gyro_is_a_low_pass():
    flown, time, shown_rate, true = gyro_of("gyro_bandwidth", bandwidth=20.0)
    fine = [flown.mechanics.velocities(0.0, state).body_rate[0] for state in flown.log.fine_state]
    spline = CubicSpline(flown.log.fine_time, fine)
    passed = solve_ivp(
        lambda now, value: 2.0 * np.pi * 20.0 * (spline(now) - value),
        (0.0, 0.5),
        true[0],
        t_eval=time,
        rtol=1e-9,
        atol=1e-12,
        max_step=PERIOD / 4,
    )
    # The spline through points 4 ms apart rounds off the corners that each tick leaves in the acceleration.
    np.testing.assert_allclose(shown_rate, passed.y.T, atol=1e-5)
    assert np.abs(shown_rate - true).max() > 1e-3


def test_gyro_noise_quantization_and_saturation():
    loud = with_one(BARE, "gyro_noise", "z", extra_noise=3e-3)
    assert loud.gyro.extra_noise == pytest.approx([0.0, 0.0, 3e-3])
    _, _, shown_rate, true = gyro_of("gyro_quantization", step=0.01)
    np.testing.assert_allclose(shown_rate, 0.01 * np.rint(shown_rate / 0.01), atol=1e-15)
    assert np.abs(shown_rate - true).max() <= 0.005 + 1e-12
    _, _, shown_rate, true = gyro_of("gyro_saturation", limit=0.15)
    np.testing.assert_allclose(shown_rate, np.clip(true, -0.15, 0.15), atol=1e-15)
    assert (np.abs(shown_rate) == 0.15).any()


# --- applied torque, and what no library lists ---------------------------------------------------------------------


RATE, LATE = 3.0, 0.1


def delayed_momentum(times):
    return 1e-3 / RATE * (np.cos(RATE * LATE) - np.cos(RATE * (times - LATE)))


def lagged_momentum(times):
    """∫ of u̇ = (sin - u) / τ from u = 0."""
    product = RATE * LATE
    steady = (1.0 - np.cos(RATE * times)) / RATE - LATE * np.sin(RATE * times)
    return 1e-3 / (1.0 + product**2) * (steady + product * LATE * (1.0 - np.exp(-times / LATE)))


@pytest.mark.parametrize(
    ("effect", "parameter", "expected"),
    [("actuator_lag", "time_constant", lagged_momentum), ("actuator_delay", "delay", delayed_momentum)],
)
def test_late_actuators_push_late(effect, parameter, expected):
    craft = with_one(BARE, effect, "actuators", **{parameter: LATE})
    engine = replace(mechanics(craft), applied=lambda time: np.array([[0.0, 0.0, 1e-3 * np.sin(RATE * time)]]))
    states = follow(engine, engine.start(np.zeros((1, 3)), np.zeros((1, 0))), lambda _: np.zeros((1, 0)), PERIOD, 80)
    np.testing.assert_allclose(momenta_N(engine, states)[:, 2], expected(np.arange(81) * PERIOD), atol=1e-14)


def test_sine_and_ramp_torques_integrate_to_their_momenta():
    frequency = 2.0 * np.pi * 1.5
    craft = with_one(BARE, "sine_torque", frequency=1.5, phase=0.3, **xyz("torque", 0.0, 0.0, 1e-3))
    engine, times, states = free_flight(craft)
    expected = 1e-3 / frequency * (np.cos(0.3) - np.cos(frequency * times + 0.3))
    np.testing.assert_allclose(
        momenta_N(engine, states)[:, 2] - states[0, 0, engine.slices["momentum"]][2], expected, atol=1e-14
    )
    engine, times, states = free_flight(with_one(BARE, "ramp_torque", **xyz("slope", 0.0, 0.0, 1e-3)))
    np.testing.assert_allclose(rates(engine, times, states)[:, 2], 0.4 + 5e-4 * times**2 / INERTIA_Z, rtol=1e-12)


def test_impacts_come_in_a_train():
    train = {"first": 0.11, "interval": 0.1, **xyz("impulse", 0.0, 0.0, 1e-4)}
    case = case_with([HiddenEffect(effect="impact_train", component="platform", parameters=train)])
    flown = fly_case(case, quiet=True)
    momenta = flown.log.state[:, 0, flown.mechanics.slices["momentum"]]
    jumps = np.linalg.norm(np.diff(momenta, axis=0), axis=1)
    np.testing.assert_allclose(jumps[jumps > 1e-12], 1e-4, rtol=1e-9)
    assert (jumps > 1e-12).sum() == 4  # at 0.11, 0.21, 0.31, 0.41 s


def test_a_torque_of_rate_products():
    craft = with_one(BARE, "rate_product_torque", **xyz("coefficient", 1e-2, 2e-2, 3e-2))
    engine = mechanics(craft)
    state = engine.start(np.array([[0.1, 0.2, 0.3]]), np.zeros((1, 0)))
    slope = engine.derivative(0.0, state, Inputs(np.zeros((1, 0))))[0, engine.slices["momentum"]]
    np.testing.assert_allclose(slope, [1e-2 * 0.06, 2e-2 * 0.03, 3e-2 * 0.02], rtol=1e-12)
