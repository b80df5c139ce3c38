"""Every registered effect: its derivatives, and MuJoCo flying the model with it built in."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from support.flown_effects import flown, nominal, scenario
from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times, with_gimbals
from testbed.arrays import Array
from testbed.assembly.extension import extended
from testbed.effects.contract import Effect, Extension, NamedEffect, components_in
from testbed.effects.noise_effect import Readings
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.estimation.telemetry import Telemetry, Thrusters
from testbed.experiment.conduct import conduct
from testbed.prediction.grid import grid_of
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted, predicted_with_derivatives

LEFT = 2e-6
"""rad/s. Gimbal angles sampled at 160 Hz leave 3e-7, an MJCF's six digits 4e-7 of 0.3 rad/s."""
SHARE = 0.01
"""Of the signature that may be left where both sides approximate, such as a mode integrated at 64 Hz."""
TORQUE_LEFT = 2.5e-6
"""N·m. A motor holds its demand for 6.25 ms, and its samples are taken for what the middle of that needs."""
INNER_SHARE = 0.03
"""Of the signature inside a unit: what its servo does within a control period is known as well as that."""
SHARES = {"rotor_spin_down": 0.02, "gimbal_backlash": 0.02, "gimbal_coulomb_friction": 0.1, "rotor_imbalance": 0.08}
"""A rotor that is not driven keeps its speed in space, too: the body's 0.6 rad/s are a tenth of what it loses here.
A servo that hunts in the play moves the gimbal between samples: true angles at 160 Hz leave 1.1 % themselves.
A gimbal that sticks puts the fitted age of its torques wrong. What a rotor's tremor does to gimbals is left out."""
OF_GYROS = [
    each
    for each in (*EFFECTS.values(), *NOISE_EFFECTS.values())
    if "wheel_speed" not in each.needs and not each.environment
]
"""Those of reaction wheels are in test_wheel_effects.py, those of an environment in test_environment_effects.py."""
PREDICTED = [pytest.param(effect, id=effect.id) for effect in OF_GYROS if isinstance(effect, Effect)]
EVERY = [pytest.param(effect, id=effect.id) for effect in OF_GYROS]
INNER = [each for each in PREDICTED if {"gimbal_torque", "gimbal_rate_command"} & set(each.values[0].needs)]
"""Effects inside the units: with measured gimbal angles they leave the body's motion explained."""
ON_GYRO = [each for each in PREDICTED if each not in INNER]
FLOWN = [each for each in ON_GYRO if each.values[0].flies]


def typical(effect: NamedEffect) -> Array:
    return np.array([parameter.typical for parameter in effect.parameters])


def place(effect: NamedEffect) -> str:
    """One of its components: not the first, which an index that is forgotten would hit too."""
    components = components_in(effect, 6) or components_in(effect, 6, thrusters=4)
    return components[len(components) // 2]


# Derivatives


@cache
def synthetic_run() -> Telemetry:
    """Two seconds with momentum, spin, and a torque that an actuator might apply."""
    times = sample_times(1000.0)
    run = exact_telemetry(nominal_flight(np.array([0.003, -0.004, 0.006])), sample_times(16.0), times)
    torque_B = 1e-3 * np.sin(np.outer(times, [3.0, 4.0, 5.0]))
    thrusters = Thrusters(
        position_B=np.array([[0.3, -0.3, 0.1], [-0.3, -0.3, 0.1], [-0.3, 0.3, 0.1], [0.3, 0.3, 0.1]]),
        direction_B=np.array([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.6, 0.0, 0.8], [0.0, -0.6, 0.8]]),
        reaction=np.array([-0.01, 0.01, -0.01, 0.01]),
    )
    thrust = 0.1 + 0.05 * np.sin(np.outer(times, [3.0, 4.0, 5.0, 6.0]))
    return replace(
        run,
        gyro_time=run.gyro_time[:32],
        body_rate=run.body_rate[:32],
        applied_torque=torque_B,
        thrust=thrust,
        thrusters=thrusters,
    )


