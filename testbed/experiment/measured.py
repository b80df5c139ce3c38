"""Estimates from a record measured elsewhere: outliers left out, and an assumed zero momentum tested first."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

import numpy as np

from testbed.arrays import Array, Flags, Theta
from testbed.assembly.platform import Body
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import inertia_of
from testbed.effects.gyro_saturation import flat_tops
from testbed.errors import UnidentifiableError
from testbed.estimation.estimate import Estimate
from testbed.estimation.momentum_test import zero_momentum_p_value
from testbed.estimation.outliers import gross_outliers, outliers
from testbed.estimation.telemetry import Telemetry, covered_part
from testbed.experiment.experiment import Estimation
from testbed.experiment.running_estimators import estimate_telemetry
from testbed.records.record import Record
from testbed.scenario.body import BodyScenario

MOMENTUM_REFUSED = 0.05
"""p-value below which a zero initial momentum is given up. To estimate a momentum that is zero costs 3 to 9 % of the
precision, to assume a zero that is none biases J: so it is given up at little doubt (docs/notes, estimators)."""
_ROUNDS = 3
"""Searches for outliers, each in the residual of the estimate without those found before."""
_NO_PULL = 0.1
"""Standard deviations by which outliers move no parameter: of a million samples chance sets some apart, and an estimate
without them would cost as much as the one with them."""
_UNKNOWNS = 9
"""Inertia and momentum."""
_MOST_OUTLIERS = 0.05
"""Share of the samples beyond which they are what this gyro shows, and no accidents."""


def estimate_record(scenario: BodyScenario, nominal: Body, record: Record) -> Estimation:
    """Estimate the inertia from a record measured elsewhere; the bound is taken at the most efficient estimate.

    Args:
        scenario: estimators and their settings; its maneuver is not used.
        nominal: what the estimators believe.
        record: telemetry.

    Raises:
        InputError: the record lacks what estimators need, or none of them gave an estimate.
    """
    measured = telemetry_of(record, scenario, nominal)
    estimation = _estimated(scenario, nominal, measured, record.details.name)
    if not measured.torque_held or estimation.checks is None:
        return estimation
    # The nominal inertia put the rate's corners in their place as well as it is known itself; the estimate does better.
    near = replace(nominal, inertia=inertia_of(_most_efficient(estimation).body_theta))
    return _estimated(scenario, nominal, telemetry_of(record, scenario, near), record.details.name)


def _estimated(scenario: BodyScenario, nominal: Body, measured: Telemetry, name: str) -> Estimation:
    """Estimate from one run's telemetry without outliers, with its momentum tested where it is said to be zero."""
    telemetry = _without(measured, gross_outliers(measured.body_rate, measured.gyro_noise))

    def estimated(part: Telemetry) -> Estimation:
        return estimate_telemetry(scenario, nominal, part, name)

    estimation = estimated(telemetry)
    for _ in range(_ROUNDS):
        found = _outliers_left(telemetry, estimation)
        if not found.any():
            break
        telemetry = _without(telemetry, found)
        estimation = estimated(telemetry)
    gone = len(measured.gyro_time) - len(telemetry.gyro_time)
    if telemetry.initial_momentum == "zero":
        estimation = _with_tested_momentum(estimation, telemetry, estimated)
    return replace(estimation, outliers=gone)


def _with_tested_momentum(
    estimation: Estimation, telemetry: Telemetry, estimated: Callable[[Telemetry], Estimation]
) -> Estimation:
    """Return the estimates with the momentum estimated jointly, where the record refuses that there was none."""
    p_value = zero_momentum_p_value(covered_part(telemetry), *_best(estimation, telemetry))
    if p_value < MOMENTUM_REFUSED:
        with suppress(UnidentifiableError):  # a motion that does not identify them: the checks report the residual
            estimation = estimated(replace(telemetry, initial_momentum="estimated"))
    return replace(estimation, zero_momentum_p_value=p_value)


def _outliers_left(telemetry: Telemetry, estimation: Estimation) -> Flags:
    """Return which gyro samples stand apart in the residual of the best estimate, shape (N, 3)."""
    none = np.zeros(telemetry.body_rate.shape, dtype=bool)
    best = None if estimation.checks is None else estimation.by_name[estimation.checks.best]
    if best is None or best.residual_unit != "rad/s":
        return none
    found = outliers(best.residual, telemetry.gyro_noise)
    if _pull(best.residual[found] / telemetry.gyro_noise, best.residual.size) < _NO_PULL:
        return none
    none[np.searchsorted(telemetry.gyro_time, best.residual_time)] = found
    return none


def _pull(standardised: Array, residuals: int) -> float:
    """Return by how many standard deviations residuals move a parameter, if their leverage is that of the average."""
    return float(np.sqrt(_UNKNOWNS / residuals * np.sum(standardised**2)))


def _without(telemetry: Telemetry, found: Flags) -> Telemetry:
    """Return the telemetry without some samples; a clipped peak looks like an outlier to a fit, and stays."""
    (clipped,) = flat_tops([telemetry])
    gone = np.any(found & ~clipped, axis=1)
    if not gone.any() or gone.mean() > _MOST_OUTLIERS:
        return telemetry
    return telemetry.with_gyro_rows(~gone)


def _most_efficient(estimation: Estimation) -> Estimate:
    assert estimation.checks is not None
    return estimation.by_name[estimation.checks.best]


def _best(estimation: Estimation, telemetry: Telemetry) -> tuple[Theta, Array | None]:
    """Return the most efficient estimate's inertia, on a pivot about that, and what was estimated to act there."""
    best = _most_efficient(estimation)
    return best.turned_theta(telemetry.pivot), None if telemetry.pivot is None else best.acting
