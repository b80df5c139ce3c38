"""What no effect of the library explains: formulas are searched, named with their size, flown and kept."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from support.flown_effects import flown, scenario
from support.processes import ROOT
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.formulas import screened_formulas
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects import contact
from testbed.effects.formula import Formula, flown_entries
from testbed.effects.library import FOLDER_VARIABLE, kept_effects
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.errors import InputError
from testbed.formulas.grammar import classes, is_listed, patterns, shares
from testbed.formulas.pattern import pattern_of
from testbed.library.own_effects import save_effect
from testbed.prediction.formula_hooks import formula_hooks

FEW = {name: EFFECTS[name] for name in ("viscous_drag", "body_torque")}
PRODUCT, SIZE = "w_x*w_y about z", 4e-3
"""N·m·s²/rad²: 15 sigma in four runs."""


def data_of(text=None, values=(), count=5, seed=3):
    hooks = [] if text is None else [formula_hooks(pattern_of(text))]
    sizes = [] if text is None else [np.array(values)]
    return data_set_of(records(count, seconds=5.0, hooks=hooks, values=sizes, seed=seed), *nominal())


def last_of(data, effects=FEW):
    said = []
    found = diagnosed(
        data.runs,
        data.heldout,
        effects,
        theta_of(nominal()[1].inertia),
        said.append,
        {name: NOISE_EFFECTS[name] for name in ("gyro_noise",)},
    )
    return list(found)[-1], said


@pytest.fixture(scope="module")
def product():
    return last_of(data_of(PRODUCT, [SIZE]))[0]


def test_an_unmodelled_product_of_rates_is_named_with_its_size(product):
    (step,) = product.steps
    assert (product.verdict, step.key) == ("named", f"formula:{PRODUCT}")
    value, std = product.model.effect_values[0], float(np.sqrt(product.model.covariance[6, 6]))
    assert abs(value - SIZE) < 3.0 * std < 0.3 * SIZE
    assert product.gap.heldout < 1.05 < product.gap_before.heldout + 0.05
    assert (
        product.probabilities[step.key] > 0.5
    )  # of two effects in the library; kinds of torque that nobody listed have the rest


def test_the_page_says_it_as_physics(product):
    (step,) = product.steps
    effect = step.effect
    said = effect.measured(step.component, effect.quantities(np.array([1.312e-3]), np.array([8.1e-5])))
    assert said.startswith(
        "A torque about z of (1.312 ± 0.081)e-3 N·m·s²/rad² times ω_x ω_y. Known to have this form: "
    )
    assert "inertia or alignment error" in said


def test_no_formula_is_searched_where_nothing_is_left():
    state, said = last_of(data_of(seed=5))
    assert state.verdict == "none"
    assert "formulas" not in said


def test_an_effect_of_the_library_keeps_its_name():
    data = data_set_of(
        records(
            5, seconds=5.0, hooks=[EFFECTS["viscous_drag"].hooks("platform")], values=[np.array([4e-4, 3e-4, 2e-4])]
        ),
        *nominal(),
    )
    state, _ = last_of(data)
    assert [step.key for step in state.steps] == ["viscous_drag:platform"]


@pytest.mark.parametrize(
    ("size", "named", "rivals"),
    [(1e-5, "formula:t in N", False), (2e-6, "inertial_torque:platform", True)],
)
def test_a_ramp_fixed_in_space_takes_the_place_of_a_constant_torque_where_the_two_differ(size, named, rivals):
    """Beside free initial rates a constant torque leaves a sixteenth of a ramp's power."""
    data = data_of("t in N", size * np.array([1.0, -0.7, 0.5]), count=3)
    state, _ = last_of(data, {"inertial_torque": EFFECTS["inertial_torque"]})
    assert state.steps[0].key == named
    assert ("t in N" in state.rivals) == rivals
    assert any("t in N" in each for each in model_notices(state)) == rivals


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("lag(norm(w)*w_x, tau) about y", [0.4, 3e-3]),
        ("sin(2*pi*f*t) + cos(2*pi*f*t) about x", [1.3, 3e-4, -1e-4]),
        ("w_x*gimbal_rate_2 about y", [4e-4]),
        ("R_zx in B", [1e-4, -7e-5, 5e-5]),
        ("once(at, width) about y", [8.3, 0.25, 2e-4]),
    ],
)
def test_the_formula_with_the_most_evidence_is_the_one_that_acts(text, values):
    data = data_of(text, values)
    fit = fitted(data.runs, [], theta_of(nominal()[1].inertia), [])
    best = screened_formulas(data.runs, data.heldout, fit, library=60).candidates[0]
    assert best.component == text
    std = np.sqrt(np.diag(best.fit.covariance)[6:])
    assert np.all(np.abs(best.fit.effect_values - values) < 4.0 * std)


