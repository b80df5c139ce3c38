"""The score card of cases made by hand, each figure counted on fingers."""

from __future__ import annotations

import hashlib
import json

import pytest
from typer.testing import CliRunner

from testbed.cli.app import app
from testbed.errors import InputError
from testbed.scoring.calibration import bins
from testbed.scoring.card import card_content, score_card
from testbed.scoring.case import read_cases
from testbed.scoring.judging import parameters_covered, recognised_as_unknown, reported_set, said_right, set_holds_truth
from testbed.scoring.rows import quantile, share

THETA = [4e-2] * 3 + [0.0] * 3


def step(effect, component="gyro", probability=0.9, like=(), **parameters):
    return {
        "effect": effect,
        "component": component,
        "probability": probability,
        "parameters": {name: {"value": value, "std": std, "unit": "s"} for name, (value, std) in parameters.items()},
        "indistinguishable_from": [dict(zip(("effect", "component"), other, strict=True)) for other in like],
        "j_theta_kg_m2": THETA,
        "j_std_kg_m2": [1e-4] * 6,
    }


def said(*steps, verdict="named", probabilities=None, heldout=1.0, complete=True):
    return {
        "schema": 1,
        "complete": complete,
        "verdict": verdict,
        "steps": list(steps),
        "gap": {"heldout_after": heldout},
        "probabilities": probabilities or {},
    }


def hidden(*effects, stratum="single", rates=((0.2, 0.0, 0.0),), **notes):
    return {
        "schema": 1,
        "stratum": stratum,
        "effects": [
            {"effect": name, "component": where, "parameters": {"delay_s": {"value": 0.01, "unit": "s"}}}
            for name, where in effects
        ],
        "notes": notes,
        "true_theta_kg_m2": THETA,
        "initial_rates_rad_s": rates,
    }


LATENCY = ("gyro_latency", "gyro")
NULL = hidden(stratum="null")
TWICE = hidden(LATENCY, detectable_sizes=2.0)


@pytest.fixture
def scored(tmp_path):
    """Write cases, pairs of answer and diagnosis or None, and read them back."""

    def cases(*pairs):
        for number, (answer, diagnosis) in enumerate(pairs, start=1):
            name = f"case_{number:04d}"
            put(tmp_path / "answers" / name / "answer.json", answer)
            seal = tmp_path / "data" / name / "sealed.sha256"
            seal.parent.mkdir(parents=True)
            seal.write_text(hashlib.sha256((tmp_path / "answers" / name / "answer.json").read_bytes()).hexdigest())
            if diagnosis is not None:
                put(tmp_path / "diagnoses" / name / "diagnosis.json", diagnosis)
        return read_cases(tmp_path / "diagnoses", tmp_path / "answers")

    return cases


def put(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content), encoding="utf-8")


def row(cases, part, what):
    return next(each for each in score_card(cases).rows if (each.part, each.what) == (part, what))


def test_names_on_null_sets_are_counted_with_a_missing_case_among_them(scored):
    none = said(verdict="none", probabilities={"none": 0.9})
    inertia_only = said(step("inertia", "platform"), verdict="none")
    found = row(
        scored((NULL, none), (NULL, inertia_only), (NULL, said(step(*LATENCY))), (NULL, None)),
        "No effect",
        "a name is given",
    )
    assert (found.hits, found.of) == (2, 4)


def test_intervals_are_those_of_the_binomial_tables():
    found = share("", "", [True] * 5 + [False] * 95)
    # Clopper-Pearson of 5 in 100: 1.64 to 11.28 %; one-sided 95 % limit 10.23 % (tables of the beta distribution)
    assert (found.low, found.high, found.upper_limit) == pytest.approx((0.01643, 0.11284, 0.10225), abs=1e-5)
    assert share("", "", [False] * 10).upper_limit == pytest.approx(1.0 - 0.05**0.1)


def test_first_is_effect_and_component(scored):
    rotor = hidden(("rotor_speed", "cmg3"), detectable_sizes=4.0)
    cases = scored(
        (rotor, said(step("rotor_speed", "cmg3"))), (rotor, said(step("rotor_speed", "cmg6"))), (rotor, None)
    )
    part = "One effect at 4 times"
    assert row(cases, part, "effect class and component first").hits == 1
    assert row(cases, part, "effect first, at any component").hits == 2
    assert row(cases, part, "effect class and component first").of == 3


def test_the_set_is_the_named_its_look_alikes_and_what_is_nearly_as_probable(scored):
    probabilities = {"none": 0.5, "gyro_latency:gyro": 0.4, "tether:platform": 0.021, "contact:platform": 0.019}
    like = [("gyro_bandwidth", "gyro")]
    (case,) = scored((TWICE, said(step(*LATENCY, probability=0.4, like=like), probabilities=probabilities)))
    assert reported_set(case.diagnosis) == {"gyro_latency:gyro", "gyro_bandwidth:gyro", "tether:platform"}


