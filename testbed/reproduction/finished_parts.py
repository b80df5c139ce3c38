"""Finished parts of a reproduction in its folder, so that an interrupted one goes on where it was."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from testbed.campaign.executor import Notify
from testbed.campaign.kept_parts import KeptParts
from testbed.campaign.manifest import LARGEST_MANIFEST, require_same
from testbed.errors import InputError
from testbed.estimation.combine import CombinedEstimate
from testbed.files import read_bytes, whole_file
from testbed.maneuver.maneuver import Maneuver
from testbed.reproduction.alignment_flights import Flight
from testbed.reproduction.codec import Codec
from testbed.reproduction.table1 import PaperRow, Row, Table1
from testbed.reproduction.whiteness import Whiteness
from testbed.reproduction.zero_g_cuts import Cut
from testbed.reproduction.zero_g_outcome import CampaignOutcome

PARTS = "parts"
"""Folder inside a reproduction's."""
MANIFEST = "reproduction.json"
_SCHEMA = 1
_CODEC = Codec(types=(CampaignOutcome, CombinedEstimate, Cut, Flight, Maneuver, PaperRow, Row, Table1, Whiteness))


@dataclass(frozen=True, kw_only=True)
class FinishedParts:
    """What is finished.

    Attributes:
        folder: of all that is kept: the manifest, campaigns of Table 2, results of jobs.
        identity: what decides the results.
        seconds: that earlier starts took, s.
        checksums: of the results of jobs.
        began: when this start did, on the monotonic clock, s.
    """

    folder: Path
    identity: Mapping[str, Any]
    seconds: float
    checksums: dict[str, str]
    began: float

    @property
    def results(self) -> KeptParts:
        """The results of jobs, a file each."""
        return KeptParts(folder=self.folder / "results", checksums=self.checksums, record=self.write)

    def campaign(self, name: str) -> Path:
        """Return the folder of a campaign, which keeps its own parts."""
        folder = self.folder / "table2" / name
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def result(self, name: str) -> Any:  # noqa: ANN401 - whatever the job gave
        """Return what a job gave; None where it is not finished."""
        content = self.results.content(_file(name)) if _file(name) in self.checksums else None
        return None if content is None else _CODEC.decoded(content)

    def keep(self, name: str, result: Any) -> None:  # noqa: ANN401
        """Keep what a job gave.

        Raises:
            InputError: it cannot be written.
        """
        self.results.write(_file(name), _CODEC.encoded(result))

    @property
    def elapsed(self) -> float:
        """Time that all starts took until now, s."""
        return self.seconds + time.monotonic() - self.began

    def write(self) -> None:
        """Write the manifest as things stand.

        Raises:
            InputError: it cannot be written.
        """
        content = {
            "schema": _SCHEMA,
            "seconds": self.elapsed,
            "reproduction": self.identity,
            "parts": self.checksums,
        }
        try:
            with whole_file(self.folder / MANIFEST) as part:
                part.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
        except OSError as error:
            raise InputError(f"{self.folder}: cannot be written ({error.strerror}); make room there") from error


@contextmanager
def finished_parts(out: Path, identity: Mapping[str, Any], notify: Notify) -> Iterator[FinishedParts]:
    """Give the finished parts of a reproduction's folder; the time taken is noted at the end, however it comes.

    Args:
        out: the reproduction's folder, which this process holds.
        identity: what decides the results, as JSON.
        notify: called with a sentence for each part that is damaged or foreign; it is set aside and made again.

    Raises:
        InputError: the folder holds another reproduction, or cannot be read or written.
    """
    seconds, checksums = _kept(out, identity)
    parts = FinishedParts(
        folder=out / PARTS, identity=identity, seconds=seconds, checksums=checksums, began=time.monotonic()
    )
    results = parts.results
    results.prepare()
    for name in results.names():
        fault = results.fault(name)
        if fault is not None:
            notify(f"{results.folder / name} {fault}; moved to {results.set_aside(name)}")
    parts.write()
    try:
        yield parts
    finally:
        parts.write()


def require_reproduction(out: Path) -> None:
    """Refuse a folder in which no reproduction was begun.

    Raises:
        InputError: there is nothing to go on with.
    """
    if not (out / PARTS / MANIFEST).is_file():
        raise InputError(f"{out}: holds no reproduction to go on with; omit --resume, or name its folder with --out")


def _kept(out: Path, identity: Mapping[str, Any]) -> tuple[float, dict[str, str]]:
    """Return the time taken and the checksums that a folder's manifest notes; nothing where the folder is empty."""
    path = out / PARTS / MANIFEST
    if not path.parent.exists():
        return 0.0, {}
    try:
        content = json.loads(read_bytes(path, "a reproduction's manifest", LARGEST_MANIFEST))
        seconds, kept = float(content["seconds"]), dict(content["reproduction"])
        checksums = {str(name): str(checksum) for name, checksum in dict(content["parts"]).items()}
    except (InputError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{out}: cannot be resumed: {path} cannot be read ({error}); choose another --out") from error
    require_same(out, "reproduction", kept, identity)
    return seconds, checksums


def _file(name: str) -> str:
    return f"{name}.json"
