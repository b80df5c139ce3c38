"""Table 3, figures 5 and 6: the zero-g campaign."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.arrays import Theta
from testbed.dynamics.inertia_unit import MILLI
from testbed.report.frame.blocks import Block, Column, Paragraph, Section, Table
from testbed.report.reproduction.figures import figure_blocks
from testbed.report.reproduction.rows import Row, inertia_row, parameter_columns, ratio_row, text_rows, uncertain_row
from testbed.reproduction.figures import data_figure, validation_figure
from testbed.reproduction.zero_g import PAPER_CAD_THETA, PAPER_THETA, Table3
from testbed.reproduction.zero_g_claims import COVERAGE

_START_NAMES = {
    "iv": "estimated with the inertia",
    "iv_from_zero": "taken for zero",
    "iv_from_first_sample": "taken from the first sample",
}
"""How the IV treats the prefilter's state at a start in motion."""


def table3_section(campaign: Table3) -> Section:
    """Return the combined estimate beside the paper's, each flight, coverage, start-up, and figures 5 and 6."""
    misfit = campaign.figure6
    blocks: tuple[Block, ...] = (
        _introduction(campaign),
        _combined_table(campaign),
        _flights_table(campaign),
        *figure_blocks(data_figure(campaign.figure5)),
        *figure_blocks(
            validation_figure(misfit),
            f"Solid: measured. Dashed: ψ θ̂ of the campaign. They differ by {misfit.estimated_misfit:.1%} of the "
            f"torque's root mean square; with the CAD model's inertia by {misfit.nominal_misfit:.1%}.",
        ),
        _startup_table(campaign),
        _coverage_table(campaign),
        _cuts_paragraph(campaign),
    )
    return Section(title="Table 3, figures 5 and 6", blocks=blocks)


def _introduction(campaign: Table3) -> Paragraph:
    return Paragraph(
        text="The platform flies with the inertia of the paper's estimate; controller, design and instrument believe "
        "the CAD model. It is released with a small spin and drift inside a cabin with walls, in MuJoCo, contacts on. "
        f"{len(campaign.flights)} flights at 16 Hz and 0.095 °/s, each cut at the first contact that its own record "
        "shows."
    )


def _combined_table(campaign: Table3) -> Table:
    combined = campaign.combined["iv"]
    deviations = (combined.theta - campaign.true_theta) / combined.std
    efficient = campaign.combined["output_error"]
    rows = (
        inertia_row("CAD model, paper and here", PAPER_CAD_THETA, tone="faint"),
        inertia_row("Estimate, paper", PAPER_THETA, tone="faint"),
        inertia_row("Truth here", campaign.true_theta),
        uncertain_row("Estimate here, IV, eq. (33)", combined.theta, combined.std, decimals=3),
        ratio_row("error / standard deviation", deviations, low=-3.0, high=3.0),
        uncertain_row("Estimate here, output error", efficient.theta, efficient.std, decimals=3),
    )
    return Table(
        columns=parameter_columns("Table 3"),
        rows=rows,
        note="± is one standard deviation as claimed. The paper has no truth to compare with, and claims no "
        "deviations.",
    )


def _flights_table(campaign: Table3) -> Table:
    columns = (Column(title="Flight"), Column(title="usable", unit="s"), *parameter_columns("")[1:])
    estimates = campaign.estimates["iv"]
    rows = text_rows(
        (f"{number}", f"{flight.usable:.2f}", *_pairs(estimate.theta, estimate.std))
        for number, (flight, estimate) in enumerate(zip(campaign.flights, estimates, strict=True), start=1)
    )
    return Table(columns=columns, rows=rows, note="The IV's estimate of each flight, combined above by eq. (33).")


def _pairs(theta: Theta, std: Theta) -> Iterator[str]:
    for value, one in zip(theta, std, strict=True):
        yield f"{MILLI.shown(value, 3)} ± {MILLI.shown(one, 3)}"


def _startup_table(campaign: Table3) -> Table:
    rows: list[Row] = []
    for name, title in _START_NAMES.items():
        coverage = campaign.coverage[name]
        rows += [
            inertia_row(f"{title}: mean error", coverage.mean_error, decimals=3),
            inertia_row("st.d.", coverage.std, decimals=3, tone="faint"),
        ]
    return Table(
        columns=parameter_columns("Momentum at the start"),
        rows=tuple(rows),
        note="The same records, three treatments of the prefilter's start, over all repetitions of the campaign. A "
        "filter started from zero on a record that starts in motion is biased, and with γ = 0.8 s the error outlives a "
        "record of 2 to 4 s; the first sample alone puts its noise on the whole record.",
    )


def _coverage_table(campaign: Table3) -> Table:
    low, high = COVERAGE
    rows: list[Row] = []
    for name, title in (("iv", "IV"), ("output_error", "output error")):
        coverage = campaign.coverage[name]
        rows += [
            ratio_row(f"{title}: share that holds the truth", coverage.share, low=low, high=high, tone="plain"),
            ratio_row("scatter / claimed standard deviation", coverage.std / coverage.claimed_std),
        ]
    campaigns = campaign.coverage["iv"].campaigns
    return Table(
        columns=parameter_columns(f"95 % intervals over {campaigns} campaigns", unit=""),
        rows=tuple(rows),
        note=f"Each campaign is {len(campaign.flights)} flights with noise, spin and drift of their own, combined. In "
        f"bold: beyond {low:.0%} to {high:.0%}. A share of {campaigns} campaigns has a standard error of "
        f"{np.sqrt(0.95 * 0.05 / campaigns):.1%}.",
    )


def _cuts_paragraph(campaign: Table3) -> Paragraph:
    cuts, usable = campaign.cuts, np.array(campaign.usable)
    return Paragraph(
        text=f"Of {cuts.flights} flights of the repetitions, {cuts.touched} met the wall and {cuts.too_short} were too "
        f"short to be used; {cuts.missed} were cut more than one sample late or not at all, {cuts.one_late} one sample "
        f"late, {cuts.one_early} one early, and {cuts.false_alarms} more than one sample early. Usable time: "
        f"{usable.min():.1f} to {usable.max():.1f} s, median {np.median(usable):.1f} s."
    )
