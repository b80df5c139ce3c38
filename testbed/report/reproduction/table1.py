"""Table 1 and figures 1 and 2: the maneuvers and their information, in the paper's metric."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from testbed.report.frame.blocks import Block, Cell, Column, Paragraph, Section, Table, Tone
from testbed.report.reproduction.figures import figure_blocks
from testbed.report.wording import figures
from testbed.reproduction.claims import PAPER_MARGIN, factors_of
from testbed.reproduction.figures import PaperFigure
from testbed.reproduction.table1 import PaperRow, Row, Table1, Way

_NAMES = {"basic": "basic", "A": "A-opt", "D": "D-opt", "E": "E-opt", "condition": "C.N°-opt"}
_WAYS: dict[Way, str] = {
    "given": "reconstructed",
    "paper": "as the paper did",
    "hard": "this project",
    "gimbal": "gimbal space",
}


def table1_section(table: Table1, shown: Sequence[PaperFigure]) -> Section:
    """Return Table 1 in all ways, and the maneuvers behind figures 1 and 2."""
    charts = [block for figure in shown for block in figure_blocks(figure)]
    blocks: tuple[Block, ...] = (_introduction(), _table(table.rows), *charts)
    return Section(title="Table 1, figures 1 and 2", blocks=blocks)


def _introduction() -> Paragraph:
    return Paragraph(
        text="Figures of Ψ_fᵀΨ_f, γ = 0.8 s, of the maneuver followed exactly. As the paper did: penalties of sixth "
        "power and one start from the basic profile. This project: hard limits and several starts; and splines of the "
        "gimbal angles inside the cluster's own limits, which can be flown as designed."
    )


def _table(rows: Sequence[Row]) -> Table:
    titles = ("min. eigenvalue ↑", "trace of inverse ↓", "determinant ↑", "condition number of Ψ_f ↓", "largest rate")
    columns = (
        Column(title="Maneuver"),
        *(Column(title=title) for title in titles[:4]),
        Column(title=titles[4], unit="rad/s"),
        Column(title="designs", unit="starts, s"),
    )
    names = dict.fromkeys(row.name for row in rows)
    lines = [line for name in names for line in _lines(name, [row for row in rows if row.name == name])]
    return Table(
        columns=columns,
        rows=tuple(lines),
        note="At 16 Hz. The condition number is that of Ψ_f; of Ψ_fᵀΨ_f it is the square. In bold: more than "
        f"{PAPER_MARGIN:.0%} from the paper's row, in a design made as the paper did, or of the reconstructed profile; "
        "of the determinant, its sixth root. More control points than the paper may have had explain it: they allow "
        "faster motion within the same limits.",
    )


def _lines(name: str, rows: Sequence[Row]) -> Iterator[tuple[Cell, ...]]:
    paper = (f"{_NAMES[name]}, paper", *_figures(rows[0].paper), "", "")
    yield tuple(Cell(text=text, tone="faint") for text in paper)
    for row in rows:
        designed = f"{row.starts}, {row.seconds:.1f}" if row.starts else ""
        cells = (Cell(text=text, tone=tone) for text, tone in zip(_figures(row), _tones(row), strict=True))
        title = Cell(text=f"{_NAMES[name]}, {_WAYS[row.way]}")
        yield (title, *cells, Cell(text=f"{row.peak_rate:.2f}"), Cell(text=designed))


def _tones(row: Row) -> Iterator[Tone]:
    """Mark figures that should be the paper's and are not."""
    for factor in factors_of(row).values():
        yield "warn" if row.way in ("given", "paper") and abs(factor - 1.0) > PAPER_MARGIN else "plain"


def _figures(row: Row | PaperRow) -> tuple[str, ...]:
    numbers = (row.min_eigenvalue, row.trace_inverse, row.determinant, row.regressor_condition_number)
    return tuple(figures(number, 4) for number in numbers)
