"""Records from files: one run, or a folder of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Series
from testbed.errors import InputError, made_of_each
from testbed.files import readable, require_folder
from testbed.records.checks import column_problems, refuse, value_problems
from testbed.records.details import details_file, details_of
from testbed.records.record import Record, RunDetails
from testbed.records.tables import SUFFIXES, read_table
from testbed.signals import present_signals


def read_record(path: Path) -> Record:
    """Read a run from NAME.csv or NAME.parquet, and NAME.toml beside it if there is one.

    Raises:
        InputError: a file cannot be read, or the run in it cannot be used; the message names file, column, row, remedy.
    """
    table = read_table(path)
    time, channels = _checked(path, table.numbers)
    file = details_file(path.with_suffix(".toml"))
    return Record(
        time=time,
        channels=channels,
        details=RunDetails(name=readable(path.stem)) if file is None else details_of(file),
        files=(table.stamp,) if file is None else (table.stamp, file.stamp),
        extra_columns=table.others,
    )


def record_of(numbers: dict[str, Series], details: RunDetails, extra_columns: Mapping[str, NDArray[Any]]) -> Record:
    """Return a run from columns that a program already holds.

    Args:
        numbers: of time and signals, by column name, shape (N,) each; NaN where a channel was not sampled.
        details: what is known of the run as a whole.
        extra_columns: that no signal has, by name, shape (N,).

    Raises:
        InputError: the run cannot be used; the message names the run, column, row and remedy.
    """
    place = Path(details.name)
    refuse(place, column_problems([*numbers, *extra_columns]))
    lengths = {len(column) for column in (*numbers.values(), *extra_columns.values())}
    if len(lengths) > 1:
        raise InputError(f"{place}: its columns differ in length ({', '.join(map(str, sorted(lengths)))} rows)")
    time, channels = _checked(place, numbers)
    return Record(time=time, channels=channels, details=details, extra_columns=extra_columns)


def _checked(path: Path, numbers: dict[str, Series]) -> tuple[Series, dict[str, Array]]:
    time, channels = numbers["time_s"], _channels(numbers)
    refuse(path, value_problems(time, channels))
    return time, channels


def read_data_set(folder: Path) -> tuple[Record, ...]:
    """Read every run in a folder, in the order of their file names; other files are passed over.

    Raises:
        InputError: there is no run, two have the same name, or some cannot be used; all of these are named.
    """
    paths = _run_paths(folder)
    records = tuple(made_of_each(read_record, paths))
    _refuse_repeated(folder, (record.details.name for record in records), "name them differently in their .toml files")
    return records


def extra_columns_notice(record: Record) -> str | None:
    """Return what to tell the user of columns that no signal bears; None where there are none."""
    if not record.extra_columns:
        return None
    return f"{record.details.name}: kept, but not used: {', '.join(record.extra_columns)}"


def _run_paths(folder: Path) -> list[Path]:
    if folder.is_file():
        raise InputError(f"{folder}: is a file; name the folder that it is in")
    require_folder(folder)
    files = [path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and not path.name.startswith(".")]
    if not files:
        raise InputError(f"{folder}: there is no run in this folder: no file ends in {' or '.join(SUFFIXES)}")
    _refuse_repeated(folder, (path.stem for path in files), "keep one file of each run")
    return sorted(files, key=lambda path: path.stem)


def _refuse_repeated(folder: Path, names: Iterable[str], remedy: str) -> None:
    repeated = [name for name, count in Counter(names).items() if count > 1]
    refuse(folder, [f"more than one run is called {name}: {remedy}" for name in sorted(repeated)])


def _channels(columns: dict[str, Series]) -> dict[str, Array]:
    """Return the channels of columns, each of which is let go of as soon as it is in its channel."""
    present = list(present_signals(columns))
    return {signal.name: np.column_stack([columns.pop(name) for name in signal.columns]) for signal in present}
