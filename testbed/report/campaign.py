"""The page of a campaign: bias, scatter and coverage of every estimator beside the bound."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from testbed.campaign.plan import CampaignPlan, command_alone
from testbed.campaign.result import unestimated_of
from testbed.campaign.statistics import CampaignStatistics
from testbed.files import readable
from testbed.report.frame.blocks import Cell, Column, Notice, Page, Section, Table
from testbed.report.frame.page import write_page
from testbed.report.sections.campaign_chart import errors_figure
from testbed.report.sections.campaign_flights import flights_section
from testbed.report.sections.campaign_tables import estimators_table, statistics_tables
from testbed.report.sections.provenance import provenance_section
from testbed.report.verdict import campaign_verdict, is_biased
from testbed.report.wording import capitalized, estimator_name, figures

_MOST_LISTED = 200


def write_campaign_report(
    path: Path,
    *,
    plan: CampaignPlan,
    scenario_path: Path,
    table: pa.Table,
    statistics: CampaignStatistics,
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> None:
    """Write the page of a campaign, whole or not at all.

    Args:
        path: of the HTML file.
        plan: of the campaign.
        scenario_path: with which a run can be flown again alone.
        table: the runs.
        statistics: of them.
        provenance: as in `write_run_report`.
        result: what montecarlo.json holds.

    Raises:
        OutputError: the file cannot be written.
    """
    write_page(path, campaign_page(plan, scenario_path, table, statistics, provenance, result))


def campaign_page(
    plan: CampaignPlan,
    scenario_path: Path,
    table: pa.Table,
    statistics: CampaignStatistics,
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> Page:
    """Return the page of a campaign; arguments as above."""
    return Page(
        title=f"{statistics.runs} runs of {plan.scenario.name}, campaign seed {plan.seed}",
        subtitle=plan.scenario.description,
        verdict=campaign_verdict(statistics),
        notices=tuple(_notices(statistics)),
        sections=(
            *_estimates(table, statistics),
            flights_section(table),
            *_failures(table, plan, scenario_path),
            *_unestimated(table),
            provenance_section(provenance, "montecarlo.json", result),
        ),
    )


def _estimates(table: pa.Table, statistics: CampaignStatistics) -> Iterator[Section]:
    if statistics.estimators:
        yield Section(title="Estimates", blocks=(estimators_table(statistics), errors_figure(table, statistics)))
        yield Section(title="Bias, scatter, coverage", blocks=statistics_tables(statistics))


def _notices(statistics: CampaignStatistics) -> Iterator[Notice]:
    if statistics.failed:
        text = (
            f"{statistics.failed} of {statistics.runs} runs failed; they are listed below and left out of the figures."
        )
        yield Notice(tone="warn", text=text)
    for name, estimator in statistics.estimators.items():
        missing = statistics.runs - statistics.failed - estimator.runs
        if missing:
            who = capitalized(estimator_name(name))
            yield Notice(tone="warn", text=f"{who} gave no estimate in {missing} completed runs.")
        if is_biased(estimator):
            worst = float(abs(estimator.bias_in_standard_errors).max())
            yield Notice(
                tone="warn",
                text=f"{capitalized(estimator_name(name))} is biased: a mean lies {figures(worst, 2)} standard errors "
                "from the truth.",
            )


def _failures(table: pa.Table, plan: CampaignPlan, scenario_path: Path) -> Iterator[Section]:
    failed = table.filter(pc.not_equal(table["outcome"], "completed")).select(["run", "seed", "message"]).to_pylist()
    if not failed:
        return
    columns = (Column(title="Run"), Column(title="because"), Column(title="to see it"))
    source = shlex.quote(readable(str(scenario_path)))
    rows = tuple(
        (Cell(text=str(row["run"])), Cell(text=row["message"]), Cell(text=command_alone(plan, source, row["seed"])))
        for row in failed[:_MOST_LISTED]
    )
    note = "" if len(failed) <= _MOST_LISTED else f"The first {_MOST_LISTED} of {len(failed)}; all are in runs/."
    yield Section(title="Failed runs", blocks=(Table(columns=columns, rows=rows, note=note, numeric=False),))


def _unestimated(table: pa.Table) -> Iterator[Section]:
    unestimated = unestimated_of(table)
    if not unestimated:
        return
    columns = (Column(title="Estimator"), Column(title="runs"), Column(title="most often because"))
    rows = tuple(
        (Cell(text=estimator_name(each["estimator"])), Cell(text=str(each["runs"])), Cell(text=each["message"]))
        for each in unestimated
    )
    yield Section(title="Runs without an estimate", blocks=(Table(columns=columns, rows=rows, numeric=False),))
