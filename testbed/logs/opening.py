"""Which format a log is in, by its first bytes."""

from __future__ import annotations

from pathlib import Path

from testbed.errors import InputError
from testbed.files import open_regular
from testbed.logs import mcap, rosbag, tables, ulog
from testbed.logs.streams import Log

FORMATS = "ULog, MCAP, ROS bag, CSV or Parquet"
_LONGEST_MAGIC = 16


def opened(path: Path) -> Log:
    """Return the log at a path.

    Raises:
        InputError: there is none, or it cannot be read.
    """
    if path.is_dir():
        return rosbag.Rosbag(path)
    try:
        with open_regular(path) as file:
            magic = file.read(_LONGEST_MAGIC)
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
    if not magic or b"\0" in magic:
        raise InputError(f"{path}: is {'empty' if not magic else 'in none of the formats that are read'}: {FORMATS}")
    return tables.CsvTable(path)
