"""The folder of a reproduction: the page, its numbers, the recording, what made it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from testbed.files import write_json
from testbed.outputs.provenance import Provenance
from testbed.outputs.reproduction_recording import reproduction_content
from testbed.recording.reproduction import write_reproduction_recording
from testbed.report.reproduction.page import write_reproduction_page
from testbed.reproduction.claims import Claim
from testbed.reproduction.reproduction import Reproduction
from testbed.reproduction.result import result_of
from testbed.reproduction.seeds import ClaimOverSeeds


def write_reproduction(
    folder: Path,
    origin: Provenance,
    reproduction: Reproduction,
    claims: Sequence[Claim],
    over_seeds: Sequence[ClaimOverSeeds] = (),
) -> None:
    """Write reproduction.html, reproduce.json, recording.rrd and provenance.json.

    Args:
        folder: to write into.
        origin: what made the reproduction.
        reproduction: what was made.
        claims: what it is held to.
        over_seeds: the claims over several seeds, where that was asked for.

    Raises:
        OSError: the folder cannot be written.
    """
    content = result_of(reproduction, claims, over_seeds) | {"provenance": origin.reproducible}
    write_json(folder / "reproduce.json", content)
    write_json(folder / "provenance.json", origin.content)
    write_reproduction_page(folder / "reproduction.html", reproduction, claims, over_seeds, origin.listed, content)
    write_reproduction_recording(
        folder / "recording.rrd", origin.recording_id, reproduction_content(reproduction, claims, origin.listed)
    )
