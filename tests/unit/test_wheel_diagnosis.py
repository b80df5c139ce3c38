"""Diagnoses of a CubeSat's wheels: what its motors, bearings and rotors hide is named first, and of none nothing is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import testbed.library.diagnoses
from testbed.assembly.extension import extended
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.diagnosis.findings import additions
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.diagnosis.tachometers import shown_beside_tachometers
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects import registered
from testbed.effects.contract import ALL_WHEELS
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.errors import InputError
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.records.record import Record
from testbed.records.selection import telemetry_only
from testbed.report.diagnosis.verdict import diagnosis_verdict
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

OF_WHEELS = {name: effect for name, effect in EFFECTS.items() if name.startswith("wheel_")}
SEEDS = (90041, 90042, 90043)
"""Of the flights; nothing was looked at or calibrated on them before."""
HIDDEN = {
    "wheel_viscous_friction": 1e-8,
    "wheel_coulomb_friction": 5e-6,
    "wheel_torque_scale": 0.01,
    "wheel_lag": 0.01,
    "wheel_imbalance": 5e-7,
}
"""Sizes that hardware has, of frictions such that twelve seconds at nearly constant speed distinguish the two."""
WHEEL = "wheel3"


def scenario(**simulation: float) -> Scenario:
    """Twelve seconds of the shipped CubeSat.

    Args:
        simulation: keys of the section that differ.
    """
    shipped = read_scenario(shipped_scenario("cubesat_wheels"))
    keys = {"duration_s": 12.0} | simulation
    return shipped.model_copy(update={"simulation": shipped.simulation.model_copy(update=keys)})


@cache
def records(effect: str | None, component: str = WHEEL, **simulation: float) -> tuple[Record, ...]:
    """Fly three runs with the effect in one wheel, or in all."""
    believed = scenario(**simulation)
    nominal, hidden = nominal_platform(believed), believed
    if effect is not None:
        hidden = extended(hidden, registered()[effect].extension(component, np.array([HIDDEN[effect]]), hidden))
    maneuver = plan_maneuver(believed, nominal).maneuver
    flown = [fly_maneuver(hidden, nominal, true_platform(hidden), maneuver, seed).record for seed in SEEDS]
    named = [replace(each, details=replace(each.details, name=f"run {at}")) for at, each in enumerate(flown)]
    return tuple(telemetry_only(each) for each in named)


def without(channel: str) -> list[Record]:
    return [
        replace(each, channels={name: values for name, values in each.channels.items() if name != channel})
        for each in records(None)
    ]


def data_of(recorded):
    return data_set_of(list(recorded), scenario(), nominal_platform(scenario()))


def states(effect: str | None) -> Iterator[Diagnosis]:
    data = data_of(records(effect))
    theta = theta_of(nominal_platform(scenario()).inertia)
    return diagnosed(data.runs, data.heldout, OF_WHEELS, theta, noise_effects=NOISE_EFFECTS)


@cache
def late() -> Diagnosis:
    """Return the complete diagnosis of flights with a late motor."""
    *_, final = states("wheel_lag")
    return final


@pytest.mark.parametrize("effect", HIDDEN)
def test_what_one_wheel_hides_is_named_first_with_its_size(effect):
    first = next(named[0] for named in map(additions, states(effect)) if named)
    assert (first.effect.id, first.component) == (effect, WHEEL)
    assert not first.look_alikes
    (size,) = first.quantities
    print(f"{effect}: {size.value:.3g} ± {size.std:.2g} of {HIDDEN[effect]:g}")
    assert abs(size.value - HIDDEN[effect]) < 4.0 * size.std


def test_a_name_stands_when_the_residual_was_tested():
    assert [each.effect.id for each in additions(late())] == ["wheel_lag"]


def test_nothing_is_named_of_wheels_that_are_as_believed():
    *_, final = states(None)
    assert additions(final) == ()


def early(record: Record) -> Record:
    """Return a record whose commands are stamped one telemetry period before they act."""
    command = record.channels["wheel_torque_command"]
    acting_next = np.concatenate([command[1:], command[-1:]])
    return replace(record, channels={**record.channels, "wheel_torque_command": acting_next})


def test_commands_that_all_act_a_period_late_are_one_delay():
    """And no motor's lag: of three of these the model missed the impulses by 8 times their noise, and was believed."""
    data = data_of([early(each) for each in records(None)])
    theta = theta_of(nominal_platform(scenario()).inertia)
    *_, final = diagnosed(data.runs, data.heldout, OF_WHEELS, theta, noise_effects=NOISE_EFFECTS)
    (delay,) = additions(final)
    assert (delay.effect.id, delay.component) == ("wheel_delay", "wheels")
    (size,) = delay.quantities
    assert size.value == pytest.approx(1.0 / scenario().simulation.control_rate_hz, abs=4.0 * size.std)
    assert final.actuators_missed < SETTINGS.channel_missed


