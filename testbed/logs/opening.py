"""Which format a log is in, by its first bytes."""

from __future__ import annotations

import codecs
from pathlib import Path

from testbed.errors import InputError
from testbed.files import open_regular
from testbed.logs import mcap, rosbag, tables, ulog
from testbed.logs.streams import Log

FORMATS = "ULog, MCAP, ROS bag, CSV or Parquet"
_HEAD = 1024
"""Bytes that are looked at; random ones without a control character among so many come once in 10^50 files."""
_CONTROLS = frozenset(range(32)) - frozenset(b"\t\n\v\f\r\x1a\x1b")
"""Bytes that stand in no text, whatever its encoding: tables of UTF-8 and Latin-1 are read."""
_NAMED = {".ulg": "ULog", ".mcap": "MCAP", ".bag": "ROS 1 bag", ".db3": "ROS 2 bag", ".parquet": "Parquet"}
"""Formats by the end of a file's name; its first bytes decide, the name says what somebody took it for."""


def opened(path: Path) -> Log:
    """Return the log at a path.

    Raises:
        InputError: there is none, or it cannot be read.
    """
    if path.is_dir():
        return rosbag.Rosbag(path)
    try:
        with open_regular(path) as file:
            magic = file.read(_HEAD)
    except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{path}: cannot be read ({reason}); give the path of a log: {FORMATS}") from None
    if magic.startswith(ulog.MAGIC):
        return ulog.ULog(path)
    if magic.startswith(mcap.MAGIC):
        return mcap.Mcap(path)
    if magic.startswith(rosbag.MAGICS):
        return rosbag.Rosbag(path)
    if magic.startswith(tables.PARQUET_MAGIC):
        return tables.ParquetTable(path)
    if not magic:
        raise InputError(f"{path}: is empty; give the path of a log: {FORMATS}")
    if magic.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(f"{path}: is UTF-16 text, as of a spreadsheet's Unicode export; save it as CSV in UTF-8")
    if magic.lstrip().startswith((b"{", b"[")):
        raise InputError(f"{path}: is JSON, which is not read; write a table of it, such as CSV or Parquet: {FORMATS}")
    if not _CONTROLS.isdisjoint(magic):
        raise InputError(f"{path}: {_no_log(path)}")
    return tables.CsvTable(path)


def _no_log(path: Path) -> str:
    """Return what is wrong with a file that is neither text nor begins as any format does, and what to do."""
    named = _NAMED.get(path.suffix.lower())
    if named is None:
        return f"is in none of the formats that are read: {FORMATS}"
    return (
        f"its name says {named}, but its content does not begin as one: it is damaged, or of another kind; copy it "
        f"again from where it was logged, or give another log: {FORMATS}"
    )