def test_where_nothing_is_named_the_set_is_that_of_the_probabilities(scored):
    probabilities = {"none": 0.9, "gyro_latency|gyro_bandwidth": 0.08, "contact": 0.001}
    missed, wrong = scored(
        (TWICE, said(verdict="none", probabilities=probabilities)),
        (TWICE, said(verdict="none", probabilities={"none": 0.9, "contact": 0.1})),
    )
    assert reported_set(missed.diagnosis) == {"gyro_latency", "gyro_bandwidth"}
    assert set_holds_truth(missed)
    assert not set_holds_truth(wrong)
    assert not said_right(missed)


def test_an_exact_alias_is_right_where_its_class_is_stated_and_the_momentum_is_zero(scored):
    scale = ("gyro_scale", "x")
    still = hidden(scale, detectable_sizes=2.0, rates=((0.01, 0.0, 0.0), (0.0, 0.02, 0.0)))
    spinning = hidden(scale, detectable_sizes=2.0)
    named_inertia = said(step("inertia", "platform", like=[scale]), verdict="none")
    bare = said(step("inertia", "platform"), verdict="none")
    assert [said_right(case) for case in scored((still, named_inertia), (still, bare), (spinning, named_inertia))] == [
        True,
        False,
        False,
    ]


def test_unknown_is_the_verdict_and_names_beside_it_are_shown_apart(scored):
    eight = hidden(("sine_torque", "platform"), stratum="unlisted", wanted_sigma=8.0)
    cases = scored(
        (eight, said(verdict="unexplained", probabilities={"unknown": 0.8})),
        (eight, said(step("slosh", "platform"), verdict="unexplained")),
        (eight, said(step("slosh", "platform"))),
    )
    assert row(cases, "Unmodelled torque at 8 sigma", "unexplained is reported").hits == 2
    assert row(cases, "Unmodelled torque at 8 sigma", "no name is given").hits == 1


def test_a_pair_has_to_be_exact(scored):
    pair = hidden(LATENCY, ("tether", "platform"), stratum="pair", detectable_sizes=4.0)
    both = said(step("tether", "platform"), step("inertia", "platform"), step(*LATENCY))
    more = said(step("tether", "platform"), step(*LATENCY), step("contact", "platform"))
    cases = scored((pair, both), (pair, more), (pair, said(step(*LATENCY))))
    assert row(cases, "Two effects", "exactly the pair").hits == 1
    assert row(cases, "Two effects", "one of them first").hits == 3


def test_coverage_counts_intervals_of_right_names_and_all_six_of_the_inertia(scored):
    inside, outside = (0.01 + 1.9e-3, 1e-3), (0.01 + 2.0e-3, 1e-3)
    off = said(step(*LATENCY, delay_s=outside), step("gyro_noise"))
    off["inertia"] = {"before": {"theta_kg_m2": [1.0] * 6, "std_kg_m2": [1e-4] * 6}}
    once = hidden(LATENCY, detectable_sizes=1.0)
    cases = scored(
        (TWICE, said(step(*LATENCY, delay_s=inside))), (TWICE, off), (once, said(step(*LATENCY, delay_s=inside)))
    )
    part = "95 % intervals that hold the truth"
    parameters = row(cases, part, "parameters of effects named")
    assert (parameters.hits, parameters.of) == (1, 2)
    inertia = row(cases, part, "inertia with what was named")
    assert (inertia.hits, inertia.of) == (12, 12)
    assert (row(cases, part, "inertia without any effect").hits, row(cases, part, "inertia without any effect").of) == (
        0,
        6,
    )


def test_the_heldout_gap_is_taken_of_right_names_only(scored):
    cases = scored(
        *((TWICE, said(step(*LATENCY), heldout=gap)) for gap in (0.98, 1.0, 1.2)),
        (TWICE, said(step("slosh", "platform"), heldout=9.0)),
    )
    assert row(cases, "Held-out gap after naming", "median").value == 1.0
    assert row(cases, "Held-out gap after naming", "90th percentile").value == pytest.approx(1.16)
    assert quantile("", "", [1.0] * 3, 0.9).high is None  # three values bound no 90th percentile


def test_calibration_error_is_the_mean_distance_of_the_bins(scored):
    cases = scored(
        *((TWICE, said(step(*LATENCY, probability=0.95))) for _ in range(3)),
        (TWICE, said(step("contact", "platform", probability=0.95))),
        (NULL, said(verdict="none", probabilities={"none": 0.65})),
        (NULL, None),
    )
    # four at 0.95 of which 3/4 are right, one at 0.65 that is: (4 * 0.20 + 1 * 0.35) / 5
    assert row(cases, "Probabilities", "expected calibration error").value == pytest.approx(0.23)
    assert [(each.of, each.right) for each in bins(cases)] == [(1, 1.0), (4, 0.75)]


def test_confusion_says_what_was_taken_for_what(scored):
    cases = scored((TWICE, said(step("contact", "platform"))), (TWICE, None), (NULL, said(verdict="none")))
    assert score_card(cases).confusion == {"gyro_latency": {"contact": 1, "missing": 1}, "none": {"none": 1}}


