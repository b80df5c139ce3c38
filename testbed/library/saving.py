"""Results that have a folder of their own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path

from testbed.library.arguments import AnyPath, checked
from testbed.outputs.folder import reserved_folder


class Saved(ABC):
    """A result that is written into a folder, by a program or by the command that made it."""

    @abstractmethod
    def write(self, folder: Path, command: str) -> tuple[str, ...]:
        """Write the result's files into a folder that is reserved for them.

        Args:
            folder: to write into.
            command: that made the result, for its provenance.

        Returns:
            What more there is to know once all is written; mostly nothing.

        Raises:
            InputError: there is nothing to write.
        """

    @checked
    def save(self, folder: AnyPath) -> Path:
        """Write the folder that the command for such a result writes; all of it appears, or nothing.

        Args:
            folder: new or empty.

        Returns:
            The folder.

        Raises:
            InputError: the folder cannot be used, or there is nothing to write.
        """
        path, command = Path(folder), f"testbed.{type(self).__name__}.save"
        with reserved_folder(path, path.name) as output:
            output.deliver(lambda place: self.write(place, command))
        return path
