"""Tables on disk, CSV or Parquet: read in batches, their numbers taken out, their bytes hashed on the way."""

from __future__ import annotations

import codecs
import csv
import hashlib
import io
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.csv
import pyarrow.parquet
from numpy.typing import NDArray

from testbed.arrays import Series
from testbed.errors import InputError
from testbed.files import FileStamp, open_regular, readable
from testbed.records.checks import column_problems, refuse
from testbed.signals import MOST_UNITS, SIGNALS

SUFFIXES = (".csv", ".parquet")
"""File name endings of the tables that records are kept in."""

NUMERIC_COLUMNS = frozenset(
    ("time_s", *(column for signal in SIGNALS.values() for column in signal.sized(MOST_UNITS).columns))
)
"""Columns that have to hold numbers."""

MOST_VALUES = 60_000_000
"""Values of a record, 0.5 GB: 2 million rows of 30 columns, or 6 million of gyro and gimbals."""
_BATCH = 65_536
"""Rows of a Parquet file that are taken at once."""
_BLOCK = 2**23
"""Bytes of a CSV file that are taken at once."""
_LONGEST_HEADER = 2**20
"""Bytes; the names of a thousand columns take a tenth of it."""
_MOST_FAULTY = 1000
"""Rows of another length than the header beyond which the rest of the file is not looked at."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """What a table holds.

    Attributes:
        numbers: columns of signals and time, by name, shape (N,); NaN where a field is empty.
        others: all other columns, by name, shape (N,), of any type.
        stamp: of the bytes that were read.
    """

    numbers: dict[str, Series]
    others: Mapping[str, NDArray[Any]]
    stamp: FileStamp


def read_table(path: Path) -> Table:
    """Read a table.

    Raises:
        InputError: the file is missing or unreadable, is no table of the kind that its name promises, has columns
            that no record has, cells that are no numbers, or more values than fit.
    """
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise InputError(f"{path}: a record is a file that ends in {' or '.join(SUFFIXES)}")
    try:
        with open_regular(path) as file:
            return _read_csv(path, file) if kind == ".csv" else _read_parquet(path, file)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; give a file in it, or a folder of records") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read as {kind[1:]}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: cannot be read as csv: it is not UTF-8 (byte 0x{error.object[error.start]:02x}); save it as UTF-8"
        ) from None
    except (pa.ArrowException, csv.Error) as error:
        raise InputError(
            f"{path}: cannot be read as {kind[1:]}: {error}; write it anew, or give the copy that it was made from"
        ) from error


def _read_parquet(path: Path, file: io.BufferedReader) -> Table:
    digest = hashlib.file_digest(file, "sha256")
    file.seek(0)
    with pa.parquet.ParquetFile(file) as parquet:
        names = parquet.schema_arrow.names
        refuse(path, column_problems(names))
        _require_room(path, parquet.metadata.num_rows, len(names))
        numbers, others = _collected(path, names, parquet.iter_batches(_BATCH))
        return Table(numbers=numbers, others=others, stamp=_stamp(path, file, digest.hexdigest()))


def _read_csv(path: Path, file: io.BufferedReader) -> Table:
    names = _csv_header(path, file)
    refuse(path, column_problems(names))
    watched, ragged = _Watched(file), list[str]()

    def note(row: pa.csv.InvalidRow) -> str:
        ragged.append(f"row {row.number - 1} has {row.actual_columns} fields, the header {row.expected_columns}")
        return "skip" if len(ragged) < _MOST_FAULTY else "error"

    batches = pa.csv.open_csv(
        pa.PythonFile(watched, mode="r"),
        read_options=pa.csv.ReadOptions(use_threads=False, block_size=_BLOCK),  # threads would not number the rows
        parse_options=pa.csv.ParseOptions(invalid_row_handler=note),
        # As text, so that a cell that is no number can be named.
        convert_options=pa.csv.ConvertOptions(
            column_types=dict.fromkeys(names, pa.string()), null_values=[""], strings_can_be_null=True
        ),
    )
    try:
        numbers, others = _collected(path, names, batches)
    finally:
        refuse(path, ragged)
    return Table(numbers=numbers, others=others, stamp=_stamp(path, file, watched.digest.hexdigest()))


def _csv_header(path: Path, file: io.BufferedReader) -> list[str]:
    """Return the column names of a CSV file, and go back to its beginning.

    Raises:
        InputError: there are none, or they are separated by something else than commas.
    """
    line = file.readline(_LONGEST_HEADER).decode("utf-8-sig")
    file.seek(0)
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if separator in line and "," not in line:
            raise InputError(
                f"{path}: is separated by {word}, not by commas: save it with commas, and decimals with a point"
            )
    if not line.strip():
        raise InputError(f"{path}: cannot be read as csv: its first line is empty, where the names of columns belong")
    return next(csv.reader([line]))


class _Watched(io.RawIOBase):
    """A file that is hashed, and has to be UTF-8, as it is read: Arrow decodes in places that cannot tell the fault."""

    def __init__(self, file: io.BufferedReader) -> None:
        """Watch a file from where it is."""
        self._file = file
        self._decoder = codecs.getincrementaldecoder("utf-8")()
        self.digest = hashlib.sha256()

    def readable(self) -> bool:
        """Return that it can be read."""
        return True

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes."""
        content = self._file.read(size)
        self.digest.update(content)
        self._decoder.decode(content, final=not content)
        return content


