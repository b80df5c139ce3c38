"""Table 2: the scatter of the estimates over many closed-loop flights, beside the paper's and beside the bound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbed.report.frame.blocks import Block, Cell, Column, Paragraph, Section, Table
from testbed.report.reproduction.box_plot import box_plot_figure
from testbed.report.reproduction.rows import Row, inertia_row, parameter_columns, ratio_row, uncertain_row
from testbed.report.wording import estimator_name
from testbed.reproduction.claims import (
    MOST_BIAS,
    MOST_OVER_BOUND,
    PAPER_MARGIN,
    SHARE_OF_PAPER,
    best_estimator,
    unexplained_bias,
)
from testbed.reproduction.gains import gains_of
from testbed.reproduction.table2 import (
    LIKE_FOR_LIKE,
    OWN,
    PAPER_PEAK_RATE,
    PAPER_RUNS,
    PAPER_STD,
    ManeuverStatistics,
    standard_error_of_std,
)


def table2_section(maneuvers: Sequence[ManeuverStatistics]) -> Section:
    """Return Table 2 as the paper did it, with this project's maneuver, figure 3, and with every estimator."""
    published = [maneuver for maneuver in maneuvers if maneuver.paper_std is not None]
    own = [maneuver for maneuver in maneuvers if maneuver.paper_std is None]
    blocks: tuple[Block, ...] = (
        _introduction(maneuvers),
        _paper_table(published),
        *map(_own_table, own),
        _gains(maneuvers),
        box_plot_figure(maneuvers),
        _every_estimator(maneuvers),
    )
    return Section(title="Table 2 and figure 3", blocks=blocks)


def _introduction(maneuvers: Sequence[ManeuverStatistics]) -> Paragraph:
    failed = sum(maneuver.statistics.failed for maneuver in maneuvers)
    runs = maneuvers[0].statistics.runs
    outcome = "All were flown to their end" if not failed else f"{failed} of all flights failed and are left out"
    return Paragraph(
        text=f"{runs} closed-loop flights of each maneuver in MuJoCo at σ = 0.025 rad/s, 16 Hz, 5 s: six gimbals that "
        f"move, and a controller that reads the noisy gyro. {outcome}. The paper's numbers are of "
        f"{PAPER_RUNS} runs; their own standard deviations are uncertain by 7 %."
    )


def _paper_table(maneuvers: Sequence[ManeuverStatistics]) -> Table:
    return Table(
        columns=parameter_columns("Instrumental variable"),
        rows=tuple(row for maneuver in maneuvers for row in _paper_rows(maneuver)),
        note="As the paper did it. ± is the standard error of a mean or of a standard deviation. In bold: a ratio more "
        f"than {PAPER_MARGIN:.0%} from 1, or a bias more than {MOST_BIAS} standard errors from theory's. The estimator "
        "is consistent, not unbiased: its bias in theory is of second order in the noise, computed from regressor, "
        "instrument and noise of a flight whose gyro is quiet.",
    )


def _paper_rows(maneuver: ManeuverStatistics) -> Iterator[Row]:
    ours = maneuver.statistics.estimators["iv"]
    assert maneuver.paper_mean is not None
    assert maneuver.paper_std is not None
    ratio = ours.std / maneuver.paper_std
    yield inertia_row(f"{maneuver.title}, avg., paper", maneuver.paper_mean, tone="faint")
    yield uncertain_row(f"{maneuver.title}, avg., here", ours.mean, ours.std / np.sqrt(ours.runs))
    yield inertia_row(f"{maneuver.title}, st.d., paper", maneuver.paper_std, tone="faint")
    yield uncertain_row(f"{maneuver.title}, st.d., here", ours.std, standard_error_of_std(ours.std, ours.runs))
    yield ratio_row("here / paper", ratio, low=1.0 - PAPER_MARGIN, high=1.0 + PAPER_MARGIN)
    yield inertia_row(f"{maneuver.title}, bias in theory", maneuver.predicted_iv_bias, tone="faint")
    yield ratio_row("bias less theory, standard errors", unexplained_bias(maneuver), low=-MOST_BIAS, high=MOST_BIAS)