def test_an_incomplete_or_unreadable_diagnosis_is_a_miss_with_a_reason(scored, tmp_path):
    put(tmp_path / "diagnoses" / "case_0002" / "diagnosis.json", {"verdict": "perhaps"})
    card = score_card(
        scored((TWICE, said(step(*LATENCY), complete=False)), (TWICE, None), (TWICE, said(step(*LATENCY))))
    )
    assert "not complete" in card.failures["case_0001"]
    assert "case_0002" in card.failures["case_0002"]
    assert card.sealed == card.cases == 3


@pytest.mark.parametrize("verdict", ["none", None])  # as it was once written, and as it is
def test_an_incomplete_diagnosis_is_no_answer_even_where_nothing_is_hidden(scored, verdict):
    cases = scored((NULL, said(verdict=verdict, complete=False)), (NULL, said(verdict="none")))
    assert [case.diagnosis is None for case in cases] == [True, False]
    assert [said_right(case) for case in cases] == [False, True]


def test_a_complete_diagnosis_without_a_verdict_is_a_miss_with_a_reason(scored):
    cases = scored((NULL, said(verdict=None)), (NULL, said(verdict="none")))
    assert "has no verdict" in cases[0].failure


def test_a_changed_answer_is_refused(scored, tmp_path):
    scored((NULL, said(verdict="none")))
    put(tmp_path / "answers" / "case_0001" / "answer.json", TWICE)
    with pytest.raises(InputError, match="is not the answer that"):
        read_cases(tmp_path / "diagnoses", tmp_path / "answers")


def test_the_command_prints_a_table_and_writes_the_card_once(scored, tmp_path):
    cases = scored((NULL, said(verdict="none")), (TWICE, said(step(*LATENCY))))
    out = tmp_path / "card.json"
    command = ["score", str(tmp_path / "diagnoses"), str(tmp_path / "answers"), "--out", str(out)]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0
    assert "effect class and component first" in result.output
    assert json.loads(out.read_text(encoding="utf-8")) == json.loads(json.dumps(card_content(score_card(cases))))
    with pytest.raises(InputError, match="nothing is overwritten"):
        CliRunner().invoke(app, command, catch_exceptions=False)


def test_folders_without_cases_are_refused(tmp_path):
    with pytest.raises(InputError, match="name the folder of the answers"):
        read_cases(tmp_path, tmp_path)
    put(tmp_path / "answers" / "case_0001" / "answer.json", NULL)
    with pytest.raises(InputError, match="holds no diagnosis of any case"):
        read_cases(tmp_path / "diagnoses", tmp_path / "answers")


def test_a_gyro_turned_or_oblique_is_the_same_effect_at_the_same_component(scored):
    oblique = hidden(("gyro_misalignment", "gyro_cross_axis"), detectable_sizes=4.0)
    turned = said(
        step("gyro_misalignment", "gyro", delay_s=(0.01, 1e-3)), probabilities={"gyro_misalignment:gyro": 0.9}
    )
    (case,) = scored((oblique, turned))
    assert said_right(case)
    assert set_holds_truth(case)
    assert not [*parameters_covered(case, 2.0)]  # their numbers do not mean the same


@pytest.mark.parametrize(
    ("axis", "covered"), [((0.6, -0.8), [True, True]), ((-0.6, 0.8), [True, True]), ((0.8, 0.6), [False] * 2)]
)
def test_an_axis_stated_the_other_way_round_is_the_same_axis(scored, axis, covered):
    answer = hidden(("flexible_appendage", "platform"), detectable_sizes=4.0)
    answer["effects"][0]["parameters"] = {"axis_x": {"value": 0.6}, "axis_z": {"value": -0.8}}
    found = step("flexible_appendage", "platform", axis_x=(axis[0], 0.02), axis_z=(axis[1], 0.02))
    (case,) = scored((answer, said(found)))
    assert [*parameters_covered(case, 2.0)] == covered


def test_flown_cases_have_rows_of_their_own(scored):
    without, with_it = hidden(stratum="flown"), hidden(LATENCY, stratum="flown", detectable_sizes=2.0)
    none, late = said(verdict="none"), said(step(*LATENCY))
    cases = scored((without, none), (without, late), (with_it, late), (with_it, none), (with_it, late))
    part = "Flown in MuJoCo"
    named = row(cases, part, "no effect: a name is given")
    assert (named.hits, named.of) == (1, 2)
    assert row(cases, part, "effect class and component first at 2 times").hits == 2
    assert row(cases, "95 % intervals that hold the truth", "inertia with what was named").of == 12


def test_a_formula_recognises_what_no_library_lists_and_is_a_wrong_name_elsewhere(scored):
    formula = said(step("formula", "w_x*w_y about z"))
    cases = scored(
        (hidden(("sine_torque", "platform"), stratum="unlisted", wanted_sigma=8.0), formula), (NULL, formula)
    )
    unmodelled, null = cases
    assert recognised_as_unknown(unmodelled)
    assert said_right(unmodelled)
    assert not said_right(null)
