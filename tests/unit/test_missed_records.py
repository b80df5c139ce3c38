"""A touch in a record that is held out, beside a drag in all: the record is fitted after all."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import testbed as tb
from support.diagnosed_records import nominal, records
from support.few_effects import know_only
from testbed.diagnosis.model import Hypothesis
from testbed.effects.contact import Contact
from testbed.effects.registry import EFFECTS
from testbed.library import prepared_records

DRAG = Hypothesis(effect=EFFECTS["viscous_drag"], component="platform")
TOUCH = Hypothesis(effect=Contact(), component="platform")
COEFFICIENT, INSTANT, IMPULSE = np.full(3, 6e-3), 7.1, np.array([3e-4, -2e-4, 2e-4])
HELD_OUT = "run2"


def flown():
    hooks, values = [DRAG.hooks, TOUCH.hooks], [COEFFICIENT, np.array([INSTANT, *IMPULSE])]
    return records(5, hooks=hooks, values=values, noise=4e-4, seed=25)


def stages_of(monkeypatch, used):
    know_only(monkeypatch, "viscous_drag", "contact")
    monkeypatch.setattr(prepared_records, "NOISE_EFFECTS", {})
    made = prepared_records.prepared_records(nominal()[0], tb.Records(tuple(used)))
    return list(made.stages())


def test_a_touched_record_that_was_held_out_is_fitted_and_both_effects_are_named(monkeypatch):
    states = stages_of(monkeypatch, flown())
    first, last = states[0], states[-1]
    assert HELD_OUT in first.heldout.record_names
    assert HELD_OUT in last.runs.record_names
    assert sum(each.complete for each in states) == 1
    assert any(later.begins_again(before) for before, later in pairwise(states))
    assert {step.key for step in last.steps} == {"viscous_drag:platform", "contact:platform"}
    assert last.verdict == "named"
    np.testing.assert_allclose(last.model.effect_values[last.model.own(TOUCH)][1:], IMPULSE, atol=2e-5)