def test_motors_that_are_late_alike_are_one_lag():
    """It was a delay of all, and lags of a few tenths of a millisecond of single motors for the rest."""
    data = data_of(records("wheel_lag", ALL_WHEELS))
    theta = theta_of(nominal_platform(scenario()).inertia)
    *_, final = diagnosed(data.runs, data.heldout, OF_WHEELS, theta, noise_effects=NOISE_EFFECTS)
    (lag,) = additions(final)
    assert (lag.effect.id, lag.component) == ("wheel_lag", ALL_WHEELS)
    (size,) = lag.quantities
    assert abs(size.value - HIDDEN["wheel_lag"]) < 4.0 * size.std


@pytest.mark.parametrize("effect", ["wheel_viscous_friction", "wheel_coulomb_friction"])
def test_bearings_that_brake_alike_are_one_friction(effect):
    """As in the cold: taken one by one they are four names, of which three are given and the rest is unexplained."""
    data, theta = data_of(records(effect, ALL_WHEELS)), theta_of(nominal_platform(scenario()).inertia)
    *_, final = diagnosed(data.runs, data.heldout, OF_WHEELS, theta, noise_effects=NOISE_EFFECTS)
    (named,) = additions(final)
    assert (named.effect.id, named.component, final.verdict) == (effect, ALL_WHEELS, "named")
    (size,) = named.quantities
    assert abs(size.value - HIDDEN[effect]) < 4.0 * size.std


def test_what_the_motors_do_beside_all_that_is_named_is_unexplained():
    """However well the body's motion is explained."""
    data = data_of([early(each) for each in records(None)])
    theta = theta_of(nominal_platform(scenario()).inertia)
    library = {name: effect for name, effect in OF_WHEELS.items() if name not in ("wheel_delay", "wheel_lag")}
    *_, final = diagnosed(data.runs, data.heldout, library, theta, noise_effects=NOISE_EFFECTS)
    assert final.actuators_missed > SETTINGS.channel_missed
    assert final.verdict == "unexplained"
    assert "do not do what they were asked for" in diagnosis_verdict(final).text


SLOW = {"duration_s": 75.0, "telemetry_rate_hz": 5.0}
"""Telemetry that shows one command of four. The maneuver ends after a minute, in a step between two samples."""


@pytest.mark.parametrize("believed_rate", [20.0, 5.0])
def test_commands_between_samples_are_no_delay(believed_rate):
    """Feedback of the gyro's noise holds for less than an interval; taken for smooth, it was named with P = 1."""
    flown = records(None, control_rate_hz=20.0, **SLOW)
    believed = scenario(control_rate_hz=believed_rate, **SLOW)
    data = data_set_of(list(flown), believed, nominal_platform(believed))
    assert any("control_rate_hz" in each for each in data.notices) == (believed_rate == 5.0)
    theta = theta_of(nominal_platform(believed).inertia)
    *_, final = diagnosed(data.runs, data.heldout, OF_WHEELS, theta, noise_effects=NOISE_EFFECTS)
    assert additions(final) == ()


@pytest.mark.parametrize(("keys", "hidden"), [({"control_rate_hz": 20.0, **SLOW}, True), ({}, False)])
def test_modes_are_untestable_where_commands_do_not_show_the_noise_of_tachometers(keys, hidden):
    """A loose mass that takes noise of the predicted body rate away was named with P = 1 of five longer flights."""
    believed = scenario(**keys)
    data = data_set_of(list(records(None, **keys)), believed, nominal_platform(believed))
    tested, untestable = shown_beside_tachometers(data.runs, EFFECTS, theta_of(nominal_platform(believed).inertia))
    modes = {"flexible_appendage", "slosh"} if hidden else set()
    assert set(EFFECTS) - set(tested) == modes
    assert {each.effect for each in untestable} == modes


