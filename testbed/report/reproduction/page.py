"""The page of a reproduction, from its verdict to its provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from testbed.report.frame.blocks import Page, Section
from testbed.report.frame.page import write_page
from testbed.report.reproduction.alignments import alignments_section
from testbed.report.reproduction.assumptions import assumptions_section
from testbed.report.reproduction.claims import claims_section, claims_verdict
from testbed.report.reproduction.interpretation import interpretation_section
from testbed.report.reproduction.orbit import orbit_section
from testbed.report.reproduction.platform import platform_section
from testbed.report.reproduction.table1 import table1_section
from testbed.report.reproduction.table2 import table2_section
from testbed.report.reproduction.table3 import table3_section
from testbed.report.sections.provenance import provenance_section
from testbed.reproduction.claims import Claim
from testbed.reproduction.figures import maneuver_figures
from testbed.reproduction.reproduction import Reproduction
from testbed.reproduction.seeds import ClaimOverSeeds


def write_reproduction_page(
    path: Path,
    reproduction: Reproduction,
    claims: Sequence[Claim],
    over_seeds: Sequence[ClaimOverSeeds],
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the HTML file.
        reproduction: what was made.
        claims: what it is held to.
        over_seeds: the claims over several seeds; none where only one was flown.
        provenance: what made it.
        result: what reproduce.json holds.

    Raises:
        OutputError: the file cannot be written.
    """
    page = Page(
        title="Design of Satellite Maneuvers for Inertia Parameter Estimation, reproduced",
        subtitle="The paper's three tables and six figures from this testbed in one run, beside the paper's own "
        "numbers, and the same with this project's maneuvers and estimators.",
        verdict=claims_verdict(claims),
        notices=(),
        sections=(
            claims_section(claims, over_seeds),
            *_sections(reproduction),
            provenance_section(provenance, "reproduce.json", result),
        ),
    )
    write_page(path, page)


def _sections(reproduction: Reproduction) -> Iterator[Section]:
    shown = maneuver_figures(reproduction.table1, reproduction.table2, reproduction.acceleration_limit)
    yield table1_section(reproduction.table1, shown)
    yield table2_section(reproduction.table2)
    yield assumptions_section(reproduction.table2, reproduction.whiteness)
    yield platform_section(reproduction.zero_g_model)
    yield table3_section(reproduction.table3)
    yield alignments_section(reproduction.alignments)
    yield orbit_section(reproduction.orbit)
    yield interpretation_section(reproduction.table2, reproduction.whiteness)
