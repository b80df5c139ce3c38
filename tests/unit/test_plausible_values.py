"""Doubts about a parameter's value: between what hardware has at least and at most there are none."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.diagnosis.findings import passed_limit
from testbed.diagnosis.model import Hypothesis
from testbed.effects.contract import TYPICAL_INERTIA
from testbed.effects.registry import EFFECTS


@pytest.mark.parametrize(
    ("value", "limits", "passed"),
    [(0.77, (0.2, 6.0), None), (0.1, (0.2, 6.0), 0.2), (7.0, (0.2, 6.0), 6.0), (-0.3, (-0.2, 0.2), -0.2)],
)
def test_a_value_is_in_doubt_beyond_the_limit_that_it_passes_alone(value, limits, passed):
    assert passed_limit(value, *limits) == passed


@pytest.mark.parametrize("name", ["flexible_appendage", "slosh"])
def test_masses_and_inertias_are_searched_as_far_as_the_platform_goes(name):
    effect = EFFECTS[name]
    small, usual, large = (
        Hypothesis(effect=effect, component="platform", moment=times * TYPICAL_INERTIA).bounds
        for times in (0.1, 1, 250)
    )
    for bounds in (small, usual):
        np.testing.assert_array_equal(bounds, effect.bounds)
    for greater, ordinary in zip(large, usual, strict=True):
        np.testing.assert_allclose(greater[2:], 250.0 * ordinary[2:])
        np.testing.assert_array_equal(greater[:2], ordinary[:2])  # frequency and damping


def test_a_search_that_may_not_turn_round_reaches_as_far():
    placed = Hypothesis(effect=EFFECTS["slosh"], component="platform", moment=10.0 * TYPICAL_INERTIA)
    lower, upper = placed.reach(np.array([1.0, 0.05, 1e-6, 0.0, 0.0]))
    np.testing.assert_allclose(lower[2:], [0.0, -9.0, -9.0])
    np.testing.assert_allclose(upper[2:], 9.0)
