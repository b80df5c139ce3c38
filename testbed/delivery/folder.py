"""A folder that appears whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from testbed.errors import InputError


def free_folder(parent: Path, name: str) -> Path:
    """Return parent/name, or parent/name-2 and so on: the first that is not taken."""
    for number in count(1):
        candidate = parent / (name if number == 1 else f"{name}-{number}")
        if not _is_taken(candidate):
            return candidate
    raise AssertionError("unreachable: count never ends")


def require_free(folder: Path) -> None:
    """Refuse a folder that holds anything, before any work is done for it.

    Raises:
        InputError: the path is a file, or a folder that is not empty.
    """
    if _is_taken(folder):
        what = "a folder that is not empty" if folder.is_dir() else "a file"
        raise InputError(f"{folder}: is {what}; give --out a new or empty folder, nothing is overwritten")


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """Give a scratch folder beside `folder`, and rename it into place when the block ends without an error.

    Args:
        folder: where the result shall appear; new or empty.

    Raises:
        InputError: the folder is taken, or cannot be written.
    """
    require_free(folder)
    folder = folder.resolve()
    scratch = _scratch_beside(folder)
    try:
        yield scratch
        _put(scratch, folder)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror}); make room or choose another") from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _put(scratch: Path, folder: Path) -> None:
    """Rename the scratch folder, or fill the empty folder that a person made, perhaps to stand in it."""
    if not folder.is_dir():
        scratch.rename(folder)
        return
    for entry in scratch.iterdir():
        entry.rename(folder / entry.name)


def _scratch_beside(folder: Path) -> Path:
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{folder.name}.part-", dir=folder.parent))
        scratch.chmod(0o755)
    except OSError as error:
        raise InputError(f"{folder}: cannot be created ({error.strerror}); choose another --out") from error
    return scratch


def _is_taken(path: Path) -> bool:
    try:
        return path.is_file() or (path.is_dir() and any(path.iterdir()))
    except OSError as error:
        raise InputError(f"{path}: cannot be looked at ({error.strerror}); choose another --out") from error