@pytest.mark.parametrize("effect", ON_GYRO)
def test_derivatives_agree_with_differences(effect: Effect):
    run = synthetic_run()
    if "cluster_momentum" in effect.needs:
        wheels_B = 0.02 * np.sin(np.outer(run.actuator_time, [3.0, 4.0, 5.0]))
        run = replace(run, gimbals=None, cluster_momentum=wheels_B, applied_torque=None)
    grid, hooks, at = grid_of([run]), [effect.hooks(place(effect))], typical(effect)

    def values(sizes: Array) -> Values:
        return Values(theta=TRUE_THETA[None], initial_rate=run.body_rate[:1][None], effects=(sizes[None],))

    _, derivatives = predicted_with_derivatives(grid, hooks, values(at), range(6, 6 + len(at)))
    for index, scale in enumerate(np.abs(at)):
        step = 1e-5 * scale * np.eye(len(at))[index]
        forward, back = (predicted(grid, hooks, values(at + sign * step))[0][0] for sign in (1.0, -1.0))
        difference = (forward - back) / 2e-5  # by the parameter's typical size: truncation 1e-10, rounding 1e-11
        exact = derivatives[0][..., index] * scale
        assert np.abs(exact).max() > 1e-7, effect.parameters[index].name  # rad/s: the test has something to compare
        np.testing.assert_allclose(exact, difference, atol=2e-9)


# Flights


def test_without_effects_the_files_fly_as_the_scenario_does(tmp_path):
    flight = flown([], tmp_path)
    plain = conduct(scenario(), seed=1).flown.record.channels["true_body_rate"]
    np.testing.assert_allclose(flight.experiment.flown.record.channels["true_body_rate"], plain, atol=LEFT)
    assert flight.residual([]) < LEFT
    text = (tmp_path / "scenario.toml").read_text(encoding="utf-8")
    assert 'model = "platform.xml"' in text
    assert not any(key in text for key in ("inertia_kg_m2", "mass_kg", "edge_m", "skew_deg"))


@pytest.mark.parametrize("effect", FLOWN)
def test_mujoco_and_the_prediction_show_the_same_signature(effect: Effect, tmp_path):
    """In the closed loop: the record is explained with the effect at its size, and without it is not."""
    component, size = place(effect), typical(effect)
    flight = flown([effect.extension(component, size, scenario())], tmp_path)
    if effect.id == "rotor_spin_down":  # the flown tachometers tell of it: it is an effect where there are none
        flight = replace(flight, telemetry=with_gimbals(flight.telemetry, rotor_momentum=None))
    assert flight.experiment.outcome == "completed"
    assert flight.experiment.estimation is not None
    signature, left = flight.residual([]), flight.residual([effect.hooks(component)], size)
    print(f"{effect.id}: signature {signature:.1e} rad/s, left {left:.1e}")
    allowed = LEFT + SHARES.get(effect.id, SHARE) * signature
    assert left < allowed
    if (
        "applied_torque_or_cluster_momentum" not in effect.needs
    ):  # the encoders of this platform show what its actuators do
        assert signature > 10.0 * allowed


@pytest.mark.parametrize("effect", INNER)
def test_what_happens_inside_the_units_shows_there_and_leaves_the_motion_explained(effect: Effect, tmp_path):
    """Released at rest: the motors start without torque, and late ones let a spin turn their gimbals first."""
    component, size, released = place(effect), typical(effect), scenario(body_rate=(0.0, 0.0, 0.0))
    flight = flown([effect.extension(component, size, released)], tmp_path, released)
    assert flight.experiment.outcome == "completed"
    assert flight.residual([]) < LEFT
    assert flight.residual([effect.hooks(component)], size) < LEFT
    in_torque = "gimbal_torque" in effect.needs
    inside = flight.torque_residual if in_torque else flight.response_residual
    signature, left = inside([]), inside([effect.hooks(component)], size)
    print(f"{effect.id}: signature {signature:.1e}, left {left:.1e}")
    allowed = TORQUE_LEFT * in_torque + SHARES.get(effect.id, INNER_SHARE) * signature
    assert left < allowed
    assert signature > 5.0 * allowed


