"""Twelve blind cases, made by the concealing engine and diagnosed here: nothing hidden, or an effect that is plain.

An effect is hidden at four times the size that is seen with 90 % power, one that no library lists at 16 sigma. A case
that is answered wrongly stays in the set, marked with what is wrong about it.
"""

from __future__ import annotations

import json

import pytest

from benchmarks.blind_diagnosis import diagnosis_of
from concealing.files import conceal
from support.blind_cases import blind_case
from support.diagnosed_records import SCENARIO
from testbed.scoring.case import read_cases
from testbed.scoring.judging import inertia_covered, named, recognised_as_unknown, said_right, set_holds_truth

CHANCE = 4.5
"""Standard errors within which every inertia entry lies: with 12 times 6 entries, one is outside in 1 of 2,000 sets."""
NULL = ((1, "cmg"), (2, "cmg"), (3, "cmg"), (4, "applied_torque"))
PLAIN = (
    (4, "gyro_latency", "gyro"),
    (5, "rotor_speed", "cmg3"),
    (6, "viscous_drag", "platform"),
    (7, "gimbal_zero", "cmg2"),
    (8, "body_torque", "platform"),
    (11, "gyro_misalignment", "gyro"),
    (10, "gimbal_viscous_friction", "cmg5"),
)


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """Return a function that makes a case, diagnoses its records and holds the diagnosis against the sealed answer."""
    kept = {}

    def case(seed, effect=None, component="", size=4.0, actuation="cmg"):
        key = (seed, effect, actuation)
        if key not in kept:
            folder = tmp_path_factory.mktemp("case")
            conceal(blind_case(seed, effect, component, size, actuation), folder / "data", folder / "answer")
            content = json.dumps(diagnosis_of(SCENARIO, folder / "data"))
            (folder / "diagnosis.json").write_text(content, encoding="utf-8")
            (kept[key],) = read_cases(folder, folder / "answer")
            assert kept[key].sealed
        return kept[key]

    return case


@pytest.mark.parametrize(("seed", "actuation"), NULL)
def test_nothing_is_named_where_nothing_is_hidden(judged, seed, actuation):
    case = judged(seed, actuation=actuation)
    assert case.diagnosis.verdict == "none"
    assert not named(case)
    assert all(inertia_covered(case, CHANCE, with_effects=True))


@pytest.mark.parametrize(("seed", "effect", "component"), PLAIN)
def test_a_plain_effect_is_first_at_its_component(judged, seed, effect, component):
    case = judged(seed, effect, component)
    assert said_right(case)  # itself or by its class: drag is not distinguished from a tether that only damps
    assert set_holds_truth(case)
    assert all(inertia_covered(case, CHANCE, with_effects=True))


@pytest.mark.parametrize(("seed", "effect", "component"), PLAIN)
def test_a_plain_effect_is_the_only_one(judged, seed, effect, component):
    assert len(named(judged(seed, effect, component))) == 1


@pytest.mark.parametrize(("seed", "effect", "component"), PLAIN)
def test_a_plain_effect_leaves_nothing_unexplained(judged, seed, effect, component):
    assert not recognised_as_unknown(judged(seed, effect, component))


def test_a_torque_of_no_library_is_called_unexplained_and_gets_no_name(judged):
    case = judged(12, "sine_torque", "platform", 16.0)
    assert recognised_as_unknown(case)
    assert not named(case)
