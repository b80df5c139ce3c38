"""testbed estimate: the inertia from records measured elsewhere."""

from __future__ import annotations

from pathlib import Path

from testbed.arrays import Theta
from testbed.assembly.platform import nominal_platform
from testbed.cli.console import command_line, say, show
from testbed.cli.failures import naming
from testbed.cli.notices import print_notices, print_verdict
from testbed.cli.tables import estimate_table
from testbed.delivery.estimate_folder import write_estimates
from testbed.delivery.folder import reserved_folder
from testbed.delivery.provenance import provenance
from testbed.dynamics.inertia import theta_of
from testbed.identification.estimating import Identification, identify
from testbed.records.reading import read_data_set
from testbed.report.measured import identification_notices, identification_verdict
from testbed.scenario.reader import scenario_file, scenario_of


def estimate_records(path: Path, data: Path, out: Path | None) -> None:
    """Estimate from every record of a folder, print each and their combination, write them.

    Args:
        path: of the scenario.
        data: folder of records.
        out: new or empty folder; None for a fresh one.

    Raises:
        InputError: scenario, records or output folder cannot be used, or no record gives an estimate.
    """
    file = scenario_file(path)
    scenario = scenario_of(file)
    with reserved_folder(out, f"{scenario.name}-estimate") as folder:
        with naming(path):
            nominal = nominal_platform(scenario)
        records = read_data_set(data)
        origin = provenance(
            scenario, file, command_line(), data=[stamp for record in records for stamp in record.files]
        )
        identification = identify(scenario, nominal, records)
        _print(identification, theta_of(nominal.inertia))
        folder.deliver(lambda place: write_estimates(place, file, origin, scenario, nominal, identification))
    say()
    say(f"Folder     {folder.path}")
    say(f"Report     {folder.path / 'report.html'}")


def _print(identification: Identification, nominal_theta: Theta) -> None:
    known = {"nominal": nominal_theta}
    for name, estimation in identification.estimations.items():
        show(estimate_table(f"{name}: inertia in 1e-3 kg m², ± one standard deviation", known, estimation))
        say()
    if len(identification.estimations) > 1:
        title = f"{len(identification.estimations)} records combined (eq. 33): inertia in 1e-3 kg m²"
        show(estimate_table(title, known, identification.combined))
        say()
    print_verdict(identification_verdict(identification, nominal_theta))
    print_notices(identification_notices(identification))
