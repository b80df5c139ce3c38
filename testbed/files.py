"""Files: read once and known by their hash, written whole or not at all, folders with one writer."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import stat
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from io import BufferedReader
from pathlib import Path
from typing import Any

from testbed.errors import InputError

_MEGABYTE = 1e6
DEEPEST = 50
"""Tables and lists within each other; a scenario has four."""


class FolderBusyError(Exception):
    """Another process writes to the folder."""


@dataclass(frozen=True, kw_only=True)
class FileStamp:
    """Identity of an input file in a result: path, hash, size.

    Attributes:
        path: as the user gave it, readable.
        sha256: of its content, in hexadecimal.
        size: bytes.
    """

    path: str
    sha256: str
    size: int


@dataclass(frozen=True, kw_only=True)
class TextFile:
    """A text file as it was when it was read; what is stored and hashed of it later is this.

    Attributes:
        path: of the file.
        content: all of it.
        text: the content as UTF-8, less the byte order mark with which some editors begin a file.
        changes: keys that were given other values after reading, as text; the lines of `text` are then not the file's.
    """

    path: Path
    content: bytes
    text: str
    changes: str = ""

    @cached_property
    def stamp(self) -> FileStamp:
        """Path, hash and size."""
        return FileStamp(
            path=readable(str(self.path)), sha256=hashlib.sha256(self.content).hexdigest(), size=len(self.content)
        )


def readable(name: str) -> str:
    """Return the name of a file, or an argument of the command, as text that any file can hold.

    Python keeps its bytes where the locale does not know them; most are UTF-8 all the same, others become escapes.
    """
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")


def read_text(path: Path, what: str, most: int) -> TextFile:
    """Read a text file at once.

    Args:
        path: of the file.
        what: the file should be, for the message: "a scenario file".
        most: bytes that are read; a larger file is refused.

    Raises:
        InputError: there is no regular file, it is too large, cannot be read, or is not UTF-8 text.
    """
    content = read_bytes(path, what, most)
    try:
        return TextFile(path=path, content=content, text=content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None


def read_bytes(path: Path, what: str, most: int) -> bytes:
    """Read a file at once; as `read_text`, for any content."""
    try:
        with open_regular(path) as file:
            content = file.read(most + 1)
    except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{path}: cannot be read ({reason}); give the path of {what}") from None
    if len(content) > most:
        raise InputError(f"{path}: is larger than the {most / _MEGABYTE:g} MB that are read of {what}")
    return content


def parsed_toml(file: TextFile) -> dict[str, Any]:
    """Return what a TOML file holds.

    Raises:
        InputError: it is not TOML, or nests deeper than any file a person writes.
    """
    try:
        tree = tomllib.loads(file.text)
        _require_shallow(tree)
    except ValueError as error:  # tomllib's own, or Python's of an integer of thousands of digits
        raise InputError(f"{file.path}: is not TOML: {error}; mend the file there") from None
    except RecursionError:
        raise InputError(f"{file.path}: nests lists or tables too deeply to be read; mend the file") from None
    return tree


def _require_shallow(tree: dict[str, Any]) -> None:
    """Refuse what whoever walks through a tree would lose the way in, such as a key of thousands of parts.

    Raises:
        RecursionError: it is deeper than any file a person writes.
    """
    level: list[Any] = [tree]
    for _ in range(DEEPEST):
        nested = (node.values() if isinstance(node, dict) else node for node in level)
        level = [node for nodes in nested for node in nodes if isinstance(node, (dict, list))]
        if not level:
            return
    raise RecursionError


def require_folder(folder: Path) -> None:
    """Refuse a folder that is not there.

    Raises:
        InputError: nothing is there, or a file.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: {'is no folder' if folder.exists() else 'there is no such folder'}")


def stamped(path: Path, what: str) -> FileStamp:
    """Return the stamp of a file of any size, read in pieces.

    Args:
        path: of the file.
        what: the file should be, for the message.

    Raises:
        InputError: it cannot be read.
    """
    try:
        with open_regular(path) as file:
            digest = hashlib.file_digest(file, "sha256")
            return FileStamp(path=readable(str(path)), sha256=digest.hexdigest(), size=file.tell())
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give the path of {what}") from None


def open_regular(path: Path) -> BufferedReader:
    """Open a file for reading; a pipe or a device, which may never end, is refused without waiting for it.

    Raises:
        OSError: it cannot be opened, or is no regular file.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(handle).st_mode
    if not stat.S_ISREG(mode):
        os.close(handle)
        raise OSError(0, "Is a directory" if stat.S_ISDIR(mode) else "Is a device or a pipe, not a file")
    return os.fdopen(handle, "rb")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a place beside `path` to write to, and rename it to `path` when the block ends without an error.

    Args:
        path: of the finished file; one that is there is replaced.
    """
    part = path.with_name(f".{path.name}.part")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write JSON that a person can read too; numbers with all their digits.

    Raises:
        ValueError: a number is not finite, which JSON cannot say.
    """
    path.write_text(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Hold a folder against other processes that would write to it; the system lets go of it when a process dies.

    Raises:
        FolderBusyError: another process holds it, or has just removed it.
        OSError: the folder cannot be opened.
    """
    handle = os.open(folder, os.O_RDONLY)
    try:
        _lock(handle, folder)
        yield
    finally:
        os.close(handle)


def _lock(handle: int, folder: Path) -> None:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FolderBusyError from None
    if not folder.exists() or not os.path.samestat(os.fstat(handle), folder.stat()):
        raise FolderBusyError  # its last holder removed it between our look and our lock
