"""The verdict: every figure to reach, what was measured, and whether it is met."""

from __future__ import annotations

from collections.abc import Sequence

from testbed.report.frame.blocks import Cell, Column, Notice, Section, Table, Tone
from testbed.report.wording import listed
from testbed.reproduction.claims import Claim

NO_BREAK_SPACE = "\N{NO-BREAK SPACE}"


def claims_section(claims: Sequence[Claim]) -> Section:
    """Return the table of claims."""
    columns = tuple(Column(title=title) for title in ("", "claim", "target", "measured", "verdict"))
    rows = tuple(
        (*(Cell(text=text) for text in (each.subject, each.what, each.target, each.measured)), _met(each))
        for each in claims
    )
    note = "Judged from the numbers of this reproduction; nothing in this table is written beforehand but the targets."
    return Section(title="Figures to reach", blocks=(Table(columns=columns, rows=rows, note=note, numeric=False),))


def _met(claim: Claim) -> Cell:
    tones: dict[str, Tone] = {"met": "good", "not met": "bad"}
    return Cell(text=claim.verdict.replace(" ", NO_BREAK_SPACE), tone=tones.get(claim.verdict, "warn"))


def claims_verdict(claims: Sequence[Claim]) -> Notice:
    """Return in a sentence how many of the figures are reached, and which are not."""
    missed = [claim.subject for claim in claims if claim.verdict == "not met"]
    open_ones = [claim.subject for claim in claims if claim.verdict == "too few flights to tell"]
    sentences = [f"{len(claims) - len(missed) - len(open_ones)} of {len(claims)} figures are reached."]
    if missed:
        sentences.append(f"Not reached: {listed(dict.fromkeys(missed))}.")
    if open_ones:
        sentences.append(f"Too few flights to tell: {listed(dict.fromkeys(open_ones))}.")
    return Notice(tone="warn" if missed else "good", text=" ".join(sentences))
