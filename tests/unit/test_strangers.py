"""Cases that Basilisk flies: records, sizes and answers apart, from a frozen flight, without Basilisk."""

from __future__ import annotations

import json
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import strangers_cases
from benchmarks.strangers_cases import make_stranger, record_of, stranger_orders
from benchmarks.strangers_craft import engine_craft, flyable_delay, step_of
from benchmarks.strangers_effects import WITH_PARTS, answered
from benchmarks.strangers_engine import PLATFORMS, Flown, Run, StrangerCase
from concealing.effect import HiddenEffect
from concealing.order import Order
from concealing.power import UnreachableError
from concealing.sealing import is_sealed
from testbed.library.records import read_records
from testbed.scoring.case import read_cases
from testbed.scoring.formats import AnswerFile
from testbed.scoring.judging import parameters_covered, said_right

FROZEN = Path(__file__).with_name("frozen") / "strangers.npz"
"""Four seconds of the microsat on orbit: `Engine.fly(frozen_case())`, and its gyro again without noise."""
MICROSAT = PLATFORMS["microsat"]


def frozen_case() -> StrangerCase:
    run = Run(motion=5, gyro=6, navigation=7, release_error=(1e-4, -2e-4, 3e-4))
    error = (0.3, -0.2, 0.1, 0.05, -0.1, 0.2)
    return StrangerCase(platform="microsat", seed=4, duration=4.0, runs=(run,), theta_error=error)


@pytest.fixture(scope="module")
def channels():
    with np.load(FROZEN) as kept:
        return {name: kept[name] for name in kept}


@pytest.fixture(scope="module")
def flown(channels):
    return Flown(*(channels[name] for name in Flown._fields))


@pytest.fixture(scope="module")
def quiet(channels, flown):
    return flown._replace(body_rate=channels["quiet_body_rate"])


def hidden(effect, component="platform", **parameters):
    return HiddenEffect(effect=effect, component=component, parameters=parameters)


def with_effect(case, *effects):
    return replace(case, effects=effects, stratum="single")


def test_a_record_has_rates_speeds_commands_and_attitude_of_the_same_instants(flown):
    record = record_of("microsat", flown, 0)
    rate, speed = record.channels["body_rate"], record.channels["wheel_speed"]
    assert record.time[0] == pytest.approx(0.2)  # what imuSensor says before it is ready is left out
    assert np.all(np.abs(rate).max(axis=1) > 0.0)
    np.testing.assert_allclose(rate, flown.true_body_rate[4::2], atol=6 * 8e-6)
    np.testing.assert_allclose(speed, flown.true_wheel_speed[4::2], atol=0.07)  # an encoder's line in 0.1 s
    attitude = Rotation.from_quat(record.channels["attitude"], scalar_first=True)
    turned = (attitude[:-20].inv() * attitude[20:]).as_rotvec()  # in two seconds
    meant = np.array([0.1 * rate[first : first + 21].mean(axis=0) * 20 for first in range(len(rate) - 20)])
    np.testing.assert_allclose(turned, meant, atol=1e-3)
    assert np.abs(meant).max() > 0.03


def test_a_command_stands_at_the_reading_from_which_on_it_turns_its_wheel(flown):
    wheels = MICROSAT.numbers.wheels
    true = flown._replace(wheel_speed=flown.true_wheel_speed[::2], body_rate=flown.true_body_rate[::2])
    gained = wheels.spin_inertia * np.diff(true.wheel_speed + true.body_rate @ wheels.axis.T, axis=0)
    braked = wheels.viscous * 0.5 * (true.wheel_speed[1:] + true.wheel_speed[:-1])
    np.testing.assert_allclose(gained / 0.1, flown.wheel_torque_command[:-1] - braked, atol=1e-9)


def test_a_flight_without_effect_leaves_nothing_of_what_the_gyro_reads_without_noise(quiet):
    case = frozen_case()
    assert np.abs(strangers_cases.left_unexplained(case, [quiet])).max() < 1e-9
    assert np.abs(strangers_cases.left_by_drives(case, [quiet])).max() < 1e-2 * 0.025


def test_what_the_gyro_reads_otherwise_shows_in_standard_deviations_of_its_noise(quiet):
    shifted = quiet._replace(body_rate=quiet.body_rate + 8e-6 * np.sin(7.0 * quiet.time)[:, None])
    left = strangers_cases.left_unexplained(frozen_case(), [shifted]) / 8e-6
    assert 0.5 * np.sqrt(len(left) / 2.0) < np.linalg.norm(left) < np.sqrt(len(left) / 2.0)


