"""What has to be said up front: whatever spoils a run or puts its figures in doubt."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.experiment.experiment import Estimation
from testbed.experiment.flying import FlownRun
from testbed.report.doubts import estimation_doubts, neglected_words, offset_words, torque_words
from testbed.report.frame.blocks import Notice
from testbed.report.sections.inertias import Inertias
from testbed.report.wording import capitalized, estimator_name, figures, listed
from testbed.signals import FLAGS, KINDS, LIMITS

NEAR_SINGULARITY = 0.05
"""Singularity measure below which steering is poor; 1 at the best."""
LARGE_DRIFT = 1e-6
"""Relative drift of the total momentum that integration does not cause: 4e-8 or better at the shipped steps."""
LARGE_ERROR = 4.0
"""Standard deviations; noise exceeds it in one estimate of 16,000."""


def flight_notices(flown: FlownRun) -> Iterator[Notice]:
    """Yield what a flight did wrong: divergence, saturation, limits exceeded, singularity, drift of momentum."""
    if flown.divergence:
        yield Notice(tone="bad", text=capitalized(flown.divergence))
    yield from _saturation(flown)
    summary = flown.summary
    beyond = [LIMITS[name] for name, share in summary.limit_use.items() if share > 1.0]
    if beyond:
        yield _warning(f"Beyond its limit: {listed(beyond)}; the table of limits says by how much.")
    if summary.min_singularity_measure is not None and summary.min_singularity_measure < NEAR_SINGULARITY:
        measure = figures(summary.min_singularity_measure, 2)
        yield _warning(f"The cluster came close to a singularity: its measure fell to {measure}, 1 is the best.")
    if flown.tilt_limit is not None and summary.largest_tilt > flown.tilt_limit:
        tilt, limit = figures(summary.largest_tilt, 3), figures(flown.tilt_limit, 3)
        yield _warning(f"The platform tilted by {tilt} rad, but its bearing allows {limit} rad.")
    if summary.momentum_drift > LARGE_DRIFT:
        drift = figures(summary.momentum_drift, 2)
        yield _warning(
            f"The total momentum changed by {drift} of the rotors': an external torque, a contact, or too long a step."
        )


def estimation_notices(inertias: Inertias, estimation: Estimation) -> Iterator[Notice]:
    """Yield estimators that gave no estimate, doubts, errors that noise does not explain, and what is neglected."""
    for name, message in estimation.failures.items():
        yield _warning(f"{capitalized(estimator_name(name))} gave no estimate: {message}")
    yield from map(_warning, estimation_doubts(estimation))
    yield from _errors(inertias)
    if estimation.checks is None or estimation.checks.best not in estimation.by_name:
        return
    best = estimation.by_name[estimation.checks.best]
    for text in (*torque_words(best), *offset_words(best, estimation.pivot)):
        yield Notice(tone="plain", text=text)
    for neglected in estimation.checks.neglected:
        yield Notice(tone="plain", text=neglected_words(neglected))


def _errors(inertias: Inertias) -> Iterator[Notice]:
    if inertias.truth is None:
        return
    for name in inertias.by_name:
        ratio = np.abs(inertias.ratio(name))
        if ratio.max() > LARGE_ERROR:
            worst = PARAMETER_NAMES[int(np.argmax(ratio))]
            yield _warning(
                f"{capitalized(estimator_name(name))} is off by {figures(ratio.max(), 2)} of its standard deviations "
                f"in {worst}: it is biased, or states too small an uncertainty."
            )


def _saturation(flown: FlownRun) -> Iterator[Notice]:
    for flag in FLAGS:
        if flag.name not in flown.record.channels or not flag.per:
            continue
        raised = flown.record.channels[flag.name] > 0.5
        if raised.any():
            units = listed(str(index + 1) for index in np.flatnonzero(raised.any(axis=0)))
            seconds = figures(raised.any(axis=1).sum() * flown.period)
            yield _warning(f"{KINDS[flag.per].called} {units}: {seconds} s {flag.held}.")


def _warning(text: str) -> Notice:
    return Notice(tone="warn", text=text)