def _stamp(path: Path, file: io.BufferedReader, sha256: str) -> FileStamp:
    return FileStamp(path=readable(str(path)), sha256=sha256, size=os.fstat(file.fileno()).st_size)


def _collected(
    path: Path, names: Sequence[str], batches: Iterable[pa.RecordBatch]
) -> tuple[dict[str, Series], Mapping[str, NDArray[Any]]]:
    """Return the numbers of batches, and their other columns."""
    rows = 0
    parts: dict[str, list[Series]] = {name: [] for name in names if name in NUMERIC_COLUMNS}
    others: dict[str, list[pa.Array]] = {name: [] for name in names if name not in NUMERIC_COLUMNS}
    faults: dict[str, str] = {}
    for batch in batches:
        for name in parts.keys() - faults.keys():
            values = _numbers(batch.column(name), rows)
            if isinstance(values, str):
                faults[name] = values
            else:
                parts[name].append(values)
        for name, chunks in others.items():
            chunks.append(batch.column(name))
        rows += batch.num_rows
        _require_room(path, rows, len(names))
    refuse(path, [f"column {name} {faults[name]}" for name in parts if name in faults])
    numbers = {name: np.concatenate([*parts.pop(name), np.zeros(0)]) for name in list(parts)}
    return numbers, {name: _as_it_is(chunks) for name, chunks in others.items()}


def _require_room(path: Path, rows: int, columns: int) -> None:
    if rows * columns > MOST_VALUES:
        raise InputError(
            f"{path}: holds {rows:,} rows or more of {columns} columns; at most {MOST_VALUES // columns:,} rows are "
            f"read of so many ({MOST_VALUES:,} values): average it down, or split it into several runs"
        )


def _numbers(column: pa.Array, before: int) -> Series | str:
    """Return a column's numbers, NaN where it has none; or what is wrong with it, its name left out.

    Args:
        column: of a batch.
        before: rows of the table before the batch.
    """
    if pa.types.is_boolean(column.type):
        return "holds true and false, not numbers"  # a cast would make them one and zero
    try:
        return np.array(_without_blanks(column).cast(pa.float64()).to_numpy(zero_copy_only=False))
    except pa.ArrowException:
        return _first_fault(column, before)


def _without_blanks(column: pa.Array) -> pa.Array:
    if not _is_text(column):
        return column
    trimmed = pa.compute.utf8_trim_whitespace(column)
    return pa.compute.if_else(pa.compute.equal(trimmed, ""), None, trimmed)


def _first_fault(column: pa.Array, before: int) -> str:
    if not _is_text(column):
        return f"holds {column.type}, not numbers"
    cells = enumerate(_without_blanks(column).to_pylist(), start=before + 1)
    row, cell = next((row, cell) for row, cell in cells if cell is not None and not _is_number(cell))
    return f"is {cell!r} in row {row}, not a number: correct it, or leave the field empty where nothing was sampled"


def _as_it_is(chunks: Sequence[pa.Array]) -> NDArray[Any]:
    """Return a column that no signal has: numbers where all of a text are, else what it is."""
    column = pa.chunked_array(chunks) if chunks else pa.chunked_array([], pa.string())
    for kind in (pa.int64(), pa.float64()) if _is_text(column) else ():
        try:
            return np.asarray(column.cast(kind).to_numpy())
        except pa.ArrowException:
            continue
    return np.asarray(column.to_numpy())


def _is_text(column: pa.Array | pa.ChunkedArray) -> bool:
    return bool(pa.types.is_string(column.type) or pa.types.is_large_string(column.type))


def _is_number(cell: str) -> bool:
    try:
        pa.scalar(cell).cast(pa.float64())
    except pa.ArrowException:
        return False
    return True
