"""The verdict: every figure to reach, what was measured, and whether it is met."""

from __future__ import annotations

from collections.abc import Sequence

from testbed.report.frame.blocks import Cell, Column, Notice, Section, Table, Tone
from testbed.reproduction.claims import Claim
from testbed.reproduction.seeds import ClaimOverSeeds


def claims_section(claims: Sequence[Claim], over_seeds: Sequence[ClaimOverSeeds]) -> Section:
    """Return the table of claims, and how many seeds meet each where several were flown."""
    columns = tuple(
        Column(title=title) for title in ("", "claim", "target", "measured", "verdict", "fitted or could fail")
    )
    rows = tuple(
        (*_texts(each.subject, each.what, each.target, each.measured), _met(each), *_texts(each.test))
        for each in claims
    )
    note = (
        "Judged from the numbers of this reproduction. Undecided: missed, with too few flights to tell; fly them all. "
        "Fitted: what the claim speaks of was chosen with its target in sight, so that meeting it proves little."
    )
    table = Table(columns=columns, rows=rows, note=note, numeric=False)
    seeds = (_seeds_table(over_seeds),) if over_seeds else ()
    return Section(title="Figures to reach", blocks=(table, *seeds))


def _seeds_table(over_seeds: Sequence[ClaimOverSeeds]) -> Table:
    flown = tuple(over_seeds[0].by_seed)
    titles = ("", "met", "missed", "undecided", "not met at seed")
    return Table(
        columns=tuple(Column(title=title) for title in titles),
        rows=tuple(_seeds_row(each) for each in over_seeds),
        note=f"The same claims with seeds {flown[0]} to {flown[-1]}, all flown anew with each; those above are seed "
        f"{flown[0]}'s. What does not depend on the seed is left out.",
        numeric=False,
    )


def _seeds_row(each: ClaimOverSeeds) -> tuple[Cell, ...]:
    counts = (str(each.counts[verdict]) for verdict in ("met", "missed", "undecided"))
    return _texts(each.claim.subject, *counts, ", ".join(map(str, each.missed_at)) or "–")


def _texts(*texts: str) -> tuple[Cell, ...]:
    return tuple(Cell(text=text) for text in texts)


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
