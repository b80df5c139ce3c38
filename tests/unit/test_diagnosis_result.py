"""What is said of a diagnosis: inertia as a step of its own, noise as a step, a torque that has no name."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from support.diagnosed_records import NOISE, nominal, records
from support.unlisted_torques import Humming, Pulsing
from testbed.diagnosis.candidates import NONE, UNKNOWN
from testbed.diagnosis.detectable import detectable_sizes
from testbed.diagnosis.location import located
from testbed.diagnosis.method import _with_given_up, diagnosed
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.result import result_of
from testbed.diagnosis.run_residuals import residuals_of
from testbed.diagnosis.settings import SETTINGS
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.outputs.diagnosis_folder import extensions_of
from testbed.report.diagnosis.page import write_diagnosis_page
from testbed.report.diagnosis.ranking import on_the_noise, ranking_rows
from testbed.report.diagnosis.residuals import mean_spectrum, residuals_section
from testbed.report.diagnosis.verdict import diagnosis_verdict, names_of_all, share_words
from testbed.report.frame.blocks import Figure

FEW = {name: EFFECTS[name] for name in ("gyro_latency", "viscous_drag")}
STEADY = {"body_torque": EFFECTS["body_torque"]}


def last(used, inertia_factor=1.0, effects=FEW):
    scenario, platform = nominal()
    data = data_set_of(used, scenario, platform)
    theta = inertia_factor * theta_of(platform.inertia)
    stages = diagnosed(data.runs, data.heldout, effects, theta, noise_effects=NOISE_EFFECTS, alone=data.alone)
    (*_, final) = stages
    return final


def content(diagnosis):
    return result_of(diagnosis, located(diagnosis.runs, diagnosis.baseline), ())


CLEAR_PULSES = 6e-4
"""N·m, of impulses for which the odds against a constant torque are e^8: twice those that are nearly one."""


@pytest.fixture(scope="module")
def pulsing():
    effects = STEADY | {"gyro_latency": EFFECTS["gyro_latency"]}
    return last(records(3, hooks=[Pulsing()], values=[np.array([CLEAR_PULSES])]), effects=effects)


def test_a_single_run_has_no_held_out_gap_and_json_says_null():
    answer = content(last(records(1)))
    assert answer["verdict"] == "none"
    assert not any("what is unexplained" in notice for notice in model_notices(last(records(1))))
    assert answer["gap"]["heldout_after"] is None
    assert answer["steps"] == []
    json.dumps(answer, allow_nan=False)


def test_a_single_run_gets_no_name_and_what_explains_it_is_reported():
    late = EFFECTS["gyro_latency"]
    diagnosis = last(records(1, hooks=[late.hooks("gyro")], values=[np.array([12e-3])]))
    answer = content(diagnosis)
    assert answer["verdict"] == "unexplained"
    assert any("what is unexplained may move it" in notice for notice in model_notices(diagnosis))
    assert {step["effect"] for step in answer["steps"]} <= {"inertia"}
    assert max(answer["probabilities"], key=answer["probabilities"].get) == "gyro_latency:gyro"
    assert "What explains it best: gyro_latency (gyro). A single run gets no name" in diagnosis_verdict(diagnosis).text


def test_what_a_re_estimated_noise_explains_is_not_credited_to_the_effects():
    late = EFFECTS["gyro_latency"]
    found = last(records(3, hooks=[late.hooks("gyro")], values=[np.array([12e-3])]))
    louder = replace(found, gap_before=replace(found.gap_before, fit=9.0))  # in the noise as stated
    assert found.added
    assert not found.scatter
    assert "The gap: " in diagnosis_verdict(found).text
    assert diagnosis_verdict(louder).text == diagnosis_verdict(found).text


def test_a_name_with_lower_odds_than_an_unmodelled_torque_is_retracted():
    pulses = last(records(3, hooks=[Pulsing()], values=[np.array([CLEAR_PULSES])]), effects=STEADY)
    assert pulses.verdict == "unexplained"
    assert [each.key for each in pulses.retracted] == ["body_torque:platform"]
    assert not pulses.added
    assert "comes in a pulse every" in diagnosis_verdict(pulses).text
    assert (
        "Retracted, as an unmodelled torque has higher posterior odds: body_torque (platform)"
        in diagnosis_verdict(pulses).text
    )
    torque = np.array([1e-4, 2e-4, -1e-4])
    steady = last(records(3, hooks=[STEADY["body_torque"].hooks("platform")], values=[torque]), effects=STEADY)
    assert [step.placed.key for step in steady.steps] == ["body_torque:platform"]


def test_a_name_that_was_shown_and_is_out_again_is_said_to_be_unless_it_was_retracted():
    """Of one that the noise takes the place of, as where what was added does not stand out of all of the residual."""
    drag = EFFECTS["viscous_drag"]
    named = last(records(3, hooks=[drag.hooks("platform")], values=[np.full(3, 2e-3)]))
    (step,) = named.steps
    shown = replace(named, complete=False)
    for bare, gone in (
        (replace(named, steps=()), (step.placed,)),
        (replace(named, steps=(), retracted=(step.placed,)), ()),
        (named, ()),
    ):
        *_, final = _with_given_up([shown, bare])
        assert final.given_up == gone
        assert any("out again" in words for words in model_notices(final)) == bool(gone)


def test_a_name_with_about_the_odds_of_an_unmodelled_torque_stands_beside_it():
    """Weak pulses are nearly a constant torque: neither is four times as probable as the other."""
    pulses = last(records(3, hooks=[Pulsing()], values=[np.array([CLEAR_PULSES / 2.0])]), effects=STEADY)
    assert pulses.verdict == "ambiguous"
    assert [each.key for each in pulses.added] == ["body_torque:platform"]
    alike = "cannot distinguish body_torque (platform) from a torque that no effect of the library gives"
    assert alike in diagnosis_verdict(pulses).text


def test_held_out_runs_that_are_missed_without_a_reason_to_name_anything_are_explained():
    quiet = last(records(2))
    assert "too uncertain" not in diagnosis_verdict(quiet).text
    missed = replace(quiet, gap=replace(quiet.gap, fit=0.96, heldout=4.7))  # as runs of half a second leave it
    assert "too uncertain to predict those held out" in diagnosis_verdict(missed).text


def test_effects_on_the_noise_are_as_much_in_question_as_others_where_nothing_is_found():
    quiet = last(records(3))
    assert not quiet.added
    answer = content(quiet)
    assert quiet.noise_candidates[0].key in answer["probabilities"]
    assert sum(answer["probabilities"].values()) == pytest.approx(1.0)
    best = quiet.noise_candidates[0]
    odds = np.log(answer["probabilities"][best.key] / answer["probabilities"]["none"])
    assert odds == pytest.approx(
        0.5 * best.log_bayes_factor - np.log(SETTINGS.null_prior_odds * quiet.remaining.tested)
    )


def test_effects_on_the_noise_are_ranked_with_the_others():
    quiet = last(records(3))
    rows = list(ranking_rows(quiet.remaining, on_the_noise(quiet)))
    both = sorted([*quiet.remaining.candidates, *quiet.noise_candidates], key=lambda each: -each.log_bayes_factor)
    assert [row[:2] for row in rows] == [(each.effect.id, each.component) for each in both[:8]]
    assert {f"{row[0]}:{row[1]}" for row in rows} == set(quiet.probabilities) - {NONE, UNKNOWN}


def test_noise_stands_behind_what_is_missing_and_is_known_only_as_well_as_the_samples_tell_it():
    late = [EFFECTS["gyro_latency"].hooks("gyro")]
    noisy = records(4, hooks=late, values=[np.array([2e-2])], noise=1.4 * NOISE)
    understated = [replace(each, details=replace(each.details, gyro_noise=NOISE)) for each in noisy]
    found = last(understated)
    answer = content(found)
    delay, noise = answer["steps"]
    assert (delay["effect"], noise["effect"]) == ("gyro_latency", "gyro_noise")
    assert noise["gap_before"] == delay["gap_after"]
    assert noise["gap_after"] == answer["gap"]["after"]
    assert "gyro_latency:gyro" in next(iter(answer["probabilities"]))
    assert found.runs.noise_freedom <= found.scatter[0].finding.noise_freedom < found.runs.samples


def test_a_further_effect_that_is_indistinguishable_from_another_is_ambiguous():
    late = last(records(4, hooks=[EFFECTS["gyro_latency"].hooks("gyro")], values=[np.array([2e-2])]))
    (sure,) = late.steps
    best, other = sure.screening.candidates
    both = (best, replace(other, log_bayes_factor=best.log_bayes_factor))
    further = replace(sure, screening=replace(sure.screening, candidates=both))
    ambiguous = replace(late, steps=(sure, further))
    assert (late.verdict, ambiguous.verdict) == ("named", "ambiguous")
    text = "cannot distinguish gyro_latency (gyro) from viscous_drag (platform). Also missing: gyro_latency (gyro)."
    assert text in diagnosis_verdict(ambiguous).text


def test_an_effect_on_the_noise_that_is_indistinguishable_from_another_is_ambiguous():
    noisy = replace(last(records(3)), scatter=())
    one, other, *_ = noisy.noise_candidates
    ambiguous = replace(noisy, scatter=(replace(one, look_alikes=(other,)),))
    answer = content(ambiguous)
    assert answer["verdict"] == "ambiguous"
    assert answer["steps"][0]["indistinguishable_from"] == [{"effect": other.effect.id, "component": other.component}]
    assert "cannot distinguish" in diagnosis_verdict(ambiguous).text


def test_another_inertia_stands_as_a_step_and_names_nothing():
    answer = content(last(records(3), inertia_factor=1.02))
    assert answer["verdict"] == "none"
    (step,) = answer["steps"]
    assert step["effect"] == "inertia"
    change = step["parameters"]["dJ33_kg_m2"]
    true_change = -0.02 * theta_of(nominal()[1].inertia)[2]
    assert abs(change["value"] - true_change) < 4.0 * change["std"]  # by chance once in 16,000; the seed is fixed
    assert step["gap_before"] > 1.2 > step["gap_after"]  # noise: 1 within 4 %


def test_understated_noise_is_a_step():
    stated = [replace(r, details=replace(r.details, gyro_noise=NOISE / 1.5)) for r in records(3)]
    answer = content(last(stated))
    (step,) = answer["steps"]
    assert step["effect"] == "gyro_noise"
    extra = step["parameters"]["extra_noise_rad_s"]
    assert extra["value"] == pytest.approx(NOISE * np.sqrt(1.0 - 1.5**-2), abs=4.0 * extra["std"])
    assert step["gap_after"] < 1.2 < step["gap_before"]  # 1 and 1.5, each within 4 %


def test_the_extended_model_has_the_noise_that_was_found():
    stated = [replace(r, details=replace(r.details, gyro_noise=NOISE / 1.5)) for r in records(3)]
    found = last(stated)
    (extension,) = extensions_of(nominal()[0], found)
    extra = found.scatter[0].finding.values[0]
    assert extension.scenario["gyro"]["extra_noise_rad_s"] == pytest.approx([extra] * 3)


def test_a_torque_without_a_name_is_unexplained_and_drawn(pulsing, tmp_path):
    answer = content(pulsing)
    assert answer["verdict"] == "unexplained"
    assert answer["latent_torque"]["p_value"] < 1e-3
    page = tmp_path / "report.html"
    places = located(pulsing.runs, pulsing.baseline)
    write_diagnosis_page(page, pulsing, places, residuals_of(pulsing), (), None, {"scenario": "diagnose"}, answer)
    text = page.read_text(encoding="utf-8")
    assert "run1: unmodelled torque, body axes" in text
    assert "An unmodelled torque stands out of the noise" in text


def test_a_hum_is_named_as_a_formula_with_its_frequency():
    diagnosis = last(records(3, hooks=[Humming(0.9)], values=[np.array([4e-4])]))
    answer = content(diagnosis)
    (step,) = (each for each in answer["steps"] if each["effect"] == "formula")
    assert answer["verdict"] == "named"
    assert step["component"] == "sin(2*pi*f*t) + cos(2*pi*f*t) in B"
    frequency = step["parameters"]["frequency_hz"]
    assert abs(frequency["value"] - 0.9) < 3.0 * frequency["std"] < 0.03


def test_the_share_of_a_torque_that_the_names_explain_is_reported():
    dragged = last(records(3, hooks=[FEW["viscous_drag"].hooks("platform")], values=[np.full(3, 4e-3)]))
    assert [step.key for step in dragged.steps] == ["viscous_drag:platform"]
    assert 0.95 < dragged.torque_explained <= 1.0
    nothing = replace(dragged.latent_before, likelihood_ratio=0.0)  # it stands out in other noise alone
    assert replace(dragged, latent_before=nothing).torque_explained is None
    assert share_words(dragged).startswith("The effects explain ")
    half = replace(
        dragged, latent=replace(dragged.latent, likelihood_ratio=0.5 * dragged.latent_before.likelihood_ratio)
    )
    assert "explain 50 %" in share_words(half)
    assert share_words(last(records(3))) == ""


def test_sizes_and_residuals_belong_together(pulsing):
    sizes = {size.placed.key: size for size in detectable_sizes(pulsing)}
    assert sizes["gyro_latency:gyro"].smallest[0].value == pytest.approx(0.01 * sizes["gyro_latency:gyro"].multiple)
    for run in residuals_of(pulsing):
        np.testing.assert_allclose(run.measured - run.nominal, NOISE * run.before, atol=1e-15)
        assert run.held_out == (run.name == "run3")


def test_the_spectrum_of_white_noise_is_one_and_a_tone_stands_at_its_frequency():
    time = np.cumsum(np.random.default_rng(3).uniform(0.05, 0.07, 4000))
    noise = np.random.default_rng(4).normal(size=(4000, 3))
    frequency, power = mean_spectrum([time], [noise])
    assert power.mean() == pytest.approx(1.0, abs=0.15)  # 600 exponentials: 4 % each, so 3.7 sigma
    tone = np.sin(2.0 * np.pi * frequency[50] * time)
    _, power = mean_spectrum([time], [np.column_stack([tone] * 3)])
    assert int(power[:, 0].argmax()) == 50


def test_residuals_are_drawn_once_where_nothing_was_added():
    quiet = last(records(2))
    figures = [block.title for block in residuals_section(residuals_of(quiet)).blocks if isinstance(block, Figure)]
    assert figures == ["Spectrum over all runs: nominal"]


def test_a_class_names_each_effect_once_with_all_its_places():
    members = [("actuator_weak", "2"), ("body_torque", "platform"), ("actuator_weak", "5"), ("actuator_weak", "1")]
    placed = [SimpleNamespace(effect=EFFECTS[effect], component=component) for effect, component in members]
    assert names_of_all(placed) == ["actuator_weak (2, 5 and 1)", "body_torque (platform)"]
