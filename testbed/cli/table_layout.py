"""Tables that lose no digit on a narrow terminal: columns that do not fit beside the others follow below them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import replace
from itertools import takewhile
from sys import maxsize

from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table


def fitted(table: Table, console: Console) -> Iterator[Table]:
    """Give a table in parts that a console can show without cutting a number or a word, in one where it fits.

    Each part begins with the columns without a heading, or with the first column: they say what its rows are. Where
    even a single column beside them is too wide, the terminal breaks its lines.

    Args:
        table: its columns that must not be broken between words have no_wrap.
        console: where it will be shown.
    """
    labels = max(1, sum(1 for _ in takewhile(lambda column: not column.header, table.columns)))
    head, left = table.columns[:labels], table.columns[labels:]
    part = _part(table, [*head, *left[: _as_many_as_fit(table, head, left, console)]])
    part.title = table.title
    least = _least_width(table, part.columns, console)
    part.width = least if least > console.width else table.width  # rich would cut it to what there is
    yield part
    if rest := table.columns[len(part.columns) :]:
        yield from fitted(_part(table, [*head, *rest]), console)


def _as_many_as_fit(table: Table, head: Sequence[Column], left: Sequence[Column], console: Console) -> int:
    """Return how many more columns fit beside the first ones, at least one."""
    counts = range(len(left), 1, -1)
    return next((n for n in counts if _least_width(table, [*head, *left[:n]], console) <= console.width), 1)


def _least_width(table: Table, columns: Sequence[Column], console: Console) -> int:
    """Return the width of some columns of a table below which a number or a word would be cut."""
    narrowest = [replace(column, width=_narrowest(column)) for column in columns]
    return Measurement.get(console, console.options.update_width(maxsize), _part(table, narrowest)).maximum


def _narrowest(column: Column) -> int:
    texts = [str(cell) for cell in (column.header, *column.cells)]
    pieces = texts if column.no_wrap else [word for text in texts for word in text.split()]
    return max(map(cell_len, pieces), default=0)


def _part(table: Table, columns: Sequence[Column]) -> Table:
    """Return a table with some of its columns, none narrower than its words, without its title."""
    part = copy(table)
    part.title = None
    part.columns = [replace(column, _index=index, min_width=_narrowest(column)) for index, column in enumerate(columns)]
    return part