def test_a_touch_that_no_jump_shows_is_found_at_the_instant_of_a_pulse(monkeypatch):
    """Of 50 s of a CubeSat the largest jumps are drifts of the gyro's integral: the touch was called a formula."""
    monkeypatch.setattr(contact, "_of_jumps", lambda _: [1.0])
    data = data_of("once(at, width) in B", [8.3, 0.02, 4e-3, -2e-3, 1e-3])
    state, _ = last_of(data, {"contact": EFFECTS["contact"]})
    (step,) = state.steps
    assert step.key == "contact:platform"
    assert state.model.effect_values[0] == pytest.approx(8.3, abs=0.02)


def test_the_extended_scenario_flies_it(tmp_path):
    pattern = pattern_of("w_x*gimbal_rate_2 in B")
    effect, size = Formula(pattern, typical_value=np.ones(1)), np.array([4e-4, -2e-4, 1e-4])
    flight = flown([effect.extension(str(pattern), size, scenario())], tmp_path)
    left, signature = flight.residual([effect.hooks(str(pattern))], size), flight.residual([])
    assert left < 2e-6 < 0.02 * signature  # gimbal angles sampled at 160 Hz leave 3e-7, six digits of an MJCF 4e-7


def test_formulas_add_up_in_the_scenario():
    first, second = (Formula(pattern_of(text), typical_value=np.ones(1)) for text in ("t about x", "w_x about y"))
    flies = scenario().model_copy(
        update={
            "truth": scenario().truth.model_validate(
                first.extension("", np.array([1e-5]), scenario()).scenario["truth"]
            )
        }
    )
    entries = second.extension("", np.array([2e-5]), flies).scenario["truth"]["torque"]
    assert [each["formula"] for each in entries] == ["t", "w_x"]


def test_an_oscillation_is_flown_as_a_sine_and_a_cosine():
    entries = flown_entries(pattern_of("sin(2*pi*f*t) + cos(2*pi*f*t) about x"), np.array([1.5, 2e-4, -1e-4]))
    assert [(each["formula"], each["coefficient"]) for each in entries] == [
        ("sin(2*pi*1.5*t)", 2e-4),
        ("cos(2*pi*1.5*t)", -1e-4),
    ]


def test_the_prior_of_a_class_is_shared_and_falls_with_length():
    every = patterns(6)
    share = shares(every)
    for alike in every.values():
        assert sum(share[each] for each in alike) == pytest.approx(1.0)
    assert share[pattern_of("w_x*w_y about z")] == 2.0 * share[pattern_of("w_x*w_y in B")]
    assert share[pattern_of("w_x about z")] == 4.0 * share[pattern_of("lag(w_x, tau) about z")]
    assert "gimbal rate" not in classes(0)


def test_what_the_library_lists_is_no_formula_of_the_search():
    assert is_listed(pattern_of("w_x about x"))
    assert is_listed(pattern_of("abs(w_x)*w_x about x"))
    assert not is_listed(pattern_of("w_x about y"))
    assert not is_listed(pattern_of("w_x*w_x about x"))


def diagnosis_with(tmp_path, *components):
    step = {"effect": "formula", "parameters": {"coefficient_N_m_s2_rad2": {"value": -1.3e-3, "std": 1e-4, "unit": ""}}}
    content = {
        "steps": [step | {"component": each} for each in components],
        "inertia": {"after": {"theta_kg_m2": [0.02, 0.022, 0.03, 0.0, 0.0, 0.0]}},
    }
    (tmp_path / "diagnosis.json").write_text(json.dumps(content), encoding="utf-8")
    return tmp_path


def test_a_formula_is_kept_as_data_under_a_name(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "own"))
    path = save_effect(diagnosis_with(tmp_path, PRODUCT), "arm_product")
    assert path == tmp_path / "own" / "arm_product.toml"
    (effect,) = kept_effects().values()
    assert (effect.id, effect.components) == ("arm_product", ("platform",))
    assert effect.parameters[0].typical_on(0.024) == pytest.approx(1.3e-3)
    state, said = last_of(data_of(PRODUCT, [SIZE]), FEW | {effect.id: effect})
    assert [step.key for step in state.steps] == ["arm_product:platform"]
    assert "formulas" not in said


