"""Numbers that decide something are explained where they stand: what they mean, and where they come from.

The modules are parsed, not imported: in the rooms of the diagnosis every constant of a module is followed by a text,
every field of `DiagnosisSettings` by its meaning and its source, and no threshold stands bare in a comparison.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, fields
from pathlib import Path

import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.settings import SETTINGS, DiagnosisSettings
from testbed.effects import registered
from testbed.effects.contract import Parameter
from testbed.library.prepared_records import origin_of
from testbed.library.records import Records

PACKAGE = Path(__file__).resolve().parents[2] / "testbed"
ROOMS = ("diagnosis", "prediction", "next_experiment", "effects")
MODULES = [path for room in ROOMS for path in sorted((PACKAGE / room).glob("*.py"))]
SHORTEST = 20
"""Characters without which a text says nothing that the name does not say."""
PLAIN = {0.0, 0.5, 1.0, 2.0}
"""Numbers that may stand bare in a comparison: nothing, half, unity and two, of either sign."""
KINDS = ("convention", "formula", "chosen", "calibrated", "measured")
"""What a source is, where it is no reference with its year."""


def numbers_in(node: ast.AST) -> list[float]:
    """Return the numbers that are written in an expression; True and False are none."""
    return [
        float(each.value)
        for each in ast.walk(node)
        if isinstance(each, ast.Constant) and isinstance(each.value, int | float) and not isinstance(each.value, bool)
    ]


def text_after(body: list[ast.stmt], index: int) -> str:
    """Return the text directly below a statement; empty where there is none."""
    following = body[index + 1] if index + 1 < len(body) else None
    if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
        return following.value.value if isinstance(following.value.value, str) else ""
    return ""


def assigned(body: list[ast.stmt]) -> Iterator[tuple[str, ast.expr, str]]:
    """Yield name, value and text of every assignment of a module or of a class."""
    for index, statement in enumerate(body):
        if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None:
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            names = [each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]
            yield from ((name, statement.value, text_after(body, index)) for name in names)


def says_nothing(name: str, text: str) -> bool:
    """Return whether a text is too short, or made of the words of the name alone."""
    words = set(re.findall(r"\w+", text.lower()))
    return len(text) < SHORTEST or words <= set(name.lower().split("_"))


def unexplained(source: str) -> list[str]:
    """Return the constants of a module that hold numbers and are not explained."""
    constants = [each for each in assigned(ast.parse(source).body) if each[0].strip("_").isupper()]
    return [name for name, value, text in constants if numbers_in(value) and says_nothing(name, text)]


def bare_thresholds(source: str) -> list[float]:
    """Return the numbers that stand bare in comparisons, and the fractions that stand bare in functions."""
    tree = ast.parse(source)
    compared = [each for node in ast.walk(tree) if isinstance(node, ast.Compare) for each in floats_in(node)]
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.Lambda)]
    within = [each for function in functions for each in floats_in(function) if not each.is_integer()]
    return [each for each in (*compared, *within) if each not in PLAIN]


def floats_in(node: ast.AST) -> list[float]:
    """Return the floating-point numbers that are written in an expression; whole numbers count and index."""
    constants = [each.value for each in ast.walk(node) if isinstance(each, ast.Constant)]
    return [each for each in constants if isinstance(each, float)]


def settings_texts() -> dict[str, str]:
    """Return the text below every field of the settings."""
    tree = ast.parse((PACKAGE / "diagnosis" / "settings.py").read_text(encoding="utf-8"))
    (body,) = (node.body for node in tree.body if getattr(node, "name", "") == "DiagnosisSettings")
    return {name: text for name, _, text in assigned(body)}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: f"{path.parent.name}.{path.stem}")
def test_every_number_of_a_module_is_explained(path):
    assert unexplained(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("path", MODULES, ids=lambda path: f"{path.parent.name}.{path.stem}")
def test_no_threshold_stands_bare(path):
    assert bare_thresholds(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "source",
    [
        "_LIMIT = 0.01\n",
        '_LIMIT = 0.01\n"""Limit."""\n',
        '_SMALLEST_LIMIT_OF_ALL = 0.01\n"""Smallest limit of all."""\n',
        "_PAIR, _LIMIT = 3.0, 0.7\n",
        "LIMITS = (-1.0, 2.5)\n",
        '_LIMIT = np.array([1.0, 2.0])\n\n\ndef work():\n    """Say something at length of a function."""\n',
    ],
)
def test_a_number_that_is_not_explained_is_found(source):
    assert unexplained(source)


def test_a_number_that_is_explained_is_not():
    assert unexplained('_LIMIT = 0.01\n"""p-value below which the gyro is late. Convention."""\nNAME = "text"\n') == []


@pytest.mark.parametrize("source", ["def f(x):\n    return x > 3.0\n", "def f(x):\n    return 0.3 * x\n"])
def test_a_bare_threshold_is_found(source):
    assert bare_thresholds(source)


def test_every_setting_has_its_meaning_and_its_source():
    texts = settings_texts()
    assert [each.name for each in fields(DiagnosisSettings)] == [name for name, text in texts.items() if text]
    for name, text in texts.items():
        meaning, found, source = " ".join(text.split()).partition(" Source: ")
        assert found, name
        assert not says_nothing(name, meaning), name
        assert source.startswith(KINDS) or re.search(r"\([12]\d{3}\)", source), name
        assert not source.startswith("calibrated") or "seed" in source or "sets of" in source, name


def numbers_of_classes(source: str) -> list[str]:
    """Return the attributes of classes that hold numbers and are not explained; `parameters` are, by the contract."""
    bodies = [node.body for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ClassDef)]
    return [
        name
        for body in bodies
        for name, value, text in assigned(body)
        if name != "parameters" and set(floats_in(value)) - PLAIN and says_nothing(name, text)
    ]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: f"{path.parent.name}.{path.stem}")
def test_every_number_of_a_class_is_explained(path):
    assert numbers_of_classes(path.read_text(encoding="utf-8")) == []


def test_a_number_of_a_class_that_is_not_explained_is_found():
    assert numbers_of_classes("class Effect:\n    limit = 0.01\n") == ["limit"]


def test_the_contract_states_the_source_of_sizes_and_bounds():
    _, *fields_of_contract = re.split(r"\n\s+(?=\w+: )", Parameter.__doc__)
    texts = {text.partition(":")[0]: text for text in fields_of_contract}
    for name in ("typical", "lower", "upper"):
        assert "Source: " in texts[name], name


@pytest.mark.parametrize("effect", registered().values(), ids=registered())
def test_sizes_and_bounds_are_as_the_contract_states(effect):
    for parameter in effect.parameters:
        assert parameter.typical != 0.0
        assert parameter.lower <= parameter.typical <= parameter.upper
        assert parameter.lower in {0.0, -1.0, -parameter.upper} or parameter.scanned  # -1: a gain that is gone
        if parameter.name == "correlation":  # it stays below 1
            assert parameter.upper == 0.9
        elif not parameter.scanned and "share" not in parameter.name:  # a share has all of 0 to 1
            assert parameter.upper >= 16.0 * abs(parameter.typical)
        elif parameter.unit == "Hz":
            assert 1.0 / 5.0 <= parameter.lower < parameter.upper < 16.0 / 2.0


def test_settings_do_not_change():
    with pytest.raises(FrozenInstanceError):
        SETTINGS.null_prior_odds = 4.0


def test_provenance_states_every_setting():
    scenario, _ = nominal()
    stated = origin_of(scenario, Records(tuple(records(2, seconds=1.0))), "testbed diagnose").reproducible
    assert {
        f"setting_{each.name}": repr(getattr(SETTINGS, each.name)) for each in fields(SETTINGS)
    }.items() <= stated.items()