def _own_table(maneuver: ManeuverStatistics) -> Table:
    name, like_for_like = best_estimator(maneuver), maneuver.name == LIKE_FOR_LIKE
    ours, paper = maneuver.statistics.estimators[name], PAPER_STD["paper_d_optimal"]
    most = 1.0 if like_for_like else SHARE_OF_PAPER
    speed = "as fast as the paper's" if like_for_like else f"the paper's turns at {PAPER_PEAK_RATE} rad/s"
    rows = (
        inertia_row("D-opt, st.d., paper", paper, tone="faint"),
        uncertain_row("avg.", ours.mean, ours.std / np.sqrt(ours.runs)),
        uncertain_row("st.d.", ours.std, standard_error_of_std(ours.std, ours.runs), decimals=3),
        ratio_row("st.d. / paper's D-opt", ours.std / paper, high=most),
        inertia_row("Cramér-Rao bound", maneuver.statistics.bound_std, decimals=3),
        ratio_row("st.d. / bound", ours.scatter_over_bound, high=MOST_OVER_BOUND),
        ratio_row("95 % intervals that hold the truth", ours.coverage),
    )
    return Table(
        columns=parameter_columns(f"{maneuver.title}: {estimator_name(name)}"),
        rows=rows,
        note="A maneuver designed for the gimbal angles inside the cluster's own limits, at the paper's noise, "
        f"duration, sample rate and limits of eq. (31); largest rate {maneuver.peak_rate:.2f} rad/s, {speed}. In bold: "
        f"more than {most} of the paper's D-opt row, or more than {MOST_OVER_BOUND - 1:.0%} above the bound.",
    )


def _gains(maneuvers: Sequence[ManeuverStatistics]) -> Table:
    by_name = {maneuver.name: maneuver for maneuver in maneuvers}
    shares = gains_of(by_name["paper_d_optimal"], by_name[LIKE_FOR_LIKE], by_name[OWN])
    rows = (
        ratio_row("D-opt as flown here, IV, over the paper's row", shares.reproduction),
        ratio_row("the estimator: output error over IV, D-opt", shares.estimator, tone="plain"),
        ratio_row(f"the maneuver: {by_name[LIKE_FOR_LIKE].title} over D-opt", shares.maneuver, tone="plain"),
        ratio_row(f"the rate: {by_name[OWN].title} over {by_name[LIKE_FOR_LIKE].title}", shares.rate, tone="plain"),
        ratio_row(f"all: {by_name[OWN].title} over the paper's row", shares.total, tone="plain"),
    )
    return Table(
        columns=parameter_columns("What gains how much: ratio of standard deviations", unit=""),
        rows=rows,
        note="The last row is the product of those above it. Maneuver and rate by output error. Designed alike, "
        f"{by_name[LIKE_FOR_LIKE].title} turns at up to {by_name[LIKE_FOR_LIKE].peak_rate:.2f} rad/s, as the paper's "
        f"D-opt does, and {by_name[OWN].title} at up to {by_name[OWN].peak_rate:.2f}, which eq. (31) allows.",
    )


def _every_estimator(maneuvers: Sequence[ManeuverStatistics]) -> Table:
    columns = (
        *parameter_columns("Every estimator: st.d."),
        Column(title="st.d. / bound"),
        Column(title="largest bias", unit="standard errors"),
    )
    return Table(
        columns=columns,
        rows=tuple(row for maneuver in maneuvers for row in _estimator_rows(maneuver)),
        note=f"On the same flights. In bold: a bias beyond {MOST_BIAS} standard errors; least squares is biased "
        "because its regressor holds the gyro's noise. The bound is that of the motion as flown.",
    )


def _estimator_rows(maneuver: ManeuverStatistics) -> Iterator[Row]:
    for name, one in maneuver.statistics.estimators.items():
        ratio, bias = one.scatter_over_bound, float(np.abs(one.bias_in_standard_errors).max())
        yield (
            *inertia_row(f"{maneuver.title}: {estimator_name(name)}", one.std, decimals=3),
            Cell(text=f"{ratio.min():.2f} to {ratio.max():.2f}"),
            Cell(text=f"{bias:.1f}", tone="warn" if bias > MOST_BIAS else "plain"),
        )
    bound = inertia_row(f"{maneuver.title}: Cramér-Rao bound", maneuver.statistics.bound_std, decimals=3, tone="faint")
    yield (*bound, Cell(text=""), Cell(text=""))
