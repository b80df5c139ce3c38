"""The folder of a diagnosis: the answer, its page, the recording, the extended model."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from testbed.arrays import Array
from testbed.assembly.extension import PLATFORM, SCENARIO, extended, write_extended
from testbed.diagnosis.location import ResidualSegment
from testbed.diagnosis.result import result_of
from testbed.diagnosis.run_agreement import Agreement
from testbed.diagnosis.run_residuals import residuals_of
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import inertia_of
from testbed.effects.contract import Extension, NamedEffect
from testbed.errors import InputError
from testbed.files import TextFile, write_json
from testbed.next_experiment.proposal import Proposal
from testbed.next_experiment.result import next_of
from testbed.next_experiment.scenario import write_next
from testbed.outputs.provenance import Provenance
from testbed.report.diagnosis.next import purpose_words
from testbed.report.diagnosis.page import write_diagnosis_page
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario

EXTENDED = "extended"
NEXT = "next"
WRITTEN = ("diagnosis.json", "report.html", "recording.rrd", SCENARIO, "provenance.json", EXTENDED, NEXT)
"""All that a diagnosis may write."""


def write_diagnosis(
    folder: Path,
    file: TextFile,
    origin: Provenance,
    scenario: BodyScenario,
    diagnosis: Diagnosis,
    places: Sequence[ResidualSegment],
    agreements: Sequence[Agreement],
    notices: Sequence[str],
    proposal: Proposal | None,
) -> tuple[str, ...]:
    """Write diagnosis.json, report.html, recording.rrd, scenario.toml, extended/, next/ and provenance.json.

    Args:
        folder: to write into.
        file: the nominal scenario as it was read.
        origin: what made the diagnosis; the records are among its inputs.
        scenario: read from the file.
        diagnosis: complete or not.
        places: where the gap is.
        agreements: of the runs on what was added.
        notices: what a reader has to know of the records.
        proposal: what to fly next; None where nothing is ambiguous.

    Returns:
        What more there is to know once all is written.

    Raises:
        OSError: the folder cannot be written.
    """
    residuals = residuals_of(diagnosis)
    (folder / SCENARIO).write_bytes(file.content)
    model, said = _write_model(folder, scenario, diagnosis)
    content = result_of(diagnosis, places, (*notices, *said), agreements)
    content |= model | _write_next(folder, scenario, proposal) | {"provenance": origin.reproducible}
    write_json(folder / "diagnosis.json", content)
    write_json(folder / "provenance.json", origin.content)
    write_diagnosis_page(
        folder / "report.html",
        diagnosis,
        places,
        residuals,
        agreements,
        proposal,
        origin.listed | {"scenario.toml": file.text},
        content,
    )
    write_recording_of(folder / "recording.rrd", origin, scenario, diagnosis)
    return said


def write_recording_of(path: Path, origin: Provenance, scenario: BodyScenario, diagnosis: Diagnosis) -> None:
    """Write the recording of a diagnosis, whole or not at all.

    Args:
        path: of the .rrd file.
        origin: what made the diagnosis.
        scenario: that was diagnosed.
        diagnosis: complete or not.
    """
    from testbed.outputs.diagnosis_recording import diagnosis_content  # noqa: PLC0415 - rerun takes half a second, which only a recording needs
    from testbed.recording.diagnosis import write_diagnosis_recording  # noqa: PLC0415 - likewise

    content = diagnosis_content(scenario, diagnosis, residuals_of(diagnosis), origin.listed)
    write_diagnosis_recording(path, origin.recording_id, content)


def _write_model(part: Path, scenario: BodyScenario, diagnosis: Diagnosis) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Write the extended model; return where it is, and what of the diagnosis is not in it, or why there is none."""
    try:
        if not isinstance(scenario, Scenario):
            raise InputError("a platform that is only measured is not flown")
        extensions = list(extensions_of(scenario, diagnosis))
        write_extended(scenario, extensions, inertia_of(diagnosis.model.theta), part / EXTENDED)
    except InputError as error:
        shutil.rmtree(part / EXTENDED, ignore_errors=True)
        return {"model": None, "scenario": None}, (f"no extended model: {error}",)
    left_out = [placed.key for placed in diagnosis.model.placed if not placed.effect.flies]
    said = (f"{EXTENDED}/ flies without {', '.join(left_out)}: no simulated platform has it",) if left_out else ()
    return {"model": f"{EXTENDED}/{PLATFORM}", "scenario": f"{EXTENDED}/{SCENARIO}"}, said


def _write_next(part: Path, scenario: BodyScenario, proposal: Proposal | None) -> dict[str, Any]:
    """Write the scenario of the next flight, where there is one; return what diagnosis.json says of it."""
    if proposal is None or proposal.flight is None or not isinstance(scenario, Scenario):
        return next_of(proposal, None)
    write_next(scenario, proposal.flight, purpose_words(proposal), part / NEXT)
    return next_of(proposal, f"{NEXT}/{SCENARIO}")


def extensions_of(scenario: Scenario, diagnosis: Diagnosis) -> Iterator[Extension]:
    """Yield what every effect adds, each asked with the scenario that those before it have changed."""
    on_motion = zip(diagnosis.model.placed, diagnosis.model.values.effects, strict=True)
    found: list[tuple[NamedEffect, str, Array]] = [(each.effect, each.component, own[0]) for each, own in on_motion]
    found += [(each.effect, each.component, each.finding.values) for each in diagnosis.scatter]
    for effect, component, values in found:
        extension = effect.extension(component, values, scenario)
        scenario = extended(scenario, extension)
        yield extension
