"""Measured records: from a folder, or from tables that a program already holds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from testbed.errors import InputError
from testbed.files import FileStamp
from testbed.library.notebook import Shown
from testbed.logs.export import write_mcap
from testbed.records.reading import read_data_set, record_of
from testbed.records.record import Record, RunDetails
from testbed.records.tables import NUMERIC_COLUMNS
from testbed.records.writing import table_of, table_path, write_record

if TYPE_CHECKING:
    import pandas as pd

Columns = Mapping[str, ArrayLike]
"""A run: a column for each name of docs/reference/records.md, and `time_s`. A pandas data frame is one."""


@dataclass(frozen=True, eq=False, repr=False)
class Records(Shown):
    """Runs of one platform.

    Of runs with the same name, such as flights of one scenario, the second becomes NAME-2, the third NAME-3, and so on.

    Attributes:
        runs: in order, every name once.
    """

    runs: tuple[Record, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "runs", tuple(_named_apart(self.runs)))

    def __iter__(self) -> Iterator[Record]:
        return iter(self.runs)

    def __len__(self) -> int:
        return len(self.runs)

    def __getitem__(self, name: str) -> Record:
        """Return the run of a name.

        Raises:
            KeyError: there is none; the message lists the names.
        """
        by_name = {record.details.name: record for record in self.runs}
        if name not in by_name:
            raise KeyError(f"{name}; the runs are {', '.join(by_name)}")
        return by_name[name]

    def __str__(self) -> str:
        return "\n".join([f"{len(self.runs)} run{'s' * (len(self.runs) != 1)}", *map(repr, self.runs)])

    def to_pandas(self) -> pd.DataFrame:
        """Return all runs as one table with a column `run`."""
        import pandas as pd  # noqa: PLC0415 - an optional extra

        return pd.concat([frame_of(record).assign(run=record.details.name) for record in self.runs], ignore_index=True)

    def save(self, folder: str | Path, *, format: Literal["parquet", "mcap"] = "parquet") -> Path:  # noqa: A002
        """Write the runs into a folder, a file each, from which they can be read again.

        A file of a run's name that is there already is replaced.

        Args:
            folder: made where it is missing.
            format: NAME.parquet each; or NAME.mcap, with NAME.map.toml, with which `import_log` reads it again.

        Raises:
            InputError: a name can be no file's, there is no such format, the folder cannot be written, or the extra
                `testbed[logs]` is missing.
        """
        if format not in ("parquet", "mcap"):
            raise InputError(f"format = {format!r}: give 'parquet' or 'mcap'")
        for record in self.runs:
            path = table_path(record, Path(folder))
            if format == "mcap":
                write_mcap(record, path.with_suffix(".mcap"))
            else:
                write_record(record, path)
        return Path(folder)


def _named_apart(runs: Sequence[Record]) -> Iterator[Record]:
    """Yield the runs, numbered from the second on where they share a name: no file is written twice."""
    taken = {record.details.name for record in runs}
    seen: set[str] = set()
    for record in runs:
        name = record.details.name
        if name in seen:
            name = next(each for number in count(2) if (each := f"{name}-{number}") not in taken)
            record = replace(record, details=replace(record.details, name=name))  # noqa: PLW2901
        seen.add(name)
        taken.add(name)
        yield record


def read_records(folder: str | Path) -> Records:
    """Read every run of a folder: NAME.csv or NAME.parquet, with an optional NAME.toml beside it.

    Raises:
        InputError: there is no run, or some cannot be used; all of these are named, with column, row and remedy.

    Example:
        >>> import tempfile, testbed as tb
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = tb.Records((tb.fly(tb.read_scenario("basic")).record,)).save(folder)
        ...     len(tb.read_records(folder))
        1
    """
    return Records(read_data_set(Path(folder)))


def records_from(
    tables: Columns | Mapping[str, Columns],
    *,
    source: Literal["measured", "simulated"] = "measured",
    gyro_noise_rad_s: float | None = None,
) -> Records:
    """Return runs from tables that a program already holds.

    Args:
        tables: one run, or runs by name. A run is a data frame or a mapping with the columns of a record, SI: `time_s`,
            `body_rate_x_rad_s` and so on; NaN where a channel was not sampled. Other columns are kept and not used.
        source: whether a platform or a simulation sent them.
        gyro_noise_rad_s: standard deviation of a sample of the gyro; estimated from the samples where None.

    Raises:
        InputError: a run cannot be used; the message names column, row and remedy.

    Example:
        >>> import testbed as tb
        >>> flown = tb.fly(tb.read_scenario("basic")).record
        >>> table = tb.frame_of(flown)
        >>> tb.records_from({"flight 1": table, "flight 2": table}).runs[1].details.name
        'flight 2'
    """
    return Records(
        tuple(
            record_of(
                _numbers(str(name), table),
                _details(str(name), source, gyro_noise_rad_s),
                {column: np.asarray(table[column]) for column in table if column not in NUMERIC_COLUMNS},
            )
            for name, table in _by_name(tables).items()
        )
    )


def _details(name: str, source: Literal["measured", "simulated"], gyro_noise: float | None) -> RunDetails:
    if not name:
        raise InputError("a run's name is empty: give each table one that says which flight it is")
    return RunDetails(name=name, source=source, gyro_noise=gyro_noise)


def _by_name(tables: Columns | Mapping[str, Columns]) -> Mapping[str, Columns]:
    one = _is_table(tables) and (hasattr(tables, "columns") or "time_s" in tables)
    named: Any = {"run": tables} if one else tables
    if not isinstance(named, Mapping) or not named or not all(map(_is_table, named.values())):
        raise InputError(
            "there is no run: give a table with the column time_s, or several by name, such as {'flight 1': table}"
        )
    return named


def _is_table(given: object) -> bool:
    """Return whether something is a data frame, or columns by name."""
    return hasattr(given, "columns") or isinstance(given, Mapping)


def frame_of(record: Record) -> pd.DataFrame:
    """Return a run as a pandas data frame, with the columns that `records_from` takes."""
    return table_of(record).to_pandas()


def _numbers(name: str, table: Columns) -> dict[str, Any]:
    try:
        return {column: np.asarray(table[column], dtype=np.float64) for column in table if column in NUMERIC_COLUMNS}
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: holds what is no number ({error})") from error


def stamps_of(records: Records) -> list[FileStamp]:
    """Return the files that records were read from; none of tables that a program held.

    Raises:
        InputError: these are no records.
    """
    if not isinstance(records, Records):
        raise InputError(
            f"{type(records).__name__}: is no Records; give tb.records_from(tables) or tb.read_records(folder)"
        )
    return [stamp for record in records for stamp in record.files]
