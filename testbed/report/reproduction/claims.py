"""The verdict: every figure to reach, what was measured, and whether it is met."""

from __future__ import annotations

from collections.abc import Sequence

from testbed.report.frame.blocks import Cell, Column, Notice, Section, Table
from testbed.report.wording import listed
from testbed.reproduction.claims import Claim


def claims_section(claims: Sequence[Claim]) -> Section:
    """Return the table of claims."""
    columns = tuple(Column(title=title) for title in ("Claim", "target", "measured", "verdict"))
    rows = tuple(
        (Cell(text=each.what), Cell(text=each.target), Cell(text=each.measured), _met(each)) for each in claims
    )
    note = "Judged from the numbers of this reproduction; nothing in this table is written beforehand but the targets."
    return Section(title="Figures to reach", blocks=(Table(columns=columns, rows=rows, note=note, numeric=False),))


def _met(claim: Claim) -> Cell:
    return Cell(text="met", tone="good") if claim.met else Cell(text="not met", tone="bad")


def claims_verdict(claims: Sequence[Claim]) -> Notice:
    """Return in a sentence how many of the figures are reached, and which are not."""
    missed = [claim for claim in claims if not claim.met]
    reached = f"{len(claims) - len(missed)} of {len(claims)} figures are reached"
    if not missed:
        return Notice(tone="good", text=f"All {len(claims)} figures are reached.")
    return Notice(tone="warn", text=f"{reached}. Not reached: {listed(claim.what for claim in missed)}.")
