"""The page of records measured elsewhere: estimates without a truth, and the telemetry that they come from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from testbed.arrays import Theta
from testbed.assembly.platform import PlatformModel
from testbed.dynamics.inertia import theta_of
from testbed.experiment.experiment import CombinedEstimation, Estimation
from testbed.records.record import Record
from testbed.report.frame.blocks import Notice, Page, Section
from testbed.report.frame.page import write_page
from testbed.report.notices import estimation_notices
from testbed.report.sections.estimates import estimates_blocks
from testbed.report.sections.inertias import Inertias
from testbed.report.sections.provenance import provenance_section
from testbed.report.sections.residuals import residual_blocks
from testbed.report.sections.telemetry import telemetry_figures
from testbed.report.verdict import measured_verdict
from testbed.report.wording import listed
from testbed.scenario.scenario import Scenario


def write_estimates_report(
    path: Path,
    *,
    scenario: Scenario,
    nominal: PlatformModel,
    records: Sequence[Record],
    estimations: Mapping[str, Estimation],
    combined: CombinedEstimation,
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> None:
    """Write the page of the estimates from measured records, whole or not at all.

    Args:
        path: of the HTML file.
        scenario: the nominal model and the estimators.
        nominal: its platform.
        records: what was measured.
        estimations: by the record's name.
        combined: of all records.
        provenance: as in `write_run_report`.
        result: what estimates.json holds.

    Raises:
        InputError: the file cannot be written.
    """
    theta = theta_of(nominal.inertia)
    overall = Inertias(by_name=combined.by_name, bound_std=None, nominal=theta, truth=None)
    together = [Section(title="All records combined", blocks=estimates_blocks(overall))] if len(records) > 1 else []
    page = Page(
        title=f"Inertia from measured records: {listed(record.details.name for record in records)}",
        subtitle=f"Nominal model and estimators: {scenario.name}. {scenario.description}",
        verdict=measured_verdict(overall, len(records)),
        notices=tuple(_notices(estimations, theta)),
        sections=(
            *together,
            *(_record_section(record, estimations[record.details.name], theta) for record in records),
            provenance_section(provenance, result),
        ),
    )
    write_page(path, page)


def _notices(estimations: Mapping[str, Estimation], nominal: Theta) -> Iterator[Notice]:
    for name, estimation in estimations.items():
        for notice in estimation_notices(_inertias(estimation, nominal), estimation.failures):
            yield Notice(tone=notice.tone, text=f"{name}: {notice.text}")


def _record_section(record: Record, estimation: Estimation, nominal: Theta) -> Section:
    blocks = (
        *estimates_blocks(_inertias(estimation, nominal)),
        *telemetry_figures(record),
        *residual_blocks(estimation.by_name),
    )
    return Section(title=f"Record {record.details.name}", blocks=blocks)


def _inertias(estimation: Estimation, nominal: Theta) -> Inertias:
    return Inertias(by_name=estimation.by_name, bound_std=estimation.bound_std, nominal=nominal, truth=None)
