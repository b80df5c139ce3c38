"""The methods beside the diagnosis, on cases made by hand; and the page that shows them all."""

from __future__ import annotations

from math import log

import pytest
from scipy.stats import chi2

from benchmarks.blind_baselines import (
    BIC,
    ORACLE,
    OURS,
    REDUCTION,
    SINDY,
    best_criterion,
    comparisons,
    largest_reduction,
    significant,
)
from benchmarks.blind_page import Making, content_of, page
from benchmarks.blind_unlisted import Bound, kinds_of
from testbed.scoring.card import score_card
from testbed.scoring.case import Case
from testbed.scoring.formats import AnswerFile, DiagnosisFile, Hidden, Named, Step

SAMPLES = 300
ROTOR, SLOSH = Named(effect="rotor_speed", component="cmg3"), Named(effect="slosh", component="platform")


def compared(*hypotheses):
    keys = ("effect", "component", "rank", "gain")
    return {
        "samples": SAMPLES,
        "tested": 60,
        "hypotheses": [dict(zip(keys, each, strict=True)) for each in hypotheses],
    }


def case(name, *hidden, said=None, stratum="single", **notes):
    steps = () if said is None else (Step(effect=said.effect, component=said.component, probability=0.9),)
    answer = AnswerFile(
        stratum=stratum,
        effects=tuple(Hidden(effect=each.effect, component=each.component) for each in hidden),
        notes=notes,
        true_theta_kg_m2=(0.02,) * 6,
    )
    verdict = "named" if steps else "none"
    return Case(name=name, answer=answer, diagnosis=DiagnosisFile(complete=True, verdict=verdict, steps=steps))


CLEAR = compared(("rotor_speed", "cmg3", 1, 40.0), ("slosh", "platform", 5, 45.0))
FAINT = compared(("rotor_speed", "cmg3", 1, 4.0), ("slosh", "platform", 5, 9.0))


def test_the_largest_reduction_takes_no_account_of_parameters_and_the_criterion_does():
    assert largest_reduction(CLEAR) == SLOSH.key
    assert best_criterion(CLEAR) == ROTOR.key


def test_without_a_test_chance_gets_a_name_but_where_the_criterion_is_worse_than_none():
    assert largest_reduction(FAINT) == SLOSH.key
    assert best_criterion(FAINT) == "none"
    assert largest_reduction(compared()) == best_criterion(compared()) == "none"
    assert best_criterion(compared(("rotor_speed", "cmg3", 1, log(SAMPLES) + 0.1))) == ROTOR.key


def test_the_oracle_asks_for_one_hypothesis_at_the_error_of_all():
    just = float(chi2.isf(0.05 / 60, 1))
    assert significant(compared(("rotor_speed", "cmg3", 1, just + 0.01)), ROTOR)
    assert not significant(compared(("rotor_speed", "cmg3", 1, just - 0.01)), ROTOR)
    assert not significant(compared(("rotor_speed", "cmg4", 1, 100.0)), ROTOR)


@pytest.fixture
def three():
    """One null set, and one effect at four times, once found by all and once by none but the oracle."""
    cases = (
        case("a", stratum="null"),
        case("b", ROTOR, said=ROTOR, detectable_sizes=4.0),
        case("c", SLOSH, said=ROTOR, detectable_sizes=4.0),
    )
    candidates = {"a": FAINT, "b": compared(("rotor_speed", "cmg3", 1, 40.0)), "c": CLEAR}
    return cases, comparisons(cases, candidates, {"a": "none", "b": SLOSH.key})


def test_all_methods_stand_side_by_side(three):
    null, single = three[1]
    assert {method: row.hits for method, row in null.rows.items()} == {OURS: 1, REDUCTION: 0, BIC: 1, SINDY: 1}
    assert (single.part, single.what) == ("One effect at 4 times", "the very effect first")
    assert {method: row.hits for method, row in single.rows.items()} == {
        OURS: 1,
        REDUCTION: 2,
        BIC: 1,
        SINDY: 0,
        ORACLE: 2,
    }
    assert {method: row.of for method, row in single.rows.items()} == {
        OURS: 2,
        REDUCTION: 2,
        BIC: 2,
        SINDY: 1,  # it was asked of one only
        ORACLE: 2,
    }


def test_a_case_that_was_not_diagnosed_is_a_miss_of_every_method():
    cases = (case("a", ROTOR, detectable_sizes=2.0),)
    (single,) = comparisons(cases, {}, {})
    assert {method: row.hits for method, row in single.rows.items()} == {OURS: 0, REDUCTION: 0, BIC: 0, ORACLE: 0}


def test_the_page_shows_every_figure_and_how_it_came_about(three):
    cases, others = three
    card = score_card(cases)
    making = Making(
        command="make blind", seed=5, where="Scored then", making_seconds=(1.0, 2.0, 9.0), diagnosis_seconds=()
    )
    text = page(content_of(card, others, (), making))
    assert "unlisted" not in text
    assert "`make blind`, seed 5, 3 cases" in text
    assert "Making a case took 2.0 s in the median, 9.0 s at most, 0 min in all." in text
    for row in card.rows:
        assert f"| {row.what} |" in text
    assert "| One effect at 4 times: the very effect first | 2 | 50.0% (1.3% to 98.7%) |" in text
    assert "0.0% (0.0% to 97.5%, of 1)" in text  # SINDy
    assert "| slosh | rotor_speed 1 |" in text
    assert "| 0.9 to 1.0 | 0.900 | 0.500 | 2 |" in text
    widths = {
        line.count("|") for line in text.splitlines() if line.startswith("| One effect") or line.startswith("| No")
    }
    assert widths == {8}  # every row of the comparison has all columns


def test_what_could_be_known_of_the_unlisted_stands_beside_what_was_said():
    torques = [Named(effect=effect, component="platform") for effect in ("ramp_torque", "ramp_torque", "sine_torque")]
    cases = tuple(
        case(name, torque, said=SLOSH, stratum="unlisted", wanted_sigma=8.0)
        for name, torque in zip("abc", torques, strict=True)
    )
    bounds = {
        name: Bound(case=name, shown=8.0, best="body_torque:platform", left=left, power=power)
        for name, left, power in (("a", 2.0, 0.3), ("b", 4.0, 0.9), ("c", 8.0, 1.0))
    }
    ramp, sine = kinds_of(cases, bounds)
    assert (ramp.effect, ramp.of, ramp.left, ramp.power, ramp.recognised) == ("ramp_torque", 2, 3.0, 0.6, 0.0)
    assert (sine.effect, sine.of, sine.power) == ("sine_torque", 1, 1.0)
    making = Making(command="make blind", seed=5, where="then", making_seconds=(), diagnosis_seconds=())
    text = page(content_of(score_card(cases), (), (ramp, sine), making))
    assert "| ramp_torque at 8 | 2 | 8.0 | 3.0 | 60% | 0% |" in text
    assert "At 8 sigma, the oracle recognises 73% in the mean." in text
