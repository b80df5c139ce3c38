"""The elliptic internal singularity of four gyros: where it is by theory, laws that lock there and laws that escape."""

from __future__ import annotations

from math import cos, radians

import pytest

from benchmarks.elliptic_singularity import crossed

HELD_THERE = 2.0 * 0.004714 * cos(radians(54.74))
"""N·m·s along x with two units at ±90° and two at zero."""


@pytest.mark.parametrize("law", ["moore_penrose", "singularity_robust"])
def test_a_law_that_gives_the_wanted_torque_alone_locks_where_theory_has_the_singularity(law):
    found = crossed(0.3, law)
    assert found.held == pytest.approx(HELD_THERE, rel=0.01)
    assert found.rms > 0.015


@pytest.mark.parametrize("law", ["generalized_singularity_robust", "off_diagonal_singularity_robust"])
def test_a_dithered_law_escapes(law):
    found = crossed(0.3, law)
    assert found.held == pytest.approx(0.022 * 0.3, rel=0.01)
    assert found.rms < 0.008
    assert found.saturated < 0.05


def test_below_the_singularity_all_is_well():
    assert crossed(0.2, "singularity_robust").furthest < 1e-3
