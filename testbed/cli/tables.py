"""What a run's figures look like in the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from testbed.arrays import Theta
from testbed.campaign.statistics import CampaignStatistics
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.dynamics.inertia_unit import InertiaUnit, inertia_unit
from testbed.estimation.body import is_body
from testbed.experiment.experiment import CombinedEstimation, Estimation, Experiment
from testbed.experiment.flying import FlownRun
from testbed.maneuver.design import Design
from testbed.report.wording import decimals_for, estimator_name

_CELL = 8
"""Characters of a number with which six columns without padding, beside the longest label, are within 80."""
_DECIMALS = 4
"""Of the unit, where these show the smallest standard deviation."""
_LOST = 100.0
"""Times the largest number of the known inertia beyond which an answer is that of an estimator that lost its way: it is
written with an exponent, and takes no decimals from the others."""


def estimate_table(title: str, rows: Mapping[str, Theta], estimation: Estimation | CombinedEstimation) -> Table:
    """Return a table of inertia parameters.

    Args:
        title: that the table is of an inertia, and of what; the unit follows it.
        rows: θ to show first, such as the truth, by label, kg·m²; the first one decides the unit.
        estimation: the estimates, and the bound below them.
    """
    unit = inertia_unit(next(iter(rows.values())))
    table = parameter_table(f"{title} in {unit.text}, ± one standard deviation")
    bound = estimation.bound_std if isinstance(estimation, Estimation) else None
    estimates = estimation.by_name.values()
    stds = [*(std for each in estimates for std in (each.std, each.noise_std)), *([] if bound is None else [bound])]
    decimals = _decimals([*rows.values(), *(each.theta for each in estimates)], stds, unit)
    _make_room(table, decimals)
    cells = partial(_cells, decimals, unit)
    for label, theta in rows.items():
        table.add_row(label, *cells(theta))
    table.add_section()
    for name, estimate in estimation.by_name.items():
        table.add_row(estimator_name(name), *cells(estimate.theta))
        table.add_row("", *cells(estimate.std, "±"), style="dim")
        if not np.array_equal(estimate.std, estimate.noise_std):
            table.add_row("  by noise alone", *cells(estimate.noise_std, "±"), style="dim")
        if not is_body(estimate.theta):
            table.add_row("  nearest body's", *cells(estimate.body_theta), style="dim")
    if bound is not None:
        table.add_section()
        table.add_row("Cramér-Rao bound", *cells(bound, "±"))
    return table


def statistics_table(statistics: CampaignStatistics) -> Table:
    """Return the table of a campaign: truth, each estimator's mean, scatter, bias and coverage, the bound."""
    unit = inertia_unit(statistics.true_theta)
    table = parameter_table(f"Inertia in {unit.text}, mean over the runs ± their scatter")
    estimators = statistics.estimators.values()
    decimals = _decimals(
        [statistics.true_theta, *(each.mean for each in estimators)],
        [statistics.bound_std, *(each.std for each in estimators)],
        unit,
    )
    _make_room(table, decimals)
    cells = partial(_cells, decimals, unit)
    table.add_row("true", *cells(statistics.true_theta))
    for name, figures in statistics.estimators.items():
        table.add_section()
        table.add_row(estimator_name(name), *cells(figures.mean))
        table.add_row("", *cells(figures.std, "±"))
        table.add_row("  bias / standard error", *_plain(figures.bias_in_standard_errors, "+.1f"), style="dim")
        table.add_row("  scatter / bound", *_plain(figures.scatter_over_bound, ".2f"), style="dim")
        table.add_row("  in its 95 % interval", *_plain(figures.coverage, ".1%"), style="dim")
    table.add_section()
    table.add_row("Cramér-Rao bound", *cells(statistics.bound_std, "±"))
    return table


def offset_lines(statistics: CampaignStatistics) -> Iterator[str]:
    """Return what a campaign says of the centre of mass on an air bearing, a line for each estimator."""
    for name, figures in statistics.estimators.items():
        if figures.offset is None:
            continue
        offset = figures.offset
        found = ", ".join(f"{1e6 * at:.3f} ± {1e6 * std:.3f}" for at, std in zip(offset.mean, offset.std, strict=True))
        yield f"Centre of mass by {estimator_name(name)}: {found} µm"
        covered = ", ".join(_plain(offset.coverage, ".1%"))
        ratio = ", ".join(_plain(offset.scatter_over_bound, ".2f"))
        yield f"           scatter / bound {ratio}; in its 95 % interval {covered}"


