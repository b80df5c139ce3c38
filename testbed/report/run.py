"""The page of a run: from its verdict to its provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from testbed.dynamics.inertia import theta_of
from testbed.experiment.experiment import Experiment
from testbed.report.doubts import estimation_doubts
from testbed.report.frame.blocks import Notice, Page, Section
from testbed.report.frame.page import write_page
from testbed.report.notices import estimation_notices, flight_notices
from testbed.report.sections.actuators import actuators_section
from testbed.report.sections.conservation import conservation_section
from testbed.report.sections.design import design_section
from testbed.report.sections.estimates import estimates_blocks
from testbed.report.sections.failures import failures_table
from testbed.report.sections.inertias import Inertias
from testbed.report.sections.maneuver import maneuver_section
from testbed.report.sections.provenance import provenance_section
from testbed.report.sections.residuals import residual_blocks
from testbed.report.sections.tracking import tracking_section
from testbed.report.verdict import diverged_verdict, flight_verdict


def write_run_report(
    path: Path, experiment: Experiment, provenance: Mapping[str, str], result: Mapping[str, Any]
) -> None:
    """Write the page of a run, whole or not at all.

    Args:
        path: of the HTML file.
        experiment: the run; of a diverged one the page shows what there is.
        provenance: what made the run; a value of several lines, such as the scenario's text, is listed as it is.
        result: what result.json holds.

    Raises:
        OutputError: the file cannot be written.
    """
    write_page(path, run_page(experiment, provenance, result))


def run_page(experiment: Experiment, provenance: Mapping[str, str], result: Mapping[str, Any]) -> Page:
    """Return the page of a run; arguments as above."""
    inertias = _inertias(experiment)
    return Page(
        title=f"Run of {experiment.scenario.name}, seed {experiment.seed}",
        subtitle=experiment.scenario.description,
        verdict=run_verdict(experiment),
        notices=tuple(run_notices(experiment)),
        sections=(*_sections(experiment, inertias), provenance_section(provenance, "result.json", result)),
    )


def _inertias(experiment: Experiment) -> Inertias | None:
    estimation = experiment.estimation
    if estimation is None:
        return None
    return Inertias(
        by_name=estimation.by_name,
        bound_std=estimation.bound_std,
        nominal=theta_of(experiment.nominal.inertia),
        truth=theta_of(experiment.truth.inertia),
    )


def run_verdict(experiment: Experiment) -> Notice:
    """Return the verdict on a run."""
    inertias = _inertias(experiment)
    if inertias is None or experiment.estimation is None:
        return diverged_verdict()
    return flight_verdict(inertias, tuple(estimation_doubts(experiment.estimation)))


def run_notices(experiment: Experiment) -> Iterator[Notice]:
    """Yield what spoils a run or puts its figures in doubt, and what is neglected."""
    yield from flight_notices(experiment.flown)
    estimation, inertias = experiment.estimation, _inertias(experiment)
    if estimation is not None and inertias is not None:
        yield from estimation_notices(inertias, estimation)


def _sections(experiment: Experiment, inertias: Inertias | None) -> Iterator[Section]:
    flown, estimation, design = experiment.flown, experiment.estimation, experiment.plan.design
    if inertias is not None and inertias.by_name:
        yield Section(title="Estimates", blocks=estimates_blocks(inertias))
    yield maneuver_section(experiment.plan.maneuver, flown.record)
    yield tracking_section(flown.record, flown.summary)
    yield actuators_section(experiment)
    if estimation is not None and estimation.by_name:
        yield Section(title="Residuals", blocks=residual_blocks(estimation.by_name))
    yield conservation_section(flown.record, flown.summary, experiment.truth)
    if design is not None:
        yield design_section(design)
    if estimation is not None and estimation.failures:
        yield Section(title="Estimators that failed", blocks=(failures_table(estimation.failures),))
