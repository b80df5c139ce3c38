"""A touch shows in one run; what most runs show is none."""

from __future__ import annotations

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.candidates import accepted
from testbed.diagnosis.fitting import nominal_fit
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.screening import screened
from testbed.diagnosis.touches import without_common_touch
from testbed.dynamics.inertia import theta_of
from testbed.effects.contact import Contact
from testbed.effects.registry import EFFECTS

TOUCH = Hypothesis(effect=Contact(), component="platform")
TORQUE = Hypothesis(effect=EFFECTS["body_torque"], component="platform")


@pytest.mark.parametrize(
    ("hidden", "values", "kept"),
    [
        (TOUCH, [1.5, 4e-4, -3e-4, 5e-4], True),
        (TOUCH, [6.8, 4e-4, -3e-4, 5e-4], True),
        (TORQUE, [2e-4, -1e-4, 2e-4], False),
    ],
    ids=["a touch", "a touch in the second run", "a constant torque"],
)
def test_what_explains_as_much_in_most_runs_is_no_touch(hidden, values, kept):
    scenario, platform = nominal()
    used = records(5, hooks=[hidden.hooks], values=[np.array(values)], noise=4e-4, seed=25)
    data = data_set_of(used, scenario, platform)
    fit = nominal_fit(data.runs, theta_of(platform.inertia))
    screening = screened(data.runs, data.heldout, fit, [TOUCH])
    assert accepted(screening) is not None
    assert (accepted(without_common_touch(data.runs, fit, screening)) is not None) == kept


def test_touches_in_two_runs_are_both_named():
    """The second was never found: what was left had the names of a constant torque and of a noisier gyro."""
    scenario, platform = nominal()
    first, second = np.array([1.5, 4e-4, -3e-4, 5e-4]), np.array([12.1, -3e-4, 5e-4, 2e-4])
    used = records(5, hooks=[TOUCH.hooks, TOUCH.hooks], values=[first, second], noise=4e-4, seed=25)
    data = data_set_of(used, scenario, platform)
    effects = {each: EFFECTS[each] for each in ("contact", "body_torque")}
    *_, found = diagnosed(data.runs, data.heldout, effects, theta_of(platform.inertia))
    assert {step.key for step in found.steps} == {"contact:platform", "contact:platform, 2"}
    assert found.verdict == "named"
    said = " ".join(model_notices(found))
    assert "on the clock of run1" in said
    assert "on the clock of run3" in said
    sizes = np.array([value[0, 1:] for value in found.model.values.effects])
    np.testing.assert_allclose(sizes[np.argsort(-sizes[:, 0])], [first[1:], second[1:]], atol=2e-5)
