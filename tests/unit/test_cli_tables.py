"""Tables of inertias in the terminal: as many decimals as the smallest standard deviation needs and 80 columns hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from support.report_runs import flight
from testbed.cli.tables import estimate_table
from testbed.report.wording import ESTIMATOR_NAMES

WIDTH = 80


def printed(std, theta):
    estimation = flight().estimation
    covariance = np.diag(np.square(std))
    considered = 0.1 * np.array(std)[:, None]  # for rows by noise alone
    answer = replace(
        estimation.by_name["output_error"],
        theta=theta,
        covariance=covariance,
        considered=considered,
        considered_kinds=(),
    )
    shown = replace(estimation, by_name=dict.fromkeys(ESTIMATOR_NAMES, answer), bound_std=np.array(std))
    console = Console(width=WIDTH)
    with console.capture() as capture:
        console.print(estimate_table("", {"nominal": theta}, shown))
    return capture.get()


@pytest.mark.parametrize(
    ("std", "theta", "cell"),
    [
        (3.1e-5, 0.022, "±0.0310"),  # 1e-3 kg·m², four decimals as ever
        (2.3e-8, 0.022, "±0.00002"),  # a fifth has room
        (2.3e-8, 0.0166e-3, "±0.0230"),  # 1e-6 kg·m²
        (2.3e-12, 0.0166e-3, "±2e-06"),  # no decimals that have room show it
        (2.3e-9, 0.167, "±2e-06"),
        (0.41, 78.0, "±0.4100"),  # kg·m²
        (0.0, 0.022, "±0.0000"),
    ],
)
def test_a_standard_deviation_is_zero_only_where_it_is(std, theta, cell):
    text = printed([std] * 6, np.array([theta, theta, theta, 0.0, -0.1 * theta, 0.0]))
    assert cell in text
    assert "…" not in text
    assert "J12" in text  # a table that is too wide loses its last column
    assert max(map(len, text.splitlines())) <= WIDTH
