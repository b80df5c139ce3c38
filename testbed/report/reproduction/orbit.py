"""The paper's future work: a longer maneuver of an orbiting satellite."""

from __future__ import annotations

import numpy as np

from testbed.dynamics.inertia import theta_of
from testbed.dynamics.inertia_unit import MILLI
from testbed.experiment.experiment import Experiment
from testbed.report.frame.blocks import Block, Figure, Paragraph, Section, Table
from testbed.report.frame.chart import line_chart
from testbed.report.frame.series import signal_lines
from testbed.report.reproduction.rows import Row, inertia_row, parameter_columns, ratio_row, uncertain_row
from testbed.report.wording import capitalized, decimals_for, estimator_name


def orbit_section(experiment: Experiment) -> Section:
    """Return the maneuver and its estimates."""
    blocks: list[Block] = [_introduction(experiment), _rates(experiment), _gimbals(experiment)]
    if experiment.estimation is not None:
        blocks.insert(1, _table(experiment))
    return Section(title="An orbiting satellite", blocks=tuple(blocks))


def _introduction(experiment: Experiment) -> Paragraph:
    summary, duration = experiment.flown.summary, experiment.plan.maneuver.duration
    return Paragraph(
        text=f"{experiment.scenario.description} One flight of {duration:.0f} s through the same code, "
        f"{experiment.outcome}: tracking error {1e3 * float(np.max(summary.tracking_rms)):.2f} mrad/s rms at most, "
        f"{summary.saturated:.2g} s at a limit, momentum kept to {summary.momentum_drift:.0e} of the rotors'."
    )


def _table(experiment: Experiment) -> Table:
    estimation, truth = experiment.estimation, theta_of(experiment.truth.inertia)
    assert estimation is not None
    decimals = decimals_for(np.array([estimate.std for estimate in estimation.by_name.values()]), MILLI)
    rows: list[Row] = [
        inertia_row("True", truth, decimals=decimals),
        inertia_row("CAD model", theta_of(experiment.nominal.inertia), decimals=decimals),
    ]
    for name, estimate in estimation.by_name.items():
        rows.append(uncertain_row(capitalized(estimator_name(name)), estimate.theta, estimate.std, decimals=decimals))
        rows.append(ratio_row("error / standard deviation", (estimate.theta - truth) / estimate.std))
    if estimation.bound_std is not None:
        rows.append(inertia_row("Cramér-Rao bound", estimation.bound_std, decimals=decimals))
    return Table(
        columns=parameter_columns("One flight"), rows=tuple(rows), note="± is one standard deviation as claimed."
    )


def _rates(experiment: Experiment) -> Figure:
    maneuver = experiment.plan.maneuver
    time = np.linspace(0.0, maneuver.duration, 601)
    lines = signal_lines("reference_body_rate", time, maneuver.reference(time).body_rate)
    return Figure(title="Reference body rate, body axes", chart=line_chart(lines, y_title="body rate, rad/s"))


def _gimbals(experiment: Experiment) -> Figure:
    record = experiment.flown.record
    lines = signal_lines("true_gimbal_angle", record.time, record.channels["true_gimbal_angle"])
    return Figure(title="Gimbal angles as flown", chart=line_chart(lines, y_title="gimbal angle, rad"))
