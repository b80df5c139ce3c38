"""Files that long work leaves one by one, each known by its checksum, so that a later start trusts what it finds."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from testbed.errors import InputError
from testbed.files import open_regular, whole_file

SET_ASIDE = "set_aside"
"""Folder beside that of the parts, for files that are damaged or foreign; nothing in it is ever read or replaced."""


@dataclass(frozen=True, kw_only=True)
class KeptParts:
    """A folder of parts.

    Attributes:
        folder: of the parts; nothing else belongs in it.
        checksums: SHA-256 of each part by its name, in hexadecimal.
        record: writes the checksums down; called before a part appears, so that no part is ever without one.
    """

    folder: Path
    checksums: dict[str, str]
    record: Callable[[], None]

    def prepare(self) -> None:
        """Make the folder.

        Raises:
            InputError: it cannot be made.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise self._unwritable(error) from error

    def names(self) -> list[str]:
        """Return what the folder holds, hidden files left out, as readers of data sets leave them out.

        What a killed process had not finished writing is removed: nobody else may be writing now.
        """
        for unfinished in self.folder.glob(".*.part"):
            unfinished.unlink(missing_ok=True)
        return sorted(entry.name for entry in self.folder.iterdir() if not entry.name.startswith("."))

    def content(self, name: str) -> bytes | None:
        """Return what a file of the folder holds; None where it cannot be read."""
        try:
            with open_regular(self.folder / name) as file:
                return file.read()
        except OSError:
            return None

    def fault(self, name: str) -> str | None:
        """Return what is wrong with a part that has a checksum; None where it is as it was written."""
        if name not in self.checksums:
            return "was not written here"
        content = self.content(name)
        if content is None:
            return "cannot be read"
        return None if sha256_of(content) == self.checksums[name] else "is damaged (its SHA-256 is not the one noted)"

    def write(self, name: str, content: bytes) -> None:
        """Write a part, whole or not at all; one of that name is replaced.

        Raises:
            InputError: it cannot be written.
        """
        self.checksums[name] = sha256_of(content)
        self.record()
        try:
            with whole_file(self.folder / name) as part:
                part.write_bytes(content)
        except OSError as error:
            raise self._unwritable(error) from error

    def set_aside(self, name: str) -> Path:
        """Move a file out of the folder, to a name that nothing has yet; returns its new place.

        Raises:
            InputError: it cannot be moved.
        """
        aside, source = self.folder.parent / SET_ASIDE, self.folder / name
        try:
            aside.mkdir(exist_ok=True)
            places = (
                aside / (name if number == 1 else f"{source.stem}-{number}{source.suffix}") for number in count(1)
            )
            place = next(place for place in places if not os.path.lexists(place))
            source.rename(place)
        except OSError as error:
            raise self._unwritable(error) from error
        self.checksums.pop(name, None)
        return place

    def _unwritable(self, error: OSError) -> InputError:
        return InputError(f"{self.folder}: cannot be written ({error.strerror}); make room there, nothing is lost")


def sha256_of(content: bytes) -> str:
    """Return the SHA-256 of a file's content, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()
