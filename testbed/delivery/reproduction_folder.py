"""The folder of a reproduction: the page, its numbers, the recording, what made it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from testbed.delivery.folder import whole_folder
from testbed.delivery.provenance import recording_id_of, reproduction_provenance
from testbed.delivery.reproduction_recording import reproduction_content
from testbed.delivery.run_folder import write_json
from testbed.recording.reproduction import write_reproduction_recording
from testbed.report.reproduction.page import write_reproduction_page
from testbed.reproduction.claims import Claim
from testbed.reproduction.reproduction import SCENARIOS, Reproduction
from testbed.reproduction.result import result_of
from testbed.scenario.shipped import shipped_scenario


def write_reproduction(folder: Path, reproduction: Reproduction, claims: Sequence[Claim]) -> None:
    """Write reproduction.html, reproduce.json, recording.rrd and provenance.json, whole or not at all.

    Args:
        folder: new or empty.
        reproduction: what was made.
        claims: what it is held to.

    Raises:
        InputError: the folder is taken, or cannot be written.
    """
    provenance = reproduction_provenance(reproduction.extent, _scenarios())
    content = result_of(reproduction, claims)
    with whole_folder(folder) as part:
        write_json(part / "reproduce.json", content)
        write_json(part / "provenance.json", provenance)
        write_reproduction_page(part / "reproduction.html", reproduction, claims, provenance, content)
        write_reproduction_recording(
            part / "recording.rrd", recording_id_of(provenance), reproduction_content(reproduction, claims, provenance)
        )


def _scenarios() -> dict[str, str]:
    return {name: shipped_scenario(name).read_text(encoding="utf-8") for name in SCENARIOS}
