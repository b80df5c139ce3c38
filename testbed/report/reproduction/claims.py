"""The verdict: every figure to reach, what was measured, and whether it is met."""

from __future__ import annotations

from collections.abc import Sequence

from testbed.report.frame.blocks import Cell, Column, Notice, Section, Table, Tone
from testbed.reproduction.claims import Claim


def claims_section(claims: Sequence[Claim]) -> Section:
    """Return the table of claims."""
    columns = tuple(Column(title=title) for title in ("", "claim", "target", "measured", "verdict"))
    rows = tuple(
        (*(Cell(text=text) for text in (each.subject, each.what, each.target, each.measured)), _met(each))
        for each in claims
    )
    note = (
        "Judged from the numbers of this reproduction. Undecided: missed, with too few flights to tell; fly them all."
    )
    return Section(title="Figures to reach", blocks=(Table(columns=columns, rows=rows, note=note, numeric=False),))


def _met(claim: Claim) -> Cell:
    tones: dict[str, Tone] = {"met": "good", "missed": "bad", "undecided": "warn"}
    return Cell(text=claim.verdict, tone=tones[claim.verdict])


def claims_verdict(claims: Sequence[Claim]) -> Notice:
    """Return in a sentence how many of the figures are reached, and which are not."""
    missed = [claim.subject for claim in claims if claim.verdict == "missed"]
    undecided = [claim.subject for claim in claims if claim.verdict == "undecided"]
    sentences = [f"{len(claims) - len(missed) - len(undecided)} of {len(claims)} figures are reached."]
    if missed:
        sentences.append(f"Missed: {'; '.join(dict.fromkeys(missed))}.")
    if undecided:
        sentences.append(f"Too few flights to tell: {'; '.join(dict.fromkeys(undecided))}.")
    return Notice(tone="warn" if missed else "good", text=" ".join(sentences))
