"""The folder of estimates from records measured elsewhere."""

from __future__ import annotations

from pathlib import Path

from testbed.assembly.platform import Body
from testbed.dynamics.inertia import theta_of
from testbed.files import TextFile, write_json
from testbed.identification.identify import Identification
from testbed.identification.result import identification_result
from testbed.outputs.provenance import Provenance
from testbed.report.measured import write_estimates_report
from testbed.scenario.body import BodyScenario


def write_estimates(
    folder: Path,
    file: TextFile,
    origin: Provenance,
    scenario: BodyScenario,
    nominal: Body,
    identification: Identification,
) -> None:
    """Write the scenario, estimates.json (every record's estimates, and their combination), report and provenance.

    Args:
        folder: to write into.
        file: the scenario as it was read.
        origin: what made the estimates; the records are among its inputs.
        scenario: read from the file.
        nominal: its platform.
        identification: the records and what they say.

    Raises:
        OSError: the folder cannot be written.
    """
    content = identification_result(identification, scenario, theta_of(nominal.inertia)) | {
        "provenance": origin.reproducible
    }
    (folder / "scenario.toml").write_bytes(file.content)
    write_json(folder / "estimates.json", content)
    write_json(folder / "provenance.json", origin.content)
    write_estimates_report(
        folder / "report.html",
        scenario=scenario,
        nominal=nominal,
        identification=identification,
        provenance=origin.listed | {"scenario.toml": file.text},
        result=content,
    )
