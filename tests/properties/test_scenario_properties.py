"""Properties of the scenario reader: divisible clocks, physical inertia, and no typo that passes."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError
from scipy.spatial.transform import Rotation

from testbed.errors import InputError
from testbed.scenario.clocks import nearest_steps, rate_conflicts, step_conflicts
from testbed.scenario.reader import read_scenario
from testbed.scenario.values import Inertia

SHIPPED = Path(__file__).parents[2] / "scenarios"
TEXT = (SHIPPED / "zero_g.toml").read_text(encoding="utf-8")
KEYS = [
    (section, key)
    for section, table in tomllib.loads(TEXT).items()
    if isinstance(table, dict)
    for key, value in table.items()
    if not isinstance(value, dict)
]
INERTIA = TypeAdapter(Inertia)
moments = st.floats(1e-4, 1.0)
turns = st.lists(st.floats(-math.pi, math.pi), min_size=3, max_size=3)
rates = st.sampled_from([1.0, 3.0, 8.0, 12.5, 16.0, 30.0, 60.0, 80.0, 100.0])


def turned(principal, turn):
    """An inertia with these principal moments, symmetric to the last bit as a file would have it."""
    rotation = Rotation.from_rotvec(turn).as_matrix()
    inertia = rotation @ np.diag(principal) @ rotation.T
    return ((inertia + inertia.T) / 2).tolist()


@given(rate=rates, faster=st.integers(1, 12), steps=st.integers(1, 400))
def test_a_step_made_to_divide_is_accepted(rate, faster, steps):
    clocks = {"slow": rate, "fast": rate * faster}
    assert not list(rate_conflicts(clocks))
    assert not list(step_conflicts(1.0 / (rate * faster * steps), clocks))


@given(step=st.floats(1e-5, 1.0), slow=rates, fast=rates)
def test_the_steps_proposed_divide_and_enclose_the_one_refused(step, slow, fast):
    clocks = {"slow": slow, "fast": fast}
    proposed = nearest_steps(step, clocks)
    assert all(not list(step_conflicts(choice, clocks)) for choice in proposed)
    assert min(proposed) < step
    assert len(proposed) == 1 or max(proposed) > step


@given(one=moments, two=moments, share=st.floats(0.0, 1.0), turn=turns)
def test_any_attitude_of_a_physical_inertia_is_accepted(one, two, share, turn):
    largest = abs(one - two) + share * (one + two - abs(one - two))
    INERTIA.validate_python(turned((one, two, max(largest, 1e-5)), turn))


@given(one=moments, two=moments, excess=st.floats(1.001, 10.0), turn=turns)
def test_a_moment_above_the_sum_of_the_others_is_refused_in_any_attitude(one, two, excess, turn):
    with pytest.raises(ValidationError, match="belongs to no body"):
        INERTIA.validate_python(turned((one, two, (one + two) * excess), turn))


@pytest.mark.parametrize(("section", "key"), KEYS, ids=[f"{section}.{key}" for section, key in KEYS])
@settings(max_examples=3)
@given(data=st.data())
def test_no_typo_passes_and_the_key_meant_is_named(tmp_path_factory, section, key, data):
    """One doubled letter anywhere in any key."""
    position = data.draw(st.integers(0, len(key) - 1))
    typo = key[:position] + key[position] + key[position:]
    head, _, body = TEXT.partition(f"[{section}]")
    text = f"{head}[{section}]{body.replace(f'{key} =', f'{typo} =', 1)}"
    path = tmp_path_factory.mktemp("typo") / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    rows = text.splitlines()
    line = 1 + next(number for number, row in enumerate(rows) if row.startswith(f"{typo} ="))
    message = f"line {line}, {section}.{typo}: unknown key; did you mean {key}\\?"
    with pytest.raises(InputError, match=message):
        read_scenario(path)
