"""The page of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from testbed.diagnosis.location import ResidualSegment
from testbed.diagnosis.run_agreement import Agreement
from testbed.diagnosis.run_residuals import RunResiduals
from testbed.diagnosis.state import Diagnosis
from testbed.next_experiment.proposal import Proposal
from testbed.report.diagnosis.agreement import agreement_section
from testbed.report.diagnosis.gaps import gaps_section, where_section
from testbed.report.diagnosis.inertia import inertia_section, left_section
from testbed.report.diagnosis.next import next_section
from testbed.report.diagnosis.prediction import prediction_section
from testbed.report.diagnosis.ranking import ranking_section
from testbed.report.diagnosis.residuals import residuals_section
from testbed.report.diagnosis.verdict import diagnosis_verdict
from testbed.report.diagnosis.visibility import visibility_section
from testbed.report.frame.blocks import Notice, Page
from testbed.report.frame.page import write_page
from testbed.report.sections.provenance import provenance_section


def write_diagnosis_page(
    path: Path,
    diagnosis: Diagnosis,
    places: Sequence[ResidualSegment],
    residuals: Sequence[RunResiduals],
    agreements: Sequence[Agreement],
    proposal: Proposal | None,
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the HTML file.
        diagnosis: complete or not.
        places: where the gap is.
        residuals: of every run.
        agreements: of the runs on what was added.
        proposal: what to fly next; None where nothing is ambiguous.
        provenance: what made it.
        result: what diagnosis.json holds.

    Raises:
        OutputError: the file cannot be written.
    """
    write_page(path, diagnosis_page(diagnosis, places, residuals, agreements, proposal, provenance, result))


def diagnosis_page(
    diagnosis: Diagnosis,
    places: Sequence[ResidualSegment],
    residuals: Sequence[RunResiduals],
    agreements: Sequence[Agreement],
    proposal: Proposal | None,
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> Page:
    """Return the page; arguments as above."""
    return Page(
        title=f"Diagnosis against the scenario {provenance['scenario']}",
        subtitle="Where simulation and data disagree, which named effect explains it, and the remaining residual.",
        verdict=diagnosis_verdict(diagnosis),
        notices=tuple(Notice(tone="warn", text=text) for text in result["notices"]),
        sections=(
            gaps_section(diagnosis),
            where_section(places),
            *ranking_section(diagnosis),
            *agreement_section(diagnosis, agreements),
            prediction_section(residuals),
            residuals_section(residuals),
            inertia_section(diagnosis),
            *left_section(diagnosis),
            *next_section(proposal),
            *visibility_section(diagnosis),
            provenance_section(provenance, "diagnosis.json", result),
        ),
    )
