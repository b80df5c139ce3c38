"""Blind cases of craft with wheels: sealed sets, and what a diagnosis among a few effects says of them.

`python -m benchmarks.blind_wheels` tries the whole library.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from concealing.effect import HiddenEffect
from concealing.order import Order
from concealing.sealing import SEAL, is_sealed
from concealing.wheel_case import WheelCase, WheelRun, platform_of
from concealing.wheel_flight import fly_wheels
from concealing.wheel_set import NULL_SHARE, conceal_wheels, make_wheels, wheel_orders, wheel_record, with_hidden
from concealing.wheel_signature import signal
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.findings import additions
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_scenario

SCENARIOS = Path(__file__).parents[2] / "scenarios"
FREE, STANDING = SCENARIOS / "cubesat_wheels.toml", SCENARIOS / "air_bearing.toml"
LIBRARY = ("wheel_inertia", "wheel_misalignment", "wheel_speed_bias", "viscous_drag", "body_torque", "gyro_bias")
OF_DRIVES = ("wheel_inertia", "wheel_torque_scale", "wheel_lag", "wheel_viscous_friction", "wheel_coulomb_friction")
ON_BEARINGS = ("body_torque", "center_of_mass_offset", "air_drag")
"""Fewer than in free flight: a prediction on a bearing takes three times as long."""


@pytest.fixture(scope="module")
def slow_table(tmp_path_factory):
    """The table on its bearing with a clock of 10 Hz instead of 50: a diagnosis takes a fifth of the time."""
    path = tmp_path_factory.mktemp("slow") / STANDING.name
    path.write_text(STANDING.read_text(encoding="utf-8").replace("_hz = 50.0", "_hz = 10.0"), encoding="utf-8")
    return path


def bare_case(scenario, seed, seconds, runs=3):
    moment = platform_of(scenario).inertia[2, 2]
    return WheelCase(
        scenario=scenario,
        seed=seed,
        runs=tuple(
            WheelRun(duration=seconds, motion=seed + index, at_rest=bool(index % 2), release_error=(0.003, 0.0, -0.002))
            for index in range(runs)
        ),
        theta_error=tuple(moment * np.array([0.03, -0.02, 0.04, 0.01, -0.02, 0.01])),
    )


def named_in(case, library):
    """Return what a diagnosis among some effects names, and where."""
    flown, scenario = fly_wheels(case), read_scenario(case.scenario)
    nominal = nominal_platform(scenario)
    data = data_set_of([wheel_record(flown, index) for index in range(len(case.runs))], scenario, nominal)
    *_, last = diagnosed(data.runs, data.heldout, {name: EFFECTS[name] for name in library}, theta_of(nominal.inertia))
    return [(each.effect.id, each.component) for each in additions(last)], last


@pytest.mark.parametrize("library", [LIBRARY, ON_BEARINGS], ids=["free", "bearing"])
def test_nothing_is_named_of_a_craft_that_is_as_believed(slow_table, library):
    scenario = FREE if library is LIBRARY else slow_table
    names, last = named_in(bare_case(scenario, 11, 12.0), library)
    assert names == []
    assert last.gap.fit == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    ("library", "effect"),
    [(LIBRARY, "wheel_inertia"), (OF_DRIVES, "wheel_lag"), (ON_BEARINGS, "center_of_mass_offset")],
    ids=["free", "drive", "bearing"],
)
def test_an_effect_of_four_detectable_sizes_is_named_at_its_component(slow_table, library, effect):
    scenario = slow_table if library is ON_BEARINGS else FREE
    seconds = (
        20.0 if library is ON_BEARINGS else 12.0
    )  # over less a table hardly turns, and its offset is a constant torque
    case = with_hidden(np.random.default_rng(5), bare_case(scenario, 12, seconds), effect, 4.0)
    names, last = named_in(case, library)
    assert names == [(effect, case.effects[0].component)]
    assert last.gap.fit == pytest.approx(1.0, abs=0.1)


def test_a_friction_shows_less_where_commands_are_lost():
    """The wheels carry on what feedback made of noise in lost rows; without loss the rest is noise of tachometers."""
    friction = HiddenEffect(effect="wheel_viscous_friction", component="wheel2", parameters={"coefficient": 1e-8})
    case = replace(bare_case(FREE, 12, 30.0), effects=(friction,))
    whole, few, many = (signal(replace(case, dropouts=share)) for share in (0.0, 0.02, 0.1))
    print(f"{whole:.1f}, {few:.1f}, {many:.1f} sigma")
    assert many < 0.8 * few < 0.8 * whole


@pytest.mark.parametrize("scenario", [FREE, STANDING], ids=["free", "bearing"])
def test_a_set_has_its_share_without_an_effect_and_every_effect_in_turn(scenario):
    orders, kinds = wheel_orders(scenario, 100, 3), platform_of(scenario).drawn
    hidden = [order for order in orders if order.stratum == "single"]
    assert len(orders) - len(hidden) == round(NULL_SHARE * 100)
    assert {order.effect for order in hidden} == set(kinds)
    counts = [sum(order.effect == effect for order in hidden) for effect in kinds]
    assert max(counts) - min(counts) <= 2  # two sizes, each in turn
    assert orders == wheel_orders(scenario, 100, 3)


def test_a_case_is_sealed_reads_as_measured_and_is_the_same_when_made_again(tmp_path):
    order = Order(index=4, stratum="single", effect="wheel_speed_bias", multiple=2.0)
    data = make_wheels(order, 9, FREE, tmp_path / "data", tmp_path / "answers")
    answers = tmp_path / "answers" / "case_0005"
    assert is_sealed(data, answers)
    answer = json.loads((answers / "answer.json").read_text(encoding="utf-8"))
    (hidden,) = answer["effects"]
    assert hidden["effect"] == "wheel_speed_bias"
    assert set(hidden["parameters"]) == {"bias_rad_s"}
    assert answer["notes"]["detectable_sizes"] == 2.0
    records = read_data_set(data)
    assert len(records) == len(answer["case"]["runs"])
    for record in records:
        assert set(record.channels) == {"body_rate", "wheel_speed", "wheel_torque_command", "wheel_torque"}
        assert not record.extra_columns
    made = {path: path.read_bytes() for path in data.iterdir()}
    (data / SEAL).unlink()
    make_wheels(order, 9, FREE, tmp_path / "data", tmp_path / "answers")
    assert {path: path.read_bytes() for path in data.iterdir()} == made


def test_late_telemetry_shows_earlier_speeds_and_torques():
    late = HiddenEffect(effect="telemetry_skew", component="actuators", parameters={"late": 0.1})
    flown = fly_wheels(replace(bare_case(FREE, 3, 4.0, runs=1), effects=(late,)), quiet=True)
    channels = wheel_record(flown, 0).channels
    assert channels["wheel_speed"][1:] == pytest.approx(flown.log.wheel_speed[:-1, 0])
    assert channels["wheel_torque"][1:] == pytest.approx(flown.log.torque[:-1, 0])
    assert channels["body_rate"] == pytest.approx(flown.log.body_rate[:, 0])


def test_what_is_concealed_is_what_was_flown(tmp_path):
    case = bare_case(FREE, 3, 2.0, runs=1)
    flown = conceal_wheels(case, tmp_path / "data", tmp_path / "answer")
    (record,) = read_data_set(tmp_path / "data")
    assert record.channels["body_rate"] == pytest.approx(flown.log.gyro[:, 0])
    assert record.channels["wheel_speed"] == pytest.approx(flown.log.reading[:, 0])
    assert record.channels["wheel_torque"][1:] == pytest.approx(flown.log.torque[1:, 0])