def test_parts_that_move_leave_the_whole_as_it_is_at_rest():
    parts = (
        hidden("flexible_appendage", mass=2.0, azimuth=0.5, hinge_tilt=0.3, frequency=0.8, damping_ratio=0.01),
        hidden("slosh", mass=3.0, place_x=0.1, place_y=-0.2, place_z=0.1, frequency=0.6, damping_ratio=0.1),
    )
    case = with_effect(frozen_case(), *parts)
    given = engine_craft(case.craft, MICROSAT.numbers, 4e5, {})
    panel, hub = given["panels"][0], given["hub"]
    turned = np.array(panel["dcm_HB"])
    place = np.array(panel["hinge_m"]) - turned[0] * panel["distance_m"]
    masses = [(hub["mass_kg"], np.zeros(3), np.array(hub["inertia_kg_m2"]))]
    masses.append((panel["mass_kg"], place, turned.T @ np.array(panel["inertia_kg_m2"]) @ turned))
    masses += [(each["mass_kg"], np.array(each["place_m"]), np.zeros((3, 3))) for each in given["particles"]]
    centre = sum(mass * place for mass, place, _ in masses) / 100.0
    arms = [(mass, place - centre, own) for mass, place, own in masses]
    whole = sum(own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm)) for mass, arm, own in arms)
    assert sum(mass for mass, _, _ in masses) == pytest.approx(100.0)
    np.testing.assert_allclose(whole, case.craft.inertia, atol=1e-12)
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-15)


def test_what_cannot_fly_is_refused():
    for effect in (
        hidden("slosh", mass=11.0, place_x=0.1, place_y=0.1, place_z=0.1, frequency=0.6, damping_ratio=0.1),
        hidden("gravity_gradient", relative_error=-1.2),
    ):
        with pytest.raises(UnreachableError):
            engine_craft(with_effect(frozen_case(), effect).craft, MICROSAT.numbers, 4e5, {})


def test_a_weaker_gradient_is_a_higher_orbit():
    case = with_effect(frozen_case(), hidden("gravity_gradient", relative_error=-0.5))
    heights = [engine_craft(each.craft, MICROSAT.numbers, 4e5, {})["orbit"] for each in (frozen_case(), case)]
    low, high = (np.linalg.norm(each["position_m"]) for each in heights)
    assert (low / high) ** 3 == pytest.approx(0.5)


@pytest.mark.parametrize("delay", [3.9e-4, 7.5e-4, 7.9e-3, 0.02])
def test_a_gyro_is_late_by_whole_steps(delay):
    flyable, step = flyable_delay(delay), step_of(delay)
    assert flyable == pytest.approx(delay, rel=0.05)
    assert 50_000_000 % step == 0
    assert round(1e9 * flyable) % step == 0


def test_answers_are_in_the_parameters_of_the_effect_that_is_named(flown):
    modules = (
        hidden("flexible_appendage", mass=2.0, azimuth=0.0, hinge_tilt=0.3, frequency=0.8, damping_ratio=0.01),
        hidden("slosh", mass=3.0, place_x=0.1, place_y=-0.2, place_z=0.1, frequency=0.6, damping_ratio=0.1),
        hidden("gyro_latency", "gyro", delay=7.6e-4),
    )
    panel, tank, gyro = (answer_of(with_effect(frozen_case(), each), flown).effects[0] for each in modules)
    assert set(panel.parameters) == {"frequency_hz", "damping_ratio", "inertia_kg_m2", "axis_x", "axis_y", "axis_z"}
    assert "mass_kg" not in tank.parameters  # which would swing at another arm
    assert gyro.parameters["delay_s"].value == pytest.approx(7.8125e-4)  # as it was flown


