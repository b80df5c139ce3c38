"""The page of a campaign: one file, every estimator in chart and tables, every failed run with a way to see it."""

from __future__ import annotations

import re

import pytest

from support.campaigns import Pretended, plan_of, small_scenario
from testbed.campaign.plan import blocks_of
from testbed.campaign.run import run_campaign
from testbed.campaign.statistics import statistics_of
from testbed.report.campaign import write_campaign_report


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    return plan_of(small_scenario(tmp_path_factory.mktemp("scenario")), 60)


def written(path, plan, table):
    write_campaign_report(
        path,
        plan=plan,
        scenario_path=path.parent / "a scenario.toml",
        table=table,
        statistics=statistics_of(table),
        provenance={"scenario": "small"},
        result={"runs": len(table)},
    )
    return path.read_text(encoding="utf-8")


def test_the_page_shows_every_estimator_beside_the_bound(plan, tmp_path):
    page = written(tmp_path / "report.html", plan, run_campaign(plan, None, Pretended()))
    for text in ("60 runs of small, campaign seed 5", "Least squares", "Output error", "Cramér-Rao bound"):
        assert text in page
    (chart,) = re.findall(r'<script type="application/json">(.*?)</script>', page)
    assert chart.count('"type":"box"') == 2
    assert '"name":"bound"' in chart
    assert "NaN" not in chart
    assert "Failed runs" not in page


def test_failed_runs_are_listed_with_the_command_that_flies_them(plan, tmp_path):
    failing = Pretended()
    table = run_campaign(plan, None, failing)
    outcome = table["outcome"].to_pylist()
    outcome[7] = "failed"
    index = table.column_names.index("outcome")
    table = table.set_column(index, table.schema.field(index), [outcome])
    page = written(tmp_path / "report.html", plan, table)
    seed = next(blocks_of(plan)).seeds[7]
    assert "1 of 60 runs failed" in page
    assert f"--dispersed --seed {seed}" in page
    assert "&#39;" in page.split("--dispersed")[0].rsplit("testbed run", 1)[1]  # a path with a blank is quoted


def test_nothing_but_failures_makes_a_page_too(plan, tmp_path):
    table = run_campaign(plan, None, Pretended())
    index = table.column_names.index("outcome")
    table = table.set_column(index, table.schema.field(index), [["failed"] * len(table)])
    page = written(tmp_path / "report.html", plan, table)
    assert "No estimator gave two estimates" in page
