"""Indistinguishable effects of a blind case, distinguished by the proposed flight, flown on the hidden craft."""

from __future__ import annotations

from benchmarks.separation import SITUATIONS, distinguished, realised

EFFECTS = ("inertia", "viscous_drag", "quadratic_drag", "body_torque")
"""A library that is tried in seconds; `python -m benchmarks.separation` tries the whole one."""


def test_linear_and_quadratic_drag_are_distinguished_by_the_proposed_flight(tmp_path):
    outcome = distinguished(SITUATIONS["quadratic or linear drag"], tmp_path, effects=EFFECTS)
    assert outcome.before.verdict == "ambiguous"
    (separation,) = outcome.proposal.separations
    assert set(separation.keys) == {"quadratic_drag:platform", "viscous_drag:platform"}
    assert separation.now < 3.0 < separation.wanted
    assert outcome.proposal.enough
    assert outcome.after.verdict == "named"
    assert [step.placed.effect.id for step in outcome.after.steps] == ["quadratic_drag"]
    ahead = realised(outcome.after, "viscous_drag:platform")
    # The square of a distance D scatters with 2 D: half of what was predicted is by chance once in 1,000 cases.
    assert ahead > 0.5 * separation.after
