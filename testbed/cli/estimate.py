"""testbed estimate: the inertia from records measured elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from testbed.arrays import Theta
from testbed.cli.console import command_line, print_as_json, say, show
from testbed.cli.notices import print_notices, print_verdict
from testbed.cli.options import changed_scenario, print_folder
from testbed.cli.tables import estimate_table
from testbed.dynamics.inertia import theta_of
from testbed.identification.identify import Identification
from testbed.library.estimates import estimate
from testbed.library.records import read_records
from testbed.outputs.folder import reserved_folder
from testbed.report.measured import identification_notices, identification_verdict


def estimate_records(source: str, changes: Sequence[str], data: Path, out: Path | None) -> None:
    """Estimate from every record of a folder, print each and their combination, write them.

    Args:
        source: path of the scenario, or name of a shipped one.
        changes: of the scenario, KEY=VALUE each.
        data: folder of records.
        out: new or empty folder; None for a fresh one.

    Raises:
        InputError: scenario, records or output folder cannot be used, or no record gives an estimate.
    """
    scenario = changed_scenario(source, changes)
    with reserved_folder(out, f"{scenario.name}-estimate") as folder:
        found = estimate(scenario, read_records(data))
        _print(found.identification, theta_of(found.nominal.inertia))
        folder.deliver(lambda place: found.write(place, command_line()))
    say()
    print_folder(folder.path)
    print_as_json(folder.path / "estimates.json")


def _print(identification: Identification, nominal_theta: Theta) -> None:
    known = {"nominal": nominal_theta}
    for name, estimation in identification.estimations.items():
        show(estimate_table(f"{name}: inertia", known, estimation))
        say()
    if len(identification.estimations) > 1:
        title = f"{identification.what_is_combined} combined (eq. 33): inertia"
        show(estimate_table(title, known, identification.combined))
        say()
    print_verdict(identification_verdict(identification, nominal_theta))
    print_notices(identification_notices(identification))
