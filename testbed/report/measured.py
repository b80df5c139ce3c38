"""The page of records measured elsewhere: estimates without a truth, and the telemetry that they come from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from testbed.arrays import Theta
from testbed.assembly.platform import Body
from testbed.dynamics.inertia import theta_of
from testbed.experiment.checking import NeglectedTorque
from testbed.experiment.experiment import Estimation
from testbed.identification.identify import Identification
from testbed.records.notices import grouped
from testbed.records.record import Record
from testbed.report.doubts import (
    combination_doubts,
    estimation_doubts,
    neglected_words,
    offset_interval_words,
    offset_words,
    other_body_doubts,
)
from testbed.report.frame.blocks import Notice, Page, Section
from testbed.report.frame.page import write_page
from testbed.report.sections.estimates import estimates_blocks
from testbed.report.sections.inertias import Inertias
from testbed.report.sections.provenance import provenance_section
from testbed.report.sections.residuals import residual_blocks
from testbed.report.sections.telemetry import telemetry_figures
from testbed.report.verdict import leading_estimator, measured_verdict
from testbed.report.wording import capitalized, estimator_name, listed
from testbed.scenario.body import BodyScenario

_WORTH_SAYING = 1.5
"""Ratio of two estimators' standard deviations from which the better one is pointed out.

Source: convention: as much as twice the data would bring."""
_DRAWN = (
    "applied_torque was taken to change in a smooth way from sample to sample; of torques that are held until the next "
    'one, as a flight computer commands thrusters, say so: [diagnosis] applied_torque = "held"'
)


def write_estimates_report(
    path: Path,
    *,
    scenario: BodyScenario,
    nominal: Body,
    identification: Identification,
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> None:
    """Write the page of the estimates from measured records, whole or not at all.

    Args:
        path: of the HTML file.
        scenario: the nominal model and the estimators.
        nominal: its platform.
        identification: the records and what they say.
        provenance: as in `write_run_report`.
        result: what estimates.json holds.

    Raises:
        OutputError: the file cannot be written.
    """
    write_page(path, estimates_page(scenario, nominal, identification, provenance, result))


def estimates_page(
    scenario: BodyScenario,
    nominal: Body,
    identification: Identification,
    provenance: Mapping[str, str],
    result: Mapping[str, Any],
) -> Page:
    """Return the page of the estimates from measured records; arguments as above."""
    theta, records = theta_of(nominal.inertia), identification.records
    overall = _overall(identification, theta)
    together = [Section(title="All records combined", blocks=estimates_blocks(overall))] if len(records) > 1 else []
    return Page(
        title=f"Inertia from measured records: {listed(record.details.name for record in records)}",
        subtitle=f"Nominal model and estimators: {scenario.name}. {scenario.description}",
        verdict=identification_verdict(identification, theta),
        notices=tuple(identification_notices(identification)),
        sections=(
            *together,
            *(_record_section(record, identification.estimations[record.details.name], theta) for record in records),
            provenance_section(provenance, "estimates.json", result),
        ),
    )


def identification_verdict(identification: Identification, nominal: Theta) -> Notice:
    """Return the verdict on measured records.

    Args:
        identification: the records and what they say.
        nominal: θ of the nominal model, kg·m².
    """
    overall = _overall(identification, nominal)
    return measured_verdict(overall, identification.what_is_combined, tuple(identification_doubts(identification)))


def identification_doubts(identification: Identification) -> Iterator[str]:
    """Yield what puts the inertia in doubt: of all records together, then of each."""
    if identification.nominal_theta is not None:
        yield from other_body_doubts(identification.combined.by_name, identification.nominal_theta)
    yield from combination_doubts(identification.combined)
    of_records = [
        (name, doubt)
        for name, estimation in identification.estimations.items()
        for doubt in estimation_doubts(estimation, len(identification.estimations))
    ]
    yield from grouped(of_records) if len(identification.records) > 1 else (doubt for _, doubt in of_records)


def identification_notices(identification: Identification) -> Iterator[Notice]:
    """Yield what a reader has to know of records and estimates before the numbers."""
    yield from (Notice(tone="warn", text=f"left out: {reason}") for reason in identification.refused)
    yield from (Notice(tone="plain", text=notice) for notice in identification.notices)
    for name, estimation in identification.estimations.items():
        for estimator, message in estimation.failures.items():
            text = f"{name}: {capitalized(estimator_name(estimator))} gave no estimate: {message}"
            yield Notice(tone="warn", text=text)
    doubts = [Notice(tone="warn", text=doubt) for doubt in identification_doubts(identification)]
    yield from doubts
    if doubts and identification.torque_drawn:
        yield Notice(tone="plain", text=_DRAWN)
    yield from _better_known(identification)
    yield from _offset_notices(identification)
    yield from (Notice(tone="plain", text=neglected_words(each)) for each in _neglected(identification))


def _better_known(identification: Identification) -> Iterator[Notice]:
    """Yield which estimator states less than the leading one, as what is uncertain of actuators adds up less in it.

    Output error believes the whole motion, and with it every error of a torque since the start; a prefilter forgets.
    """
    combined = identification.combined.by_name
    leading = leading_estimator(combined)
    sizes = {name: float(np.exp(np.mean(np.log(each.std)))) for name, each in combined.items()}
    least = min(sizes, key=lambda name: sizes[name])
    if sizes[leading] > _WORTH_SAYING * sizes[least]:
        yield Notice(
            tone="plain",
            text=f"{capitalized(estimator_name(least))} states {sizes[leading] / sizes[least]:.2g} times less than "
            f"{estimator_name(leading)}: what is uncertain of actuators and gyro adds up less in it; use its inertia",
        )


def _offset_notices(identification: Identification) -> Iterator[Notice]:
    """Yield where on a pivot the centre of mass was found: by all records together, and by each."""
    combined = identification.combined
    if combined.pivot is not None and combined.runs > 1:
        best = combined.by_name[leading_estimator(combined.by_name)]
        (text,) = offset_words(best, combined.pivot)
        interval = offset_interval_words(best, combined.pivot)
        yield Notice(tone="plain", text=f"{identification.what_is_combined} combined: {text} {interval}")
    for name, estimation in identification.estimations.items():
        if estimation.checks is not None:
            for text in offset_words(estimation.by_name[estimation.checks.best], estimation.pivot):
                yield Notice(tone="plain", text=f"{name}: {text}")


def _neglected(identification: Identification) -> list[NeglectedTorque]:
    """Return the constant torques that are not estimated, each from the record that is the most sensitive to it."""
    checks = [each.checks for each in identification.estimations.values() if each.checks is not None]
    found = sorted((each for check in checks for each in check.neglected), key=lambda each: -each.size)
    return list({each.frame: each for each in found}.values())


def _overall(identification: Identification, nominal: Theta) -> Inertias:
    return Inertias(by_name=identification.combined.by_name, bound_std=None, nominal=nominal, truth=None)


def _record_section(record: Record, estimation: Estimation, nominal: Theta) -> Section:
    blocks = (
        *estimates_blocks(_inertias(estimation, nominal)),
        *telemetry_figures(record),
        *residual_blocks(estimation.by_name),
    )
    return Section(title=f"Record {record.details.name}", blocks=blocks)


def _inertias(estimation: Estimation, nominal: Theta) -> Inertias:
    return Inertias(by_name=estimation.by_name, bound_std=estimation.bound_std, nominal=nominal, truth=None)
