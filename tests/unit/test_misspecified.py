"""How null sets that are not as stated are made and scored."""

from __future__ import annotations

import json

from benchmarks.misspecified import KINDS, case_of, page, row_of
from testbed.scoring.case import read_cases

THETA = [4e-2] * 3 + [0.0] * 3
ANSWER = {
    "schema": 1,
    "stratum": "null",
    "effects": [],
    "notes": {},
    "true_theta_kg_m2": THETA,
    "initial_rates_rad_s": [[0.1, 0.0, 0.0]],
}


def step(effect, *others):
    return {
        "effect": effect,
        "component": "gyro",
        "probability": 0.9,
        "parameters": {},
        "indistinguishable_from": [{"effect": other, "component": "gyro"} for other in others],
        "j_theta_kg_m2": THETA,
        "j_std_kg_m2": [1e-4] * 6,
    }


def said(*steps, verdict="named"):
    return {
        "schema": 1,
        "complete": True,
        "verdict": verdict,
        "steps": list(steps),
        "gap": {"heldout_after": 1.0},
        "probabilities": {},
    }


def scored(folder, *diagnoses):
    for number, diagnosis in enumerate(diagnoses, start=1):
        for place, content in (("answers", ANSWER), ("diagnoses", diagnosis)):
            path = folder / place / f"case_{number:04d}" / f"{'answer' if place == 'answers' else 'diagnosis'}.json"
            path.parent.mkdir(parents=True)
            path.write_text(json.dumps(content), encoding="utf-8")
    return read_cases(folder / "diagnoses", folder / "answers")


def test_every_kind_has_the_same_flights():
    plain, colored = (case_of(KINDS[name], 3, 1) for name in ("none", "ar+30"))
    assert plain.runs == colored.runs
    assert plain.seed == colored.seed
    assert colored.instruments.noise_correlation == 0.3
    assert case_of(KINDS["none"], 3, 1) == plain


def test_a_name_is_right_if_its_class_has_what_was_done(tmp_path):
    cases = scored(
        tmp_path,
        said(verdict="none"),
        said(step("gyro_noise_color")),
        said(step("gyro_noise", "gyro_noise_color")),
        said(step("gyro_noise_color"), step("slosh")),
        said(verdict="unexplained"),
    )
    row = row_of("ar+30", cases, seed=3)
    assert (row.sets, row.silent, row.right, row.wrong, row.unexplained, row.failed) == (5, 1, 2, 1, 1, 0)
    assert row.names == ("slosh:gyro",)
    assert not row.kept
    assert "`slosh:gyro`" in page([row])


def test_a_set_without_a_diagnosis_is_failed(tmp_path):
    cases = scored(tmp_path, said(verdict="none"), {})
    assert row_of("none", cases, seed=3).failed == 1
    assert not row_of("none", cases, seed=3).kept


def test_without_a_change_any_name_is_wrong(tmp_path):
    row = row_of("none", scored(tmp_path, said(step("gyro_noise_color"))), seed=3)
    assert (row.wrong, row.right) == (1, 0)
