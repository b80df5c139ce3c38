"""Look-alikes of a blind case, told apart by the flight that the diagnosis proposes, flown on the hidden craft."""

from __future__ import annotations

from benchmarks.separation import SITUATIONS, realised, told_apart

EFFECTS = ("inertia", "viscous_drag", "quadratic_drag", "body_torque")
"""A library that is tried in seconds; `python -m benchmarks.separation` tries the whole one."""


def test_linear_and_quadratic_drag_are_told_apart_by_the_proposed_flight(tmp_path):
    told = told_apart(SITUATIONS["quadratic or linear drag"], tmp_path, effects=EFFECTS)
    assert told.before.verdict == "ambiguous"
    (separation,) = told.proposal.separations
    assert set(separation.keys) == {"quadratic_drag:platform", "viscous_drag:platform"}
    assert separation.now < 3.0 < separation.wanted
    assert told.proposal.enough
    assert told.after.verdict == "named"
    assert [step.placed.effect.id for step in told.after.steps] == ["quadratic_drag"]
    ahead = realised(told.after, "viscous_drag:platform")
    # The square of a distance D scatters with 2 D: half of what was predicted is by chance once in 1,000 cases.
    assert ahead > 0.5 * separation.after
