"""Whether runs agree on the size of an effect: as often as chance has it where they do, and not where they do not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import kstest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.run_agreement import agreements
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS

TORQUE = Hypothesis(effect=EFFECTS["body_torque"], component="platform")
SIZE = np.array([6e-5, -4e-5, 3e-5])


def agreement(used):
    scenario, platform = nominal()
    data = data_set_of(used, scenario, platform)
    model = fitted(data.runs, [TORQUE], theta_of(platform.inertia), [np.zeros(3)])
    steps = (SimpleNamespace(placed=TORQUE),)
    (found,) = agreements(SimpleNamespace(runs=data.runs, heldout=data.heldout, model=model, steps=steps))
    return found


@pytest.fixture(scope="module")
def alike():
    """The same torque in all of four runs, thirty times."""
    return [agreement(records(4, hooks=[TORQUE.hooks], values=[SIZE], seed=seed)) for seed in range(30)]


def test_runs_with_one_size_differ_as_often_as_chance_has_it(alike):
    assert kstest([each.p_value for each in alike], "uniform").pvalue > 0.01


def test_every_run_shows_the_size_within_its_interval(alike):
    missed = np.concatenate([(each.values - SIZE) / each.std for each in alike])
    assert np.isfinite(missed).all()
    assert 0.92 < np.mean(np.abs(missed) < 1.96) < 0.98  # 360 numbers


def test_runs_are_named_and_the_held_out_ones_are_among_them(alike):
    assert sorted(alike[0].runs) == ["run1", "run2", "run3", "run4"]
    assert alike[0].heldout.sum() == 1


def test_a_torque_that_changes_from_run_to_run_is_detected():
    one, other = (records(4, hooks=[TORQUE.hooks], values=[size]) for size in (SIZE, 2.0 * SIZE))
    found = agreement([one[0], other[1], one[2], other[3]])
    assert found.disagrees
    assert found.p_value < 1e-6
