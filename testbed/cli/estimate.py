"""testbed estimate: the inertia from records measured elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from testbed.assembly.contact import cut_at_contact
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.cli.console import console, say, warn
from testbed.cli.tables import estimate_table
from testbed.delivery.estimate_folder import write_estimates
from testbed.delivery.folder import require_free
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.experiment.estimating import combine_estimations, estimate_record
from testbed.experiment.experiment import Estimation
from testbed.records.reading import extra_columns_notice, read_data_set
from testbed.records.record import Record
from testbed.records.selection import telemetry_only
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario


def estimate_records(path: Path, data: Path, out: Path | None) -> None:
    """Estimate from every record of a folder, print each and their combination, write them where --out says.

    Raises:
        InputError: scenario, records or output folder cannot be used, or no record gives an estimate.
    """
    if out is not None:
        require_free(out)
    scenario = read_scenario(path)
    nominal = nominal_platform(scenario)
    records = tuple(_cut(scenario, nominal, record) for record in read_data_set(data))
    estimations = _estimations(scenario, nominal, records)
    combined = combine_estimations(estimations)
    known = {"nominal": theta_of(nominal.inertia)}
    for name, estimation in estimations.items():
        console.print(estimate_table(f"{name}: inertia in 1e-3 kg m²", known, estimation))
        _print_failures(name, estimation)
        say()
    if len(estimations) > 1:
        title = f"{len(estimations)} records combined (eq. 33): inertia in 1e-3 kg m²"
        console.print(estimate_table(title, known, combined))
    if out is not None:
        used = [record for record in records if record.details.name in estimations]
        write_estimates(out, path, scenario, nominal, used, estimations, combined)
        say(f"Written to {out}")


def _cut(scenario: Scenario, nominal: PlatformModel, record: Record) -> Record:
    """Cut a record at the first contact that it shows, where the scenario asks for it, and say so."""
    if not scenario.estimation.cut_at_contact:
        return record
    try:
        cut, contact = cut_at_contact(record, scenario, nominal)
    except InputError:  # its own message follows when it is estimated from
        return record
    if contact is not None:
        place = f"contact found at {contact.first_seen:.3f} s, the body rate jumps by {contact.rate_jump:.2g} rad/s"
        warn("note", f"{record.details.name}: {place}; record cut at {contact.last_free:.3f} s")
    return cut


def _estimations(scenario: Scenario, nominal: PlatformModel, records: tuple[Record, ...]) -> Mapping[str, Estimation]:
    """Estimate from every record that allows it; a record that does not is left out, with the reason."""
    estimations: dict[str, Estimation] = {}
    refused: list[str] = []
    for record in records:
        notice = extra_columns_notice(record)
        if notice is not None:
            warn("note", notice)
        try:
            estimations[record.details.name] = estimate_record(scenario, nominal, telemetry_only(record))
        except InputError as error:
            refused.append(str(error))
    if not estimations:
        raise InputError("\n".join(refused))
    for reason in refused:
        warn("left out", reason)
    return estimations


def _print_failures(name: str, estimation: Estimation) -> None:
    for estimator, message in estimation.failures.items():
        warn(f"{name}: {estimator} gave no estimate", message)
