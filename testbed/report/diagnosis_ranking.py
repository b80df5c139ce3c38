"""The effects that were refitted in each step, the most probable first."""

from __future__ import annotations

from collections.abc import Iterator

from testbed.diagnosis.candidates import Screening
from testbed.diagnosis.probabilities import probabilities_of
from testbed.diagnosis.state import Diagnosis
from testbed.report.frame.blocks import Block, Cell, Column, Paragraph, Section, Table
from testbed.report.wording import figures

_MEANING = (
    "Gain is the fall of χ² of the fitted runs. The evidence counts what the held-out runs say as well, and takes off "
    "what parameters cost; what lies within 6 of the best is not told from it. p is family-wise, over all effects that "
    "were tested."
)


def ranking_section(diagnosis: Diagnosis) -> Iterator[Section]:
    """Yield the section, once the effects were looked at: a table for each step, and one of what was left then."""
    screenings = [step.screening for step in diagnosis.steps]
    if diagnosis.remaining is not None:
        screenings.append(diagnosis.remaining)
    tables: list[Block] = [_table(added, each) for added, each in enumerate(screenings) if each.candidates]
    if tables:
        yield Section(title="Effects, ranked", blocks=(Paragraph(text=_MEANING), *tables))


def _table(added: int, screening: Screening) -> Table:
    titles = (f"With {added} added" if added else "Nothing added", "component", "probability", "gain", "evidence", "p")
    probability = probabilities_of(screening)
    rows = tuple(
        (
            Cell(text=candidate.placed.effect.id),
            Cell(text=candidate.placed.component),
            Cell(text=f"{probability[candidate.placed.key]:.3f}"),
            Cell(text=f"{candidate.gain:.1f}"),
            Cell(text=f"{candidate.evidence:+.1f}"),
            Cell(text=figures(candidate.p_value, 1)),
        )
        for candidate in screening.candidates
    )
    return Table(columns=tuple(Column(title=title) for title in titles), rows=rows, numeric=False)