def test_an_unbalanced_rotor_draws_the_line_that_is_sought(tmp_path):
    effect = NOISE_EFFECTS["rotor_imbalance"]
    component, size = place(effect), typical(effect)
    flight = flown([effect.extension(component, size, scenario())], tmp_path)
    missed = flight.missed_from_any_start()
    readings = Readings(
        measured=[flight.telemetry.body_rate],
        residual=[missed],
        sigma=np.full((1, 3), LEFT),
        runs=[flight.telemetry],
        inertia=nominal().inertia,
        parameters=0,
    )
    finding = effect.found(component, readings)
    assert finding is not None
    assert finding.explained is not None
    left = missed - finding.explained[0]
    print(f"{effect.id}: signature {np.abs(missed).max():.1e} rad/s, left {np.abs(left).max():.1e}, {finding.values}")
    np.testing.assert_allclose(finding.values, size, rtol=0.02)
    assert np.abs(left).max() < SHARES[effect.id] * np.abs(missed).max()


@pytest.mark.parametrize("effect", [each for each in EVERY if each not in PREDICTED and each.id != "gyro_noise_color"])
def test_a_model_with_an_effect_on_readings_flies(effect: NamedEffect, tmp_path):
    flight = flown([effect.extension(place(effect), typical(effect), scenario())], tmp_path)
    assert flight.experiment.outcome == "completed"
    assert flight.residual([]) > LEFT


def test_a_model_flies_with_noise_of_a_colour(tmp_path):
    noise, color = (NOISE_EFFECTS[name].extension("gyro", np.array([0.5]), scenario()) for name in _NOISE)
    flight = flown([noise, color], tmp_path)
    shown = flight.missed_from_any_start()
    assert np.mean(shown[1:] * shown[:-1]) == pytest.approx(0.5 * np.mean(shown**2), rel=0.4)


_NOISE = ("gyro_noise", "gyro_noise_color")


def test_only_what_no_flight_can_have_is_not_flown():
    grounded = [each.values[0] for each in EVERY if not each.values[0].flies]
    assert [effect.id for effect in grounded] == [
        "dry_friction",
        "contact",
        "actuator_gain",
        "actuator_rate_limit",
        "actuator_weak",
        "actuator_misaligned",
        "thrust_offset",
        "rotor_acceleration_reaction",
        "telemetry_skew",
        "gyro_clock_drift",
        "gyro_averaging",
    ]
    for effect in grounded:
        assert effect.extension(place(effect), typical(effect), scenario()) == Extension()


def test_effects_of_no_size_change_nothing(tmp_path):
    extensions, present = [], scenario()
    for effect in OF_GYROS:
        absent = np.array([parameter.absent for parameter in effect.parameters])
        extensions.append(effect.extension(place(effect), absent, present))
        present = extended(present, extensions[-1])
    with_all = flown(extensions, tmp_path / "all").experiment.flown.record
    without = flown([], tmp_path / "none").experiment.flown.record
    for channel in ("body_rate", "gimbal_angle", "gimbal_torque", "rotor_speed"):
        np.testing.assert_allclose(with_all.channels[channel], without.channels[channel], rtol=1e-9, atol=1e-9)


def test_effects_fly_together(tmp_path):
    """One on the platform, two on units, one in the gyro; each is asked with the scenario that the others made."""
    sizes = {"viscous_drag": "platform", "rotor_speed": "cmg2", "gyro_latency": "gyro"}
    placed = [(EFFECTS[name], component) for name, component in sizes.items()] + [(EFFECTS["rotor_speed"], "cmg5")]
    extensions, present = [], scenario()
    for effect, component in placed:
        extensions.append(effect.extension(component, typical(effect), present))
        present = extended(present, extensions[-1])
    flight = flown(extensions, tmp_path)
    hooks = [effect.hooks(component) for effect, component in placed]
    assert flight.residual(hooks, *(typical(effect) for effect, _ in placed)) < LEFT + SHARE * flight.residual([])


@pytest.mark.parametrize("effect", EVERY)
def test_an_effect_says_what_it_is(effect: NamedEffect):
    assert effect.sentence.endswith(".")
    assert effect.confirm.endswith(".")
    assert effect.id not in effect.look_alikes
    for parameter in effect.parameters:
        assert parameter.lower <= parameter.absent <= parameter.upper
        assert parameter.lower <= parameter.typical <= parameter.upper
    for component in components_in(effect, 6):
        assert not re.search(r"\b(\w+) \1\b", effect.described(component))