@pytest.mark.parametrize(
    ("components", "name", "number", "said"),
    [
        ((), "arm", None, "names no formula"),
        ((PRODUCT, "t about x"), "arm", None, r"choose one by its number \(--number\): 1: w_x"),
        ((PRODUCT,), "arm", 2, "has no formula 2"),
        ((PRODUCT,), "Arm!", None, "small letters"),
        ((PRODUCT,), "tether", None, "is there already"),
    ],
)
def test_what_cannot_be_kept_is_refused(components, name, number, said, tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "own"))
    with pytest.raises(InputError, match=said):
        save_effect(diagnosis_with(tmp_path, *components), name, number)


def test_a_law_is_kept_once_and_not_by_the_name_of_formulas_that_are_found(tmp_path, monkeypatch):
    """Two twins were ambiguous ever after; what was named `formula` was taken for a new one."""
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "own"))
    diagnosis = diagnosis_with(tmp_path, PRODUCT)
    with pytest.raises(InputError, match="formula: an effect of this name is there already"):
        save_effect(diagnosis, "formula")
    path = save_effect(diagnosis, "arm_product")
    with pytest.raises(InputError, match=r"the same law, w_x\*w_y about z, is kept in .*arm_product\.toml"):
        save_effect(diagnosis, "twin")
    assert list(path.parent.iterdir()) == [path]


def test_a_damaged_effect_of_the_library_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (tmp_path / "arm.toml").write_text(
        'name = "arm"\nformula = "w_q about z"\nsizes = [1.0]\nmean_inertia_kg_m2 = 1.0\n'
    )
    with pytest.raises(InputError, match=r"arm\.toml: is no effect .* did you mean w_"):
        kept_effects()


def test_a_wrong_value_of_an_effect_of_the_library_is_named_by_its_key(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (tmp_path / "arm.toml").write_text(
        'name = "arm"\nformula = "w_x about z"\nsizes = ["big"]\nmean_inertia_kg_m2 = 1.0\n'
    )
    with pytest.raises(InputError, match=r"effects save`: sizes\.0: .*; mend it or take it away$") as refused:
        kept_effects()
    assert "pydantic" not in str(refused.value)


def test_the_kept_effects_are_listed_with_law_size_origin_and_file(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "own"))
    path = save_effect(diagnosis_with(tmp_path, PRODUCT), "arm_product")
    assert exit_code_of(lambda: app(["effects", "list"])) == 0
    said = capsys.readouterr().out
    assert "arm_product: An unmodelled torque" in said
    assert f"Law        {PRODUCT}" in said
    assert "Size       0.0013 N·m·s²/rad²" in said
    assert f"From       {tmp_path / 'diagnosis.json'}" in said
    assert f"File       {path}" in said


def test_a_file_in_the_place_of_the_library_is_refused(tmp_path, monkeypatch):
    (tmp_path / "effects").write_text("", encoding="utf-8")
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "effects"))
    with pytest.raises(InputError, match=f"effects: is no folder, .* name it in {FOLDER_VARIABLE}"):
        kept_effects()


def kept_in(folder, file, name):
    path = folder / file
    path.write_text(f'name = "{name}"\nformula = "w_x*w_y about z"\nsizes = [1.0]\nmean_inertia_kg_m2 = 1.0\n')
    return path


def test_two_files_of_one_name_are_both_named(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    one, other = (kept_in(tmp_path, file, "arm_product") for file in ("arm.toml", "copy of arm.toml"))
    with pytest.raises(InputError, match=re.escape(f"{one} and {other}: both are called arm_product; change name in")):
        kept_effects()


def test_a_file_with_the_name_of_an_effect_of_the_library_is_named(tmp_path):
    path = kept_in(tmp_path, "mine.toml", "viscous_drag")
    listed = subprocess.run(
        [sys.executable, "-m", "testbed", "effects", "list"],
        env=os.environ | {FOLDER_VARIABLE: str(tmp_path)},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert listed.returncode == 2
    assert f"{path}: viscous_drag: an effect of this id is registered already" in " ".join(listed.stderr.split())
