"""The pure parts of the benchmark of formulas: which set hides what, what is right to say of it, and the page."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from benchmarks.formula_baselines import is_term, operon_said, sindy_said, write_set
from benchmarks.formula_sets import NO_LAW, HiddenFormula, Said, formula_of, judged, placed_formulas, wanted
from benchmarks.formulas_page import page, rows_of
from concealing.formula_effects import LAWS, drawn_law
from support.diagnosed_records import nominal, records
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.formulas.pattern import pattern_of
from testbed.prediction.formula_hooks import formula_hooks

PRODUCT, SIZE = "w_x*w_y about z", 4e-3
"""N·m·s²/rad²."""


def test_families_and_sizes_come_in_turns_and_one_set_of_five_hides_nothing():
    every = Counter(wanted(number) for number in range(1, 36))
    assert every[NO_LAW, 0.0] == 7
    assert all(every[law, sigma] == 2 for law in LAWS for sigma in (8.0, 16.0))


def test_a_hidden_law_is_written_in_the_grammar_with_the_values_that_are_estimated():
    rng = np.random.default_rng(1)
    text, values = formula_of(drawn_law(rng, "wave", "y"))
    assert str(text) == "sin(2*pi*f*t) + cos(2*pi*f*t) about y"
    assert 0.6 < values[0] < 3.5
    assert np.hypot(*values[1:]) == pytest.approx(2e-4)
    text, values = formula_of(drawn_law(rng, "attitude", "N"))
    assert (text.placement, len(values)) == ("N", 3)


@pytest.mark.parametrize(
    ("named", "alike", "right"),
    [
        (("formula:w_x*w_y about z",), (), (True, True, True)),
        (("formula:w_x*w_y in B",), (), (True, False, True)),
        (("formula:w_x about z",), ("w_x*w_y about z",), (True, False, False)),
        (("body_torque:platform",), ("w_x*w_y about z",), (True, False, False)),
        (("formula:w_x*w_y in N",), (), (False, False, True)),
        (("formula:t about z", "formula:w_x*w_y about z"), (), (False, False, False)),
        ((), (), (False, False, False)),
    ],
)
def test_the_judge_knows_the_formula_its_class_and_its_driver(named, alike, right):
    hidden = HiddenFormula(family="two_rates", sigma=8.0, formula=PRODUCT, values=(1e-3,))
    found = judged(Said(named=named, alike=alike), hidden)
    assert (found.in_class, found.exact, found.driver) == right


def test_terms_of_a_regression_make_formulas_by_their_axes():
    weights = {("t", "x"): 1.0, ("t", "y"): 0.5, ("w_x", "z"): 2.0, ("t", "Nx"): 0.1}
    assert placed_formulas(weights) == ["w_x about z", "t in B", "t in N"]
    said = sindy_said({"sin(2*pi*f*t) @ x": 0.2, "cos(2*pi*f*t) @ x": 0.4, "t @ y": 0.5})
    assert said.named == ("formula:sin(2*pi*f*t) + cos(2*pi*f*t) about x",)
    assert said.alike == ("t about y",)
    assert is_term(pattern_of("t in N"), "t", "Nz")
    assert not is_term(pattern_of("t about x"), "t", "y")


def kept(number, named, sigma=8.0, **others):
    hidden = {"family": "two_rates", "sigma": sigma, "shown": sigma, "formula": PRODUCT, "values": [1e-3]}
    if not sigma:
        hidden |= {"family": NO_LAW, "formula": "", "values": []}
    said = {"testbed": {"named": named, "alike": []}, **others}
    spent = {"seconds": 2.0 * number, "without_formulas": float(number)}
    return {"hidden": hidden, "said": said, "heldout": [1.2, 1.0], "covered": [True] * len(named)} | spent


def test_the_page_has_every_method_by_size_and_family_and_the_sets_without_an_effect():
    other = {"sindy": {"named": [], "alike": []}}
    sets = [
        kept(1, [f"formula:{PRODUCT}"], **other),
        kept(2, []),
        kept(3, ["formula:t about x"], 0.0),
        kept(4, [], 0.0),
    ]
    rows = rows_of(sets)
    ours = next(each for each in rows["sizes"] if (each["what"], each["method"]) == ("in_class", "testbed"))
    assert (ours["hits"], ours["of"], ours["wanted"]) == (1, 2, "≥ 85 %")
    assert ours["low"] == pytest.approx(0.0126, abs=1e-4)  # Clopper and Pearson, 1 of 2
    text = page({"seed": 1, "sets": 4, "where": "here", **rows})
    assert "| two_rates at 8 σ | 1 of 2 | 1 of 2 | 0 of 1 | 0 of 1 | - | - |" in text
    assert "| without an effect, testbed names something | 50% | 2 |" in text
    assert "| processor time with formulas over that without, sets with an effect | 2 | 2 | 2 | ≤ 2 |" in text


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """Return the file of what the other methods see of runs with a product of rates."""
    path = tmp_path_factory.mktemp("seen") / "set_0001.npz"
    hooks = [formula_hooks(pattern_of(PRODUCT))]
    data = data_set_of(records(3, seconds=3.0, hooks=hooks, values=[np.array([SIZE])], seed=3), *nominal())
    write_set(path, data.runs, fitted(data.runs, [], theta_of(nominal()[1].inertia), []))
    return path


def test_a_regressor_is_what_a_unit_torque_by_its_law_does_to_the_gyro(seen):
    with np.load(seen) as kept:
        column = list(kept["terms"]).index("w_x*w_y @ z")
        own = np.concatenate([kept[f"columns_{run}"][..., column].ravel() for run in range(2)])
        left = np.concatenate([kept[f"residual_{run}"].ravel() for run in range(2)])
        assert own @ left / (own @ own) == pytest.approx(SIZE, rel=0.1)
        assert kept["features"].shape == (len(kept["torque"]), len(kept["names"]))


def test_an_expression_has_the_name_of_the_formula_that_explains_it(seen):
    with np.load(seen) as kept:
        torque = kept["unit_torques"][..., list(kept["terms"]).index("w_x*w_y @ z")]
    assert operon_said(seen, torque).named == (f"formula:{PRODUCT}",)
    assert operon_said(seen, np.zeros_like(torque)) == Said()
