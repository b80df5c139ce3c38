"""What diagnosis.json says of the next flight."""

from __future__ import annotations

from typing import Any

from testbed.next_experiment.proposal import Proposal


def next_of(proposal: Proposal | None, scenario: str | None) -> dict[str, Any]:
    """Return the entry `next`; empty where nothing is ambiguous.

    Args:
        proposal: what to fly.
        scenario: its file, relative to the folder of the diagnosis; None where there is none.
    """
    if proposal is None:
        return {}
    pairs = [
        {
            "pair": list(each.keys),
            "sigma_now": each.now,
            "sigma_after": each.after,
            "sigma_wanted": each.wanted,
            "separable": each.separable,
        }
        for each in proposal.separations
    ]
    return {"next": {"scenario": scenario, "flights": proposal.times, "enough": proposal.enough, "pairs": pairs}}
