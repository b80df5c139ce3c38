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
    "what parameters cost; what lies within 6 of the best is not told from it, and where every model leaves more "
    "than noise, what differs from it by no more than from run to run. Such a class has one probability. p is "
    "family-wise, over all effects that were tested."
)


def ranking_section(diagnosis: Diagnosis) -> Iterator[Section]:
    """Yield the section, once the effects were looked at: a table for each step, and one of what was left then."""
    screenings = [step.screening for step in diagnosis.steps]
    if diagnosis.remaining is not None:
        screenings.append(diagnosis.remaining)
    tables: list[Block] = [_table(added, each) for added, each in enumerate(screenings) if each.candidates]
    if tables:
        yield Section(title="Effects, ranked", blocks=(Paragraph(text=_MEANING), *tables))


RANKING = ("component", "probability", "gain", "evidence", "p")
"""What stands behind each effect."""


def ranking_rows(screening: Screening) -> Iterator[tuple[str, ...]]:
    """Yield an effect and what stands under `RANKING`; a class that is not told apart has one probability."""
    probability = probabilities_of(screening)
    members = [candidate.placed.key for candidate in screening.close] if screening.chosen is not None else []
    for index, candidate in enumerate(screening.candidates):
        key = candidate.placed.key
        own = f"{sum(probability[each] for each in (members if key in members else [key])):.3f}"
        yield (
            candidate.placed.effect.id,
            candidate.placed.component,
            "same class" if index and key in members else own,
            f"{candidate.gain:.1f}",
            f"{candidate.evidence:+.1f}",
            figures(candidate.p_value, 1) if candidate.p_value > 0.0 else "< 1e-300",
        )


def _table(added: int, screening: Screening) -> Table:
    titles = (f"With {added} added" if added else "Nothing added", *RANKING)
    rows = tuple(tuple(Cell(text=text) for text in row) for row in ranking_rows(screening))
    return Table(columns=tuple(Column(title=title) for title in titles), rows=rows, numeric=False)
