"""What a page is made of, as plain data; the template decides what it looks like."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, TypeAlias

import plotly.graph_objects as go

Tone: TypeAlias = Literal["plain", "good", "warn", "bad", "faint"]
"""What a colour says: nothing, as it should be, worth a look, wrong, of secondary interest."""


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One cell of a table."""

    text: str
    tone: Tone = "plain"


@dataclass(frozen=True, kw_only=True)
class Column:
    """A table column's header; the unit is printed below the title."""

    title: str
    unit: str = ""


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table; the first cell of each row is the row's header.

    Attributes:
        columns: headers.
        rows: as many cells as columns, each.
        note: what a reader needs to know to read it, printed below.
        numeric: whether the cells beside the row headers are numbers, which are set flush right.
        wide: whether it takes the page's full width instead of half.
        folded: what it is, to click at where it is collapsed at first; empty where it is in view.
    """

    kind: ClassVar[str] = "table"
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    numeric: bool = True
    wide: bool = True
    folded: str = ""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A chart with its title.

    Attributes:
        title: printed above.
        chart: its colours are names of the style sheet's custom properties.
        note: printed below.
        wide: whether it takes the page's full width instead of half.
        tall: whether it takes more height, for an axis with many names.
        shares_time: whether it follows when the time axis of another chart is zoomed.
    """

    kind: ClassVar[str] = "figure"
    title: str
    chart: go.Figure
    note: str = ""
    wide: bool = False
    tall: bool = False
    shares_time: bool = False


@dataclass(frozen=True, kw_only=True)
class Listing:
    """A text shown as it is, collapsed at first."""

    kind: ClassVar[str] = "listing"
    title: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Paragraph:
    """A paragraph of plain text."""

    kind: ClassVar[str] = "paragraph"
    text: str


Block: TypeAlias = Table | Figure | Listing | Paragraph


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the page with its heading."""

    title: str
    blocks: tuple[Block, ...]

    @property
    def anchor(self) -> str:
        """Name for links: the title in lower case, words joined by hyphens."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")


@dataclass(frozen=True, kw_only=True)
class Notice:
    """A sentence that has to be seen before anything else."""

    text: str
    tone: Tone


@dataclass(frozen=True, kw_only=True)
class Page:
    """A report.

    Attributes:
        title: of the page.
        subtitle: what it reports on, one sentence.
        verdict: the answer in one plain sentence.
        notices: what spoils or qualifies it.
        sections: in order.
    """

    title: str
    subtitle: str
    verdict: Notice
    notices: tuple[Notice, ...]
    sections: tuple[Section, ...]

    @property
    def has_figures(self) -> bool:
        """Whether there is any chart."""
        return any(isinstance(block, Figure) for section in self.sections for block in section.blocks)

    @property
    def sections_without_figures(self) -> tuple[Section, ...]:
        """The sections without charts, and none that held nothing else."""
        kept = [tuple(block for block in each.blocks if not isinstance(block, Figure)) for each in self.sections]
        return tuple(
            replace(section, blocks=blocks) for section, blocks in zip(self.sections, kept, strict=True) if blocks
        )
