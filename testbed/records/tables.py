"""Tables on disk, CSV or Parquet, and the numbers in their columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.csv
import pyarrow.parquet

from testbed.arrays import Series
from testbed.errors import InputError
from testbed.records.checks import refuse
from testbed.signals import SIGNALS

SUFFIXES = (".csv", ".parquet")
"""File name endings of the tables that records are kept in."""

NUMERIC_COLUMNS = ("time_s", *(column for signal in SIGNALS.values() for column in signal.columns))
"""Columns that have to hold numbers."""


def read_table(path: Path) -> pa.Table:
    """Read a table as it is, numeric columns of a CSV file as text.

    Raises:
        InputError: the file is missing or unreadable, or is no table of the kind that its name promises.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: a record is a file that ends in {' or '.join(SUFFIXES)}")
    if not path.is_file():
        raise InputError(f"{path}: there is no such file")
    try:
        return _read_csv(path) if path.suffix.lower() == ".csv" else _read_parquet(path)
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as {path.suffix.lower()[1:]}: {error}") from error


def column_numbers(column: pa.ChunkedArray) -> Series | str:
    """Return a column's numbers, NaN where it has none; or what is wrong with it, its name left out."""
    try:
        return np.array(_without_blanks(column).cast(pa.float64()).to_numpy())
    except pa.ArrowException:
        return _first_fault(column)


def _read_parquet(path: Path) -> pa.Table:
    with pa.parquet.ParquetFile(path) as file:
        return file.read()


def _read_csv(path: Path) -> pa.Table:
    content = path.read_bytes()
    content.decode("utf-8")  # all of it here, where the fault can be told; Arrow decodes in places that cannot
    ragged: list[str] = []

    def note(row: pa.csv.InvalidRow) -> str:
        ragged.append(f"row {row.number - 1} has {row.actual_columns} fields, the header {row.expected_columns}")
        return "skip"

    table = pa.csv.read_csv(
        pa.BufferReader(content),
        read_options=pa.csv.ReadOptions(use_threads=False),  # rows are numbered only without threads
        parse_options=pa.csv.ParseOptions(invalid_row_handler=note),
        # As text, so that a cell that is no number can be named.
        convert_options=pa.csv.ConvertOptions(
            column_types=dict.fromkeys(NUMERIC_COLUMNS, pa.string()), null_values=[""], strings_can_be_null=True
        ),
    )
    refuse(path, ragged)
    return table


def _without_blanks(column: pa.ChunkedArray) -> pa.ChunkedArray:
    if not _is_text(column):
        return column
    trimmed = pa.compute.utf8_trim_whitespace(column)
    return pa.compute.if_else(pa.compute.equal(trimmed, ""), None, trimmed)


def _first_fault(column: pa.ChunkedArray) -> str:
    if not _is_text(column):
        return f"holds {column.type}, not numbers"
    cells = enumerate(_without_blanks(column).to_pylist(), start=1)
    row, cell = next((row, cell) for row, cell in cells if cell is not None and not _is_number(cell))
    return f"is {cell!r} in row {row}, not a number: correct it, or leave the field empty where nothing was sampled"


def _is_text(column: pa.ChunkedArray) -> bool:
    return bool(pa.types.is_string(column.type) or pa.types.is_large_string(column.type))


def _is_number(cell: str) -> bool:
    try:
        pa.scalar(cell).cast(pa.float64())
    except pa.ArrowException:
        return False
    return True
