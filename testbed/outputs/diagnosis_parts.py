"""The parts of a diagnosis that is not complete, in the folder of its results, so that it can go on there.

parts.jsonl: in the first line what decides the diagnosis, in every further one a part; each with the SHA-256 of its
content, so that a line that is torn or damaged is worked out again.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from testbed.campaign.manifest import require_same
from testbed.diagnosis.keeping import Content
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.errors import InputError, OutputError, OwnEffectError
from testbed.files import read_bytes, whole_file
from testbed.interrupts import deferred_interrupts
from testbed.outputs.folder import OutputFolder
from testbed.outputs.provenance import Provenance

PARTS = "parts.jsonl"
_LARGEST = 1_000_000_000
"""Bytes; the example of docs/how-to/diagnose.md keeps 1 MB."""
_NAME, _CONTENT, _SHA256 = "name", "content", "sha256"
_IDENTITY = "diagnosis"
"""Name of the first line."""


@dataclass(kw_only=True)
class KeptParts:
    """Parts in a file, and what is added to it.

    Attributes:
        path: of the file, which appears with the first part.
        identity: what decides the diagnosis.
        parts: by name.
        damaged: lines that were left out.
        full: whether the file can no longer be written.
    """

    path: Path
    identity: Mapping[str, Any]
    parts: dict[str, Content] = field(default_factory=dict)
    damaged: int = 0
    full: bool = False

    def get(self, name: str) -> Content | None:
        """Return what is kept under a name; None where nothing is."""
        return self.parts.get(name)

    def put(self, name: str, content: Content) -> None:
        """Keep content under a name; a diagnosis does not end because there is no room for it."""
        self.parts[name] = content
        if self.full:
            return
        try:
            with deferred_interrupts():
                self._append(name, content)
        except OSError:
            self.full = True

    def _append(self, name: str, content: Content) -> None:
        first = "" if self.path.exists() else _line(_IDENTITY, dict(self.identity))
        with self.path.open("a", encoding="utf-8") as file:
            file.write(first + _line(name, content))


@contextmanager
def kept_parts(folder: OutputFolder, origin: Provenance, *, resume: bool) -> Iterator[KeptParts]:
    """Keep the parts of a diagnosis in its folder for as long as it is not complete.

    Where the data or an effect from outside the library turn out to be of no use, nothing is kept.

    Args:
        folder: of the results.
        origin: what makes the diagnosis.
        resume: whether to go on with what is kept there.

    Raises:
        InputError: the folder holds no interrupted diagnosis, or one of other data, another scenario or other versions.
    """
    path, identity = folder.path / PARTS, _identity_of(origin)
    parts = KeptParts(path=path, identity=identity)
    if resume:
        parts = _read(path, identity)
    try:
        yield parts
    except OutputError:
        raise
    except (InputError, OwnEffectError):
        path.unlink(missing_ok=True)
        raise


def _identity_of(origin: Provenance) -> dict[str, Any]:
    """Return what decides a diagnosis, as JSON; the files may have been moved."""
    return {
        **origin.deciding,
        "files": {Path(stamp.path).name: stamp.sha256 for stamp in origin.inputs},
        "effects": [*EFFECTS, *NOISE_EFFECTS],
    }


def _read(path: Path, identity: Mapping[str, Any]) -> KeptParts:
    """Read what is kept; a folder in which nothing is yet is begun anew.

    Raises:
        InputError: it is of another diagnosis, or of none.
    """
    if not path.exists():
        if any(path.parent.glob("[!.]*")):
            raise InputError(
                f"{path.parent}: holds no interrupted diagnosis ({PARTS} is missing): begin anew, without "
                "resume (--resume), in a new folder (--out)"
            )
        return KeptParts(path=path, identity=identity)
    lines = read_bytes(path, "the finished parts of a diagnosis", _LARGEST).split(b"\n")
    kept = {name: content for name, content in map(_checked, lines) if name}
    begun = kept.pop(_IDENTITY, None)
    if begun is None:
        raise InputError(f"{path}: its first line, which names the diagnosis, is damaged; choose another folder")
    require_same(path.parent, "diagnosis", begun, identity)
    damaged = sum(map(bool, lines)) - len(kept) - 1
    if damaged:
        with whole_file(path) as part:
            entries = [_line(_IDENTITY, begun), *(_line(name, content) for name, content in kept.items())]
            part.write_text("".join(entries), encoding="utf-8")
    return KeptParts(path=path, identity=identity, parts=kept, damaged=damaged)


def _line(name: str, content: Content) -> str:
    return json.dumps({_NAME: name, _CONTENT: content, _SHA256: _sha256(name, content)}) + "\n"


def _checked(line: bytes) -> tuple[str, Content]:
    """Return name and content of a line; an empty name where it is damaged."""
    with suppress(ValueError, KeyError, TypeError, RecursionError):
        entry = json.loads(line)
        if entry[_SHA256] == _sha256(entry[_NAME], entry[_CONTENT]):
            return entry[_NAME], entry[_CONTENT]
    return "", {}


def _sha256(name: str, content: Content) -> str:
    return hashlib.sha256(json.dumps([name, content]).encode()).hexdigest()