def test_the_inertia_of_a_panel_is_what_the_satellite_feels_of_it():
    """Held against the kinetic energy of plate and hub, free to move along, by differences."""
    case = with_effect(
        frozen_case(),
        hidden("flexible_appendage", mass=2.0, azimuth=0.4, hinge_tilt=0.3, frequency=0.8, damping_ratio=0.01),
    )
    parameters = answered(case.craft, case.effects[0]).parameters
    given = engine_craft(case.craft, MICROSAT.numbers, 4e5, {})["panels"][0]
    axes, hinge, mass = np.array(given["dcm_HB"]), np.array(given["hinge_m"]), given["mass_kg"]
    own = axes.T @ np.array(given["inertia_kg_m2"]) @ axes

    def energy(rate, swing):
        """Of the plate, with the rest free to move along."""
        turning = rate + swing * axes[1]
        arm = -given["distance_m"] * axes[0]
        velocity = np.cross(rate, hinge + arm) + swing * np.cross(axes[1], arm)
        return 0.5 * turning @ own @ turning + 0.5 * mass * (1.0 - mass / 100.0) * velocity @ velocity

    about_hinge = 2.0 * energy(np.zeros(3), 1.0)
    felt = np.array([energy(each, 1.0) - energy(each, 0.0) - 0.5 * about_hinge for each in np.eye(3)])
    assert parameters["inertia"] == pytest.approx(felt @ felt / about_hinge)
    axis = np.array([parameters[f"axis_{each}"] for each in "xyz"])
    np.testing.assert_allclose(np.cross(axis, felt), 0.0, atol=1e-12)
    assert given["stiffness_N_m_rad"] == pytest.approx(about_hinge * (2.0 * np.pi * 0.8) ** 2)


def answer_of(case, flown):
    return AnswerFile.model_validate(json.loads(strangers_cases._answer(case, [flown])))


def test_a_quarter_has_no_effect_an_eighth_two_and_every_effect_its_turn():
    wanted = stranger_orders("microsat", 200, 1)
    strata = [each.stratum for each in wanted]
    assert [strata.count(name) for name in ("null", "pair", "single")] == [50, 25, 125]
    single = {(each.effect, each.multiple) for each in wanted if each.stratum == "single"}
    assert single == {(effect, times) for effect in WITH_PARTS for times in (2.0, 4.0)}
    assert wanted == stranger_orders("microsat", 200, 1)
    assert wanted != stranger_orders("microsat", 200, 2)


@pytest.fixture
def made(tmp_path, monkeypatch, flown):
    """A case made of the frozen flight, whatever is hidden, and its folders."""

    class Frozen:
        def fly(self, case, *, quiet=False):  # noqa: ARG002
            return [flown] * len(case.runs)

    @contextmanager
    def engine():
        yield Frozen()

    wanted = HiddenEffect(effect="gyro_scale", component="x", parameters={"scale_factor_error": 0.01})
    monkeypatch.setattr(strangers_cases, "engine", engine)
    monkeypatch.setattr(strangers_cases, "searched", lambda *_: (wanted, 18.5))
    order = Order(index=0, stratum="single", effect="gyro_scale", multiple=4.0)
    folder = make_stranger(order, 3, MICROSAT.scenario, tmp_path / "data", tmp_path / "answers")
    return folder, tmp_path / "answers" / folder.name


def test_data_hold_records_and_a_seal_and_nothing_of_the_answer(made):
    data, answer = made
    assert is_sealed(data, answer)
    files = sorted(path.name for path in data.iterdir())
    assert {"run_1.csv", "run_1.toml", "run_2.csv", "run_2.toml", "sealed.sha256"} <= set(files)
    assert all("gyro_scale" not in path.read_text(encoding="utf-8") for path in data.iterdir())
    runs = read_records(data)
    assert all(run.details.gyro_noise == 8e-6 for run in runs)
    assert {"body_rate", "wheel_speed", "wheel_torque_command", "attitude"} == set(runs["run_1"].channels)


def test_what_is_said_of_it_is_scored_by_its_answer(made, tmp_path):
    data, answer = made
    step = {
        "effect": "gyro_scale",
        "component": "x",
        "probability": 0.9,
        "parameters": {"scale_factor_error": {"value": 0.011, "std": 0.001}},
    }
    said = {"complete": True, "verdict": "named", "steps": [step]}
    (tmp_path / "diagnoses" / data.name).mkdir(parents=True)
    (tmp_path / "diagnoses" / data.name / "diagnosis.json").write_text(json.dumps(said), encoding="utf-8")
    (case,) = read_cases(tmp_path / "diagnoses", answer.parent)
    assert case.sealed
    assert said_right(case)
    assert [*parameters_covered(case, 2.0)] == [True]
