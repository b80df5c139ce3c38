"""Doubts about a parameter's value: between what hardware has at least and at most there are none."""

from __future__ import annotations

import pytest

from testbed.diagnosis.findings import passed_limit


@pytest.mark.parametrize(
    ("value", "limits", "passed"),
    [(0.77, (0.2, 6.0), None), (0.1, (0.2, 6.0), 0.2), (7.0, (0.2, 6.0), 6.0), (-0.3, (-0.2, 0.2), -0.2)],
)
def test_a_value_is_in_doubt_beyond_the_limit_that_it_passes_alone(value, limits, passed):
    assert passed_limit(value, *limits) == passed
