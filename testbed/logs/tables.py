"""CSV and Parquet with any names of columns. Only the columns that are wanted are held in memory."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BufferedReader
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
import pyarrow.parquet
from typing_extensions import override

from testbed.errors import InputError
from testbed.files import open_regular
from testbed.logs.streams import TABLE, Content, Log, Numbers, Room, Stream, Topic, Wanted, doubles, parsing

PARQUET_MAGIC = b"PAR1"
_SEPARATORS = (",", ";", "\t")
_COMMENTS = ("#", "%")
_MOST_COMMENTS = 1000
"""Lines above the names of the columns."""
_LONGEST_LINE = 2**20
"""Bytes; the names of a thousand columns take a tenth of it."""
_MOST_RAGGED = 1000
"""Rows of another length than the header beyond which a file is no table."""
_BATCH = 65_536
"""Rows of a Parquet file that are taken at once."""
_BLOCK = 2**22
"""Bytes of a CSV file that are taken at once."""
_TIME_OF_DAY = r"^\d{1,2}:\d{2}:\d{2}(\.\d{1,9})?$"
"""What a clock shows that states no date, to the nanoseconds that are read."""
_ANY_DAY = "1970-01-01"
"""To which such a time is put: the first of the count, so that it is one since midnight."""
_DAY = 86_400 * 10**9
"""ns"""
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d+([eE][+-]?\d+)?\s*")


@dataclass(frozen=True, kw_only=True)
class _Layout:
    """How a CSV file is written.

    Attributes:
        names: of the columns.
        units: by column, where a line below the names states them.
        skipped: lines before the first row.
        separator: of the fields.
        decimal_comma: whether decimals stand behind a comma.
        encoding: of the text.
    """

    names: list[str]
    units: dict[str, str]
    skipped: int
    separator: str
    decimal_comma: bool
    encoding: str


@dataclass(kw_only=True)
class _Column:
    """A column as it is collected.

    Attributes:
        parts: its numbers, by batch.
        unit: that its type states; None where it states none.
        of_day: whether its times begin anew at midnight.
        words: cells that are no numbers.
        first_word: the first of these.
    """

    parts: list[Numbers] = field(default_factory=list)
    unit: str | None = None
    of_day: bool = False
    words: int = 0
    first_word: str = ""

    @property
    def numbers(self) -> Numbers:
        """All of them; times of day go on where a day ends."""
        whole = np.concatenate(self.parts)
        return _over_midnight(whole) if self.of_day else whole


@dataclass(frozen=True)
class CsvTable(Log):
    """A CSV file, separated by commas, semicolons or tabs."""

    format: ClassVar[str] = "CSV"

    @override
    def survey(self) -> Mapping[str, Topic]:
        """Return the columns that hold numbers."""
        with self._batches(None, []) as (layout, batches):
            return {TABLE: _surveyed(batches, layout.units, decimal_comma=layout.decimal_comma)}

    @override
    def read(self, wanted: Wanted) -> Content:
        """Read columns."""
        damage: list[str] = []
        with self._batches(wanted.get(TABLE, ()), damage) as (layout, batches):
            room = Room(self.path)
            columns = _collected(batches, wanted.get(TABLE, ()), room, decimal_comma=layout.decimal_comma)
            unused = [name for name in layout.names if name not in columns]
        return _content(columns, unused, damage, layout.units)

    @contextmanager
    def _batches(
        self, wanted: Iterable[str] | None, damage: list[str]
    ) -> Iterator[tuple[_Layout, Iterable[pa.RecordBatch]]]:
        """Give the rows of columns in batches; what is wrong with rows is added to `damage` as they come."""
        with parsing(self.path, self.format), open_regular(self.path) as file:
            layout = _layout(self.path, file)
            ragged: list[str] = []

            def note(row: pa.csv.InvalidRow) -> str:
                ragged.append(
                    f"row {row.number - layout.skipped}: {row.actual_columns} fields of {row.expected_columns}"
                )
                return "skip" if len(ragged) < _MOST_RAGGED else "error"

            file.seek(0)
            held = layout.names if wanted is None else [name for name in layout.names if name in wanted]
            yield (
                layout,
                pa.csv.open_csv(
                    file,
                    read_options=pa.csv.ReadOptions(
                        use_threads=False,  # threads would not number the rows
                        block_size=_BLOCK,
                        skip_rows=layout.skipped,
                        column_names=layout.names,
                        encoding=layout.encoding,
                    ),
                    parse_options=pa.csv.ParseOptions(delimiter=layout.separator, invalid_row_handler=note),
                    convert_options=pa.csv.ConvertOptions(
                        include_columns=held,
                        column_types=dict.fromkeys(layout.names, pa.string()),
                        null_values=[""],
                        strings_can_be_null=True,
                    ),
                )
                if held
                else (),
            )
        if ragged:
            rows = "1 row has" if len(ragged) == 1 else f"{len(ragged)} rows have"
            damage.append(f"{rows} another number of fields than the header ({ragged[0]}): left out")


@dataclass(frozen=True)
class ParquetTable(Log):
    """A Parquet file."""

    format: ClassVar[str] = "Parquet"

    @override
    def survey(self) -> Mapping[str, Topic]:
        """Return the columns that hold numbers."""
        with self._opened() as table:
            return {TABLE: _surveyed(table.iter_batches(_BATCH), {})}

    @override
    def read(self, wanted: Wanted) -> Content:
        """Read columns."""
        with self._opened() as table:
            names = table.schema_arrow.names
            held = [name for name in names if name in wanted.get(TABLE, ())]
            Room(self.path).take(table.metadata.num_rows * len(held))
            batches = table.iter_batches(_BATCH, columns=held)
            columns = _collected(batches, held, Room(self.path))
        return _content(columns, [name for name in names if name not in columns], [])

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        with parsing(self.path, self.format), open_regular(self.path) as file, pa.parquet.ParquetFile(file) as table:
            yield table


def _layout(path: Path, file: BufferedReader) -> _Layout:
    """Return how a CSV file is written, from its first lines."""
    comments: list[bytes] = []
    line = file.readline(_LONGEST_LINE).removeprefix(codecs.BOM_UTF8)
    while line.lstrip().startswith(tuple(mark.encode() for mark in _COMMENTS)) and len(comments) < _MOST_COMMENTS:
        comments.append(line)
        line = file.readline(_LONGEST_LINE)
    head = b"".join([*comments[-1:], line, second := file.readline(_LONGEST_LINE)])
    try:
        head.decode("utf-8")
        encoding = "utf-8-sig"
    except UnicodeDecodeError:
        encoding = "latin-1"  # which knows every byte; a degree sign is what it mostly is
    first, following = line.decode(encoding, "replace"), second.decode(encoding, "replace")
    separator = max(_SEPARATORS, key=first.count)
    cells = _cells(first, separator)
    if _numeric(cells):  # names stand in a comment, as numpy.savetxt writes them
        above = comments[-1].decode(encoding, "replace").lstrip().lstrip("".join(_COMMENTS)) if comments else ""
        names, skipped, row = _cells(above, separator), len(comments), cells
    else:
        names, skipped, row = cells, len(comments) + 1, _cells(following, separator)
    _require_names(path, names, len(cells))
    if skipped > len(comments) and not second.strip() and not file.read(_LONGEST_LINE).strip():
        raise InputError(f"{path}: holds names of columns, {', '.join(names)[:200]}, and no row of numbers behind them")
    units = {}
    if row and len(row) == len(names) and skipped > len(comments) and not any(map(_is_number, row)):
        units = {name: unit.strip("[]() ") for name, unit in zip(names, row, strict=True)}
        skipped += 1
        row = _cells(file.readline(_LONGEST_LINE).decode(encoding, "replace"), separator)
    comma = separator != "," and any(_DECIMAL_COMMA.fullmatch(cell) for cell in row)
    return _Layout(
        names=names,
        units=units,
        skipped=skipped,
        separator=separator,
        decimal_comma=comma,
        encoding="utf8" if encoding == "utf-8-sig" else "latin1",
    )


def _require_names(path: Path, names: Sequence[str], columns: int) -> None:
    if not any(names) or len(names) != columns:
        raise InputError(f"{path}: does not begin with the names of its columns; write them into its first line")
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise InputError(f"{path}: more than one column is called {', '.join(map(repr, repeated))}; rename them")


def _cells(line: str, separator: str) -> list[str]:
    if not line.strip():
        return []
    return [cell.strip() for cell in next(csv.reader([line.lstrip("\ufeff")], delimiter=separator))]


def _numeric(cells: Sequence[str]) -> bool:
    return bool(cells) and all(_is_number(cell) for cell in cells if cell)


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _surveyed(batches: Iterable[pa.RecordBatch], units: Mapping[str, str], *, decimal_comma: bool = False) -> Topic:
    """Return what a table offers: the columns that hold numbers in their first rows."""
    first = next(iter(batches), None)
    if first is None:
        return Topic(kind="", fields={}, received=False)
    fields, stated, empty = {}, dict(units), []
    for name in first.schema.names:
        column = _Column()
        values = _numbers(first.column(name), column, decimal_comma=decimal_comma)
        numbers = np.zeros(0) if values is None else doubles(values)
        present = numbers[np.isfinite(numbers)]
        if present.size:
            fields[name] = float(present[0])
            stated |= {} if column.unit is None else {name: column.unit}
        else:
            empty.append(name)
    units = {name: unit for name, unit in stated.items() if unit}
    return Topic(kind="", fields=fields, units=units, received=False, empty=empty)


def _collected(
    batches: Iterable[pa.RecordBatch], wanted: Iterable[str], room: Room, *, decimal_comma: bool = False
) -> dict[str, _Column]:
    columns: dict[str, _Column] = {}
    for batch in batches:
        room.take(batch.num_rows * batch.num_columns)
        for name in (name for name in wanted if name in batch.schema.names):
            column = columns.setdefault(name, _Column())
            values = _numbers(batch.column(name), column, decimal_comma=decimal_comma)
            column.parts.append(np.full(batch.num_rows, np.nan) if values is None else values)
    return columns


def _not_numbers(column: _Column) -> str:
    if column.words == 1:
        return f"1 cell is no number but {column.first_word!r}"
    return f"{column.words} cells are no numbers, the first {column.first_word!r}"


def _content(
    columns: Mapping[str, _Column],
    unused: Sequence[str],
    damage: Sequence[str],
    stated: Mapping[str, str] = MappingProxyType({}),
) -> Content:
    words = [
        f"column {name}: {_not_numbers(column)}: taken as not sampled"
        for name, column in columns.items()
        if column.words
    ]
    fields = {name: column.numbers for name, column in columns.items()}
    held = {name: values for name, values in fields.items() if not np.isnan(doubles(values)).all()}
    units = {name: unit for name, unit in stated.items() if name in columns and unit}
    units |= {name: column.unit for name, column in columns.items() if column.unit is not None}
    return Content(streams={TABLE: Stream(fields=held, units=units)}, unused=tuple(unused), damage=(*damage, *words))


def _numbers(values: pa.Array, column: _Column, *, decimal_comma: bool) -> Numbers | None:
    """Return a column's numbers, integers kept where all are; None where it can hold none. Words are counted."""
    if pa.types.is_dictionary(values.type):
        values = values.dictionary_decode()
    if pa.types.is_timestamp(values.type):
        column.unit = "ns"
        return _from_arrow(values.cast(pa.timestamp("ns")).cast(pa.int64()))
    if pa.types.is_string(values.type) or pa.types.is_large_string(values.type):
        return _from_text(values, column, decimal_comma=decimal_comma)
    try:
        return _from_arrow(values if pa.types.is_integer(values.type) else values.cast(pa.float64()))
    except pa.ArrowException:
        return None


