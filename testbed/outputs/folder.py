"""An output folder that one command has to itself from its start, and that is filled whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TypeVar

from testbed.errors import InputError, OutputError
from testbed.files import FolderBusyError, only_writer
from testbed.interrupts import deferred_interrupts

RUNS = Path("runs")
"""Where results go without --out."""
SCRATCH = ".part"
"""Folder inside an output folder that holds what is being written; left behind only by a process that was killed."""
LEAST_SPACE = 32 * 2**20
"""Bytes that have to be free before work begins: the largest run folder of the shipped scenarios takes 13 MB."""

_T = TypeVar("_T")


class _TakenError(Exception):
    """A folder that this command cannot have; the text says why."""


@dataclass(frozen=True, kw_only=True)
class OutputFolder:
    """A folder that is reserved for this command.

    Attributes:
        path: as the user gave it, or as it was chosen.
    """

    path: Path

    @property
    def scratch(self) -> Path:
        """Folder inside it for what is not finished."""
        return self.path / SCRATCH

    def deliver(self, write: Callable[[Path], _T], *, instead_of: Sequence[str] = ()) -> _T:
        """Have results written, and let them appear in the folder once all of them are there.

        Args:
            write: writes files and folders into the folder that it is given; called again with another folder where
                this one cannot be written.
            instead_of: files and folders of an earlier command that goes on here, which give way to the results.

        Returns:
            What `write` returned.

        Raises:
            OutputError: the folder cannot be written; the message says where the results were kept instead.
        """
        try:
            returned = write(self.scratch)
            with deferred_interrupts():
                for name in instead_of:
                    _remove(self.path / name)
                for entry in sorted(self.scratch.iterdir()):
                    entry.rename(self.path / entry.name)
        except (OSError, OutputError) as error:
            raise OutputError(f"{self.path}: {_reason(error)}; {_kept_elsewhere(write)}") from error
        return returned


@contextmanager
def reserved_folder(out: Path | None, name: str, *, resume: bool = False) -> Iterator[OutputFolder]:
    """Reserve an output folder, also against other processes, until the block ends.

    A folder counts as reserved while its process holds a lock on it; the system lets go of the lock when the process
    dies, and what such a process left unfinished is removed here. A folder in which nothing was put is removed again.

    Args:
        out: the folder that the user wants, new or empty; None for the first free one of runs/NAME, runs/NAME-2, ...
        name: of that folder.
        resume: whether to go on in a folder that an earlier command has begun.

    Raises:
        InputError: the folder is taken.
        OutputError: it cannot be written, or has no room.
        KeyboardInterrupt: where nothing was put into the folder before it, it says so.
    """
    with ExitStack() as stack:
        if out is None:
            folder = _first_free(stack, RUNS, name)
        else:
            try:
                folder = _claimed(stack, out, resume=resume)
            except _TakenError as error:
                raise InputError(f"{out}: {error}") from error
        try:
            yield folder
        except KeyboardInterrupt as interrupt:
            if _is_filled(folder.path):
                raise
            raise KeyboardInterrupt("nothing was written") from interrupt


def _first_free(stack: ExitStack, parent: Path, name: str) -> OutputFolder:
    for number in count(1):
        with suppress(_TakenError):
            return _claimed(stack, parent / (name if number == 1 else f"{name}-{number}"), resume=False)
    raise AssertionError("unreachable: count never ends")


def _claimed(stack: ExitStack, path: Path, *, resume: bool) -> OutputFolder:
    """Claim a folder for as long as the stack lives.

    Raises:
        _TakenError: it is another command's, or holds something.
        OutputError: it cannot be made or written.
    """
    with ExitStack() as own:
        try:
            made = _made(path)
            _require_folder(path)
            own.enter_context(only_writer(path))
            for each in made:
                own.callback(_remove_if_empty, each)
            _require_free(path, resume=resume)
            folder = OutputFolder(path=path)
            shutil.rmtree(folder.scratch, ignore_errors=True)  # of a process that was killed: nobody else has the lock
            folder.scratch.mkdir()
            own.callback(shutil.rmtree, folder.scratch, ignore_errors=True)
            _require_room(folder.scratch)
        except FolderBusyError as error:
            raise _TakenError("another command is writing to it; wait for it, or choose another folder") from error
        except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
            raise OutputError(f"{path}: {_reason(error)}; make room, or choose another folder") from error
        stack.push(own.pop_all())
    return folder


def _made(path: Path) -> list[Path]:
    """Make a folder with its parents; return those that were not there before, the outermost first."""
    missing = [folder for folder in (path, *path.parents) if not os.path.lexists(folder)][::-1]
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileExistsError):
        path.mkdir()
    return missing


def _require_folder(path: Path) -> None:
    if not path.is_dir():
        raise _TakenError("is a file; give a new or empty folder, nothing is overwritten")


def _require_free(path: Path, *, resume: bool) -> None:
    if not resume and _is_filled(path):
        raise _TakenError("is a folder that is not empty; give a new or empty folder, nothing is overwritten")


def _is_filled(path: Path) -> bool:
    return any(entry.name != SCRATCH for entry in path.iterdir())


def _require_room(folder: Path) -> None:
    """Write and remove a file, which says more than what the file system reports: quotas count too.

    Raises:
        OSError: there is no room, or no permission.
    """
    probe = folder / "room"
    with probe.open("wb") as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, LEAST_SPACE)
        else:
            file.write(bytes(LEAST_SPACE))
    probe.unlink()


def _reason(error: Exception) -> str:
    cause = error if isinstance(error, OSError) else error.__cause__  # of an OutputError, the system's own
    return f"cannot be written ({(isinstance(cause, OSError) and cause.strerror) or error})"


def _kept_elsewhere(write: Callable[[Path], object]) -> str:
    """Have results written to a fallback folder; return what to tell the user of it."""
    for parent in (Path(tempfile.gettempdir()), Path.home(), Path.cwd()):
        with suppress(OSError, OutputError):
            fallback = Path(tempfile.mkdtemp(prefix="testbed-", dir=parent))
            try:
                write(fallback)
            except (OSError, OutputError):
                shutil.rmtree(fallback, ignore_errors=True)
                raise
            return f"the results were kept in {fallback}"
    return "nor can any fallback folder, so that nothing was kept: make room and repeat the command"


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _remove_if_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()