def test_a_late_motor_is_found_behind_commands_between_samples():
    believed = scenario(control_rate_hz=20.0, **SLOW)
    hidden = extended(believed, registered()["wheel_lag"].extension(WHEEL, np.array([0.1]), believed))
    nominal = nominal_platform(believed)
    maneuver = plan_maneuver(believed, nominal).maneuver
    flown = [fly_maneuver(hidden, nominal, true_platform(hidden), maneuver, seed).record for seed in SEEDS]
    named = [replace(each, details=replace(each.details, name=f"run {at}")) for at, each in enumerate(flown)]
    data = data_set_of([telemetry_only(each) for each in named], believed, nominal)
    states = diagnosed(data.runs, data.heldout, OF_WHEELS, theta_of(nominal.inertia), noise_effects=NOISE_EFFECTS)
    first = next(found[0] for found in map(additions, states) if found)
    assert (first.effect.id, first.component) == ("wheel_lag", WHEEL)
    (size,) = first.quantities
    print(f"{size.value:.3f} ± {size.std:.3f} s")
    assert abs(size.value - 0.1) < 4.0 * size.std


def test_motors_are_compared_by_their_currents_where_no_command_was_sent():
    runs = data_of(without("wheel_torque_command")).runs
    assert runs.grid.wheel_noise is not None
    assert not runs.grid.wheel_noise.commanded
    testable, untestable = hypotheses(runs, OF_WHEELS)
    assert "wheel_torque_scale" in {each.effect.id for each in testable}
    late = {"wheel_lag", "wheel_delay"}  # a current shows the torque as it is given
    assert {each.effect for each in untestable} == late


@pytest.mark.parametrize(("factor", "said"), [(1e3, "torque_limit_N_m"), (0.1, "10, "), (-1.0, "-1, ")])
def test_a_command_in_another_unit_or_of_the_other_sign_is_compared_with_nothing_and_that_is_said(factor, said):
    """Currents are held against the motion instead."""
    scaled = [
        replace(
            each, channels={**each.channels, "wheel_torque_command": factor * each.channels["wheel_torque_command"]}
        )
        for each in records(None)
    ]
    data = data_of(scaled)
    noise = data.runs.grid.wheel_noise
    assert noise is None or not noise.commanded
    (notice,) = [each for each in data.notices if each.startswith("wheel_torque_command")]
    assert said in notice


def test_a_measured_torque_in_another_unit_is_said_beside_commands_that_are_followed():
    scaled = [
        replace(each, channels={**each.channels, "wheel_torque": 1e3 * each.channels["wheel_torque"]})
        for each in records(None)
    ]
    data = data_of(scaled)
    assert data.runs.grid.wheel_noise.commanded
    (notice,) = [each for each in data.notices if each.startswith("wheel_torque is not compared")]
    assert "gain 0.001, 0.001" in notice


def test_a_command_that_is_followed_is_said_nothing_of():
    assert not any("not compared" in each for each in data_of(records(None)).notices)


def test_records_without_torques_test_for_none_of_their_effects():
    bare = [
        replace(each, channels={name: of for name, of in each.channels.items() if not name.startswith("wheel_torque")})
        for each in records(None)
    ]
    runs = data_of(bare).runs
    assert runs.grid.wheel_noise is None
    assert {each.effect.id for each in hypotheses(runs, OF_WHEELS)[0]} == {
        "wheel_inertia",
        "wheel_misalignment",
        "wheel_speed_bias",
    }


def test_a_next_flight_that_cannot_be_designed_leaves_the_diagnosis_as_it_is(monkeypatch):
    def refused(*_):
        raise InputError("the motion leaves the finite numbers")

    monkeypatch.setattr(testbed.library.diagnoses, "proposal_of", refused)
    proposal, said = testbed.library.diagnoses._next_flight(scenario(), late(), lambda _: None)
    assert proposal is None
    assert said == ("no next flight: the motion leaves the finite numbers",)


def test_wheels_of_which_nothing_is_ambiguous_need_no_next_flight():
    assert testbed.library.diagnoses._next_flight(scenario(), late(), lambda _: None) == (None, ())
