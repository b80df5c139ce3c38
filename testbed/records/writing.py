"""Records to files, whole or not at all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from testbed.errors import InputError, OutputError
from testbed.files import whole_file
from testbed.records.details import details_text
from testbed.records.record import Record
from testbed.records.tables import SUFFIXES
from testbed.signals import SIGNALS


def write_record(record: Record, destination: Path) -> Path:
    """Write a run, with NAME.toml beside it where there is something to say in it.

    Every file is written under another name first and then renamed, so that no half-written file bears its name.

    Args:
        record: the run.
        destination: a file that ends in .parquet (bit for bit) or .csv (NaN as an empty field), or else a folder, in
            which the run's name becomes NAME.parquet.

    Returns:
        The file with the table.

    Raises:
        InputError: the run's name cannot be a file name.
        OutputError: the folder cannot be written to.
    """
    path = table_path(record, destination)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part:
            _write_table(record, part, path.suffix)
            # Before the table gets its name: no reader meets a run whose details are still missing.
            _write_details(path.with_suffix(".toml"), details_text(record.details, path.stem))
    except OSError as error:
        raise OutputError(
            f"{path}: cannot be written ({error.strerror}); make room or choose another folder"
        ) from error
    return path


def table_path(record: Record, destination: Path) -> Path:
    """Return the file of a run: the destination itself, or the run's NAME.parquet in it; as `write_record`."""
    if destination.suffix in SUFFIXES:
        return destination
    name = record.details.name
    if name.startswith(".") or Path(name).name != name or "\0" in name:
        raise InputError(f"{destination}: the run's name {name!r} cannot be a file name; give a file, not a folder")
    return destination / f"{name}.parquet"


def _write_details(path: Path, text: str) -> None:
    if not text:
        path.unlink(missing_ok=True)  # what an earlier run of this name said
        return
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


def _write_table(record: Record, part: Path, suffix: str) -> None:
    if suffix == ".csv":
        pa.csv.write_csv(table_of(record, nan_is_empty=True), part)
    else:
        pa.parquet.write_table(table_of(record), part, compression="zstd")


def table_of(record: Record, *, nan_is_empty: bool = False) -> pa.Table:
    """Return a run as a table, a column for each component of its channels.

    Args:
        record: the run.
        nan_is_empty: whether a field that was not sampled is null, instead of NaN.
    """
    columns = {"time_s": record.time}
    for name, signal in SIGNALS.items():
        if name in record.channels:
            values = record.channels[name].T
            columns |= dict(zip(signal.sized(len(values)).columns, values, strict=True))
    columns |= record.extra_columns
    # Arrow takes contiguous columns only.
    return pa.table(
        {name: pa.array(np.ascontiguousarray(column), from_pandas=nan_is_empty) for name, column in columns.items()}
    )