def _from_text(texts: pa.Array, column: _Column, *, decimal_comma: bool) -> Numbers:
    trimmed = pc.utf8_trim_whitespace(texts)
    trimmed = pc.if_else(pc.equal(trimmed, ""), None, trimmed)
    if decimal_comma:
        trimmed = pc.replace_substring(trimmed, ",", ".")
    for kind in (pa.int64(), pa.float64()):
        try:
            return _from_arrow(trimmed.cast(kind))
        except pa.ArrowException:
            continue
    for zone in (None, "UTC"):  # without an offset from UTC, or with one
        try:
            stamps = _from_arrow(trimmed.cast(pa.timestamp("ns", zone)).cast(pa.int64()))
        except pa.ArrowException:
            continue
        column.unit = "ns"
        return stamps
    if pc.all(pc.match_substring_regex(trimmed, _TIME_OF_DAY)).as_py():
        column.unit, column.of_day = "ns", True
        padded = pc.replace_substring_regex(trimmed, r"^(\d):", r"0\1:")
        stamps = pc.binary_join_element_wise(_ANY_DAY, padded, "T").cast(pa.timestamp("ns"))
        return _from_arrow(stamps.cast(pa.int64()))
    return _cell_by_cell(trimmed, column)


def _over_midnight(values: Numbers) -> Numbers:
    """Return times of day, ns, that go on where a day ends: one that falls by more than half a day is of the next."""
    known = np.isfinite(values)
    turned = values.copy()
    turned[known] = np.unwrap(values[known], period=_DAY)
    return turned


def _cell_by_cell(texts: pa.Array, column: _Column) -> Numbers:
    """Return the numbers of a column that holds words too, which are counted."""
    numbers = np.full(len(texts), np.nan)
    for row, cell in enumerate(texts.to_pylist()):
        if cell is not None:
            try:
                numbers[row] = float(cell)
            except ValueError:
                column.first_word = column.first_word or cell[:40]
                column.words += 1
    return numbers


def _from_arrow(values: pa.Array) -> Numbers:
    """Return numbers; floating point with NaN where some are missing, as pyarrow has it."""
    return np.array(values.to_numpy(zero_copy_only=False))
