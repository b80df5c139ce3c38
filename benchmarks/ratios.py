"""One paired measurement: this testbed and what it is held against, in the same run on the same machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Ratio:
    """A row of docs/benchmarks.md.

    Attributes:
        what: what was measured, a few words.
        ours: our side with its unit, as printed; empty where only the ratio means anything.
        theirs: the other side, named, with its unit.
        ratio: how many times better ours is, or the ratio that `what` names; None where it was not measured.
        target: what the ratio has to keep, as printed; empty where there is none.
        command: prints the figure again.
        note: how it was measured, or why it was not; one line.
    """

    what: str
    ours: str
    theirs: str
    ratio: float | None
    target: str
    command: str
    note: str = ""