def parameter_table(title: str) -> Table:
    """Return an empty table with a column for each inertia parameter."""
    table = plain_table(title)
    table.add_column(no_wrap=True)
    for name in PARAMETER_NAMES:
        table.add_column(name, justify="right", no_wrap=True)
    return table


def plain_table(title: str) -> Table:
    """Return an empty table without columns."""
    return Table(
        title=Text(title),
        title_justify="left",
        title_style="bold",
        box=SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )


def _plain(values: Theta, form: str) -> Iterator[str]:
    return (format(value, form) for value in values)


def _decimals(values: Sequence[Theta], stds: Sequence[Theta], unit: InertiaUnit) -> list[int]:
    """Return how many decimals of each parameter show the smallest standard deviation, as many as the width allows.

    Args:
        values: of the table, the known inertia first.
        stds: of its standard deviations.
        unit: of the numbers.
    """
    lost = _LOST * np.abs(values[0]).max()
    columns = [
        [
            *(unit.shown(value, 0) for value in of_values if abs(value) < lost),
            *(f"±{unit.shown(std, 0)}" for std in of_stds if std < lost),
        ]
        for of_values, of_stds in zip(zip(*values, strict=True), zip(*stds, strict=True), strict=True)
    ]
    room = [max(_CELL - max(map(len, cells), default=0) - len("."), 0) for cells in columns]
    wanted = max(decimals_for(np.concatenate([*stds, []]), unit), _DECIMALS)
    return [min(wanted, max(min(room), _DECIMALS), each) for each in room]


def _make_room(table: Table, decimals: Sequence[int]) -> None:
    """Take the padding off a table whose numbers have further decimals; one that is too wide would lose a column."""
    if max(decimals) > _DECIMALS:
        table.padding = (0, 0)


def _cells(decimals: Sequence[int], unit: InertiaUnit, values: Theta, sign: str = "") -> Iterator[str]:
    for value, shown in zip(unit.per_SI * values, decimals, strict=True):
        text = f"{sign}{value:z.{shown}f}"
        vanishes = sign and 0.0 < abs(value) < 0.5 * 10.0**-shown
        if vanishes:
            yield f"{sign}{value:.0e}"  # shorter than the decimals, so that it widens no column
        else:
            yield text if len(text) <= _CELL + len(sign) else f"{sign}{value:.1e}"


def design_lines(design: Design | None) -> Iterator[str]:
    """Return a design's figures, a line each; none where nothing was designed."""
    if design is None:
        return
    of, space = design.information, design.parametrization.replace("_", "-")
    kept = sum(np.isfinite(start.cost) for start in design.starts)
    best = "one start" if kept == 1 else f"best of {kept} starts"
    yield f"Design     {design.criterion}-optimal in {space} space, {best}, {design.seconds:.1f} s each"
    yield f"           of Ψ_fᵀΨ_f: smallest eigenvalue {of.min_eigenvalue:.2f}, determinant {of.determinant:.3g},"
    yield f"           trace of the inverse {of.trace_inverse:.3f}, condition number {of.condition_number:.2f}"


def flight_lines(flown: FlownRun) -> Iterator[str]:
    """Return a flight's figures, a line each."""
    summary = flown.summary
    if flown.divergence:
        yield f"DIVERGED   {flown.divergence}"
    rms = ", ".join(f"{value:.2g}" for value in summary.tracking_rms)
    yield f"Tracking   rms error {rms} rad/s; {summary.saturated:.3g} s at a limit"
    used = ", ".join(f"{name.replace('_', ' ')} {share:.0%}" for name, share in summary.limit_use.items())
    yield f"Limits     {used}"
    if summary.min_singularity_measure is not None:
        yield f"           smallest singularity measure {summary.min_singularity_measure:.2f} (1 at the best)"
    if summary.rotor_clamped:
        yield f"Rotors     {summary.rotor_clamped:.3g} s with a rotor or wheel at its momentum limit"
    if flown.first_contact is not None:
        yield f"Contact    with the cabin at {flown.first_contact:.3f} s; the estimates use the record up to there"
    if flown.tilt_limit is not None:
        yield f"Tilt       {summary.largest_tilt:.3g} rad from the vertical at the most"
    yield f"Momentum   drift {summary.momentum_drift:.1e} of the rotors' total"


def result_table(experiment: Experiment) -> Table:
    """Return a run's result table: true and nominal inertia, the estimates, the bound."""
    assert experiment.estimation is not None
    known = {"true": theta_of(experiment.truth.inertia), "nominal": theta_of(experiment.nominal.inertia)}
    return estimate_table("Inertia", known, experiment.estimation)
