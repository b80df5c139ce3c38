"""The folder of an imported log: a data set, and how it came about."""

from __future__ import annotations

from pathlib import Path

from testbed.files import TextFile, write_json
from testbed.logs.convert import Imported
from testbed.outputs.provenance import Provenance
from testbed.records.writing import write_record


def write_import(folder: Path, file: TextFile, origin: Provenance, imported: Imported) -> None:
    """Write a data set, NAME.parquet for each run, and provenance.json: log, map, what was converted and left out.

    Args:
        folder: to write into.
        file: the map as it was read.
        origin: what made the records; the log is among its inputs.
        imported: the records.

    Raises:
        OSError: the folder cannot be written.
    """
    for record in imported.records:
        write_record(record, folder)
    write_json(folder / "provenance.json", {**origin.content, **imported.content, "map": file.text})
