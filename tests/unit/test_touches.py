"""A touch shows in one run; what most runs show is none."""

from __future__ import annotations

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.candidates import accepted
from testbed.diagnosis.fitting import nominal_fit
from testbed.diagnosis.model import Hypothesis
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
