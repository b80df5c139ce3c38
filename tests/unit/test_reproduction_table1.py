"""Table 1: every maneuver of the paper in three ways, each row the figures of its own maneuver."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
import pytest

from testbed.maneuver.information import maneuver_information
from testbed.reproduction import table1 as module
from testbed.reproduction.table1 import CRITERIA, PAPER, table1


@pytest.fixture(scope="module")
def table():
    """The table without its gimbal-space rows, which take half a minute and have tests of their own."""
    progress = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_gimbal_tasks", lambda _quick: [])
        made = table1(lambda part, items: progress.append((part, items)) or progress.append, quick=True)
    assert progress == [("Table 1, designs", 8), *[1] * 8]
    return made


def test_the_rows_stand_in_the_papers_order(table):
    assert [(row.way, row.name) for row in table.rows] == [
        ("given", "basic"),
        *(("paper", criterion) for criterion in CRITERIA),
        *(("hard", criterion) for criterion in CRITERIA),
    ]
    assert all(row.paper is PAPER[row.name] for row in table.rows)


def test_a_row_says_what_its_maneuver_is(table):
    for row in table.rows:
        information = maneuver_information(table.maneuvers[row.way, row.name], 16.0, 0.8)
        assert row.determinant == information.determinant
        assert row.regressor_condition_number**2 == pytest.approx(row.condition_number)


@pytest.mark.parametrize(("way", "slack"), [("paper", 0.03), ("hard", 1e-4)])
def test_each_criterion_improves_on_d_in_its_own_figure(table, way, slack):
    """All start from the D optimum. Log det weighs six times log trace: with the penalty, D bends the limits more."""
    rows = {row.name: row for row in table.rows if row.way == way}
    assert rows["A"].trace_inverse <= rows["D"].trace_inverse * (1 + slack)
    assert rows["E"].min_eigenvalue >= rows["D"].min_eigenvalue * (1 - slack)
    assert rows["condition"].condition_number <= rows["D"].condition_number * (1 + slack)


def test_every_design_improves_on_the_basic_profile_and_keeps_its_peak(table):
    basic, *designs = table.rows
    for row in designs:
        assert row.min_eigenvalue > 5 * basic.min_eigenvalue
        assert row.peak_rate < 0.3 * 1.03  # the penalty bends its limits by up to 3 %


def test_the_rows_are_json(table):
    rows = json.loads(json.dumps([asdict(row) for row in table.rows]))
    assert rows[0]["paper"]["trace_inverse"] == 21.27
    assert np.isfinite([row["seconds"] for row in rows]).all()
