"""What every reader of a log gives: topics, each with its own times and named numbers."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BufferedReader
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array
from testbed.errors import InputError
from testbed.files import FileStamp, stamped

Numbers: TypeAlias = NDArray[Any]
"""Shape (N,); integers or floating point, as the log has them."""
Wanted: TypeAlias = Mapping[str, Collection[str]]
"""Fields by topic."""

TABLE = ""
"""Topic of a table, which has no other."""
MOST_VALUES = 10_000_000
"""Values that are taken from a log at once: 0.08 GB here, 0.6 to 0.8 GB with the records that are made of them."""


def doubles(values: Numbers) -> Array:
    """Return numbers of a log as double precision; a signalling NaN, as damaged bytes may be one, as a quiet one."""
    with np.errstate(invalid="ignore"):
        return np.asarray(values, dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class Stream:
    """The samples of one topic.

    Attributes:
        fields: what was wanted of it, by name, shape (N,); NaN where a message holds no number there.
        units: of those fields whose unit the format itself states, such as clocks.
        received: time at which the log took each message, integer ticks, shape (N,); None where the format has none.
        received_unit: of those ticks.
    """

    fields: Mapping[str, Numbers]
    units: Mapping[str, str] = field(default_factory=dict)
    received: Numbers | None = None
    received_unit: str = "ns"


@dataclass(frozen=True, kw_only=True)
class Content:
    """What was read of a log.

    Attributes:
        streams: by topic, of those topics that the log holds.
        unused: topics, or columns of a table, that were not wanted.
        damage: what could not be read, in sentences.
    """

    streams: Mapping[str, Stream]
    unused: tuple[str, ...]
    damage: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Topic:
    """What a topic offers.

    Attributes:
        kind: name of its messages' type; empty where there is none.
        fields: its numbers by name, each with the first value.
        units: of fields whose unit the format states.
        received: whether the log has a time of its own for each message.
        empty: fields that it has without a single number.
    """

    kind: str
    fields: Mapping[str, float]
    units: Mapping[str, str] = field(default_factory=dict)
    received: bool = True
    empty: Collection[str] = ()


@dataclass(frozen=True)
class Log(ABC):
    """A log that can be read.

    Attributes:
        path: of its file or folder.
        format: what people call the format: ULog, MCAP and so on.
    """

    path: Path
    format: ClassVar[str]

    def stamps(self) -> tuple[FileStamp, ...]:
        """Return what names the log's files.

        Raises:
            InputError: they cannot be read.
        """
        return (stamped(self.path, f"a log ({self.format})"),)

    @abstractmethod
    def survey(self) -> Mapping[str, Topic]:
        """Return what the log offers, by topic.

        Raises:
            InputError: it cannot be read.
        """

    @abstractmethod
    def read(self, wanted: Wanted) -> Content:
        """Read fields of topics; what the log does not hold is left out.

        Raises:
            InputError: it cannot be read, or holds more than fits.
        """


class Room:
    """Counts what is read, and refuses what would fill the memory."""

    def __init__(self, path: Path) -> None:
        """Begin at nothing."""
        self._path, self._values = path, 0

    def take(self, values: int) -> None:
        """Count values.

        Raises:
            InputError: there are too many.
        """
        self._values += values
        if self._values > MOST_VALUES:
            raise InputError(
                f"{self._path}: holds more than the {MOST_VALUES:,} values that are read at once of what the map "
                "names: split the log, or leave channels out of the map"
            )


@contextmanager
def parsing(path: Path, kind: str) -> Iterator[None]:
    """Say of which file it is that a parser failed on; of damaged bytes, parsers raise whatever comes.

    Raises:
        InputError: the parser failed.
    """
    try:
        yield
    except (InputError, MemoryError, KeyboardInterrupt):
        raise
    except Exception as error:
        reason = str(error).strip() or type(error).__name__
        raise InputError(f"{path}: cannot be read as {kind}: {reason}") from error


class WholeReads:
    """A file that gives all the bytes that a parser asks for, or none and remembers that the file is cut."""

    def __init__(self, file: BufferedReader, most: int | None = None) -> None:
        """Watch a file from where it is.

        Args:
            file: open for reading.
            most: bytes after which the file appears to end; None for all.
        """
        size = os.fstat(file.fileno()).st_size
        self._file, self._end = file, size if most is None else min(size, most)
        self._whole = self._end == size
        self.seek, self.tell, self.close = file.seek, file.tell, file.close
        self.cut = False

    def read(self, size: int) -> bytes:
        """Return the next bytes, all or none; a damaged length may ask for more than any memory holds."""
        left = self._end - self._file.tell()
        if size > left:
            self.cut = self.cut or (self._whole and left > 0)
            return b""
        return self._file.read(size)
