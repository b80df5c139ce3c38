"""An effect that differs from run to run: no other is named for what its one size leaves."""

from __future__ import annotations

import numpy as np

from support.diagnosed_records import nominal, records
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.result import result_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.verdict import diagnosis_verdict

DRAG = Hypothesis(effect=EFFECTS["viscous_drag"], component="platform")
TORQUE = Hypothesis(effect=EFFECTS["body_torque"], component="platform")
COEFFICIENT = np.full(3, 2e-3)
NOISE = 4e-4
LIBRARY = {each: EFFECTS[each] for each in ("viscous_drag", "quadratic_drag", "inertial_torque", "body_torque")}


def diagnosis_of(used, **further):
    scenario, platform = nominal()
    data = data_set_of(used, scenario, platform)
    *_, last = diagnosed(data.runs, data.heldout, LIBRARY | further, theta_of(platform.inertia))
    return last


def flown(factors, seed, hooks=(), values=()):
    """Runs of one platform with a drag of another size in each."""
    flights = {
        factor: records(
            len(factors), hooks=[DRAG.hooks, *hooks], values=[factor * COEFFICIENT, *values], noise=NOISE, seed=seed
        )
        for factor in set(factors)
    }
    return [flights[factor][run] for run, factor in enumerate(factors)]


def test_a_drag_that_differs_by_a_fifth_gets_no_further_name():
    found = diagnosis_of(flown([1.0, 1.2, 0.85, 0.9, 1.15], 21), contact=EFFECTS["contact"])
    assert [step.key for step in found.steps] == ["viscous_drag:platform"]
    assert found.differing.placed.key == "viscous_drag:platform"
    assert "That viscous_drag (platform) differs from run to run" in diagnosis_verdict(found).text
    assert found.verdict == "unexplained"
    said = result_of(found, [], [])["differs"]
    assert (said["effect"], said["component"], said["as_healthy"]) == ("viscous_drag", "platform", False)
    assert said["record"] in {"run2", "run3", "run5"}  # 20 and 15 % off


def test_a_second_effect_that_is_there_is_named_beside_a_drag_of_one_size():
    torque = np.array([4e-5, -3e-5, 5e-5])
    found = diagnosis_of(flown([1.0] * 5, 23, [TORQUE.hooks], [torque]))
    assert {step.key for step in found.steps} == {"viscous_drag:platform", "body_torque:platform"}
    assert found.differing is None
    own = found.model.own(TORQUE)
    error = (found.model.effect_values[own] - torque) / np.sqrt(np.diag(found.model.covariance)[6:][own])
    assert np.abs(error).max() < 3.5
