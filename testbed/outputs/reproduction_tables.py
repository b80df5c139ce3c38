"""The claims and Tables 2 and 3 of a reproduction as markdown, for its recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbed.arrays import Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.reproduction.claims import Claim
from testbed.reproduction.reproduction import Reproduction
from testbed.reproduction.table2 import ManeuverStatistics
from testbed.reproduction.zero_g import PAPER_THETA

_UNIT = "1e-3 kg·m²"


def tables_text(reproduction: Reproduction, claims: Sequence[Claim]) -> str:
    """Return the claims, and Tables 2 and 3 beside the paper's."""
    combined = reproduction.table3.combined["iv"]
    table2 = [row for maneuver in reproduction.table2 for row in _maneuver_rows(maneuver)]
    table3 = [
        ("estimate, paper", *_milli(PAPER_THETA)),
        ("truth here", *_milli(reproduction.table3.true_theta)),
        ("estimate here", *_milli(combined.theta)),
        ("± here", *_milli(combined.std)),
    ]
    judged = [(f"{claim.subject}: {claim.what}", claim.target, claim.measured, claim.verdict) for claim in claims]
    parts = (
        "## Figures to reach",
        _table(("claim", "target", "measured", ""), judged),
        f"## Table 2: standard deviations of the instrumental variable, {_UNIT}",
        _table(("", *PARAMETER_NAMES), table2),
        f"## Table 3, {_UNIT}",
        _table(("", *PARAMETER_NAMES), table3),
        "Table 1, every estimator and the rest: reproduction.html.",
    )
    return "\n\n".join(parts)


def _maneuver_rows(maneuver: ManeuverStatistics) -> Iterator[tuple[str, ...]]:
    if maneuver.paper_std is not None:
        yield (f"{maneuver.title}, paper", *_milli(maneuver.paper_std))
    yield (f"{maneuver.title}, here", *_milli(maneuver.statistics.estimators["iv"].std))
    yield (f"{maneuver.title}, bound", *_milli(maneuver.statistics.bound_std))


def _milli(values: Theta) -> list[str]:
    return [f"{1e3 * value:z.2f}" for value in np.asarray(values)]


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
