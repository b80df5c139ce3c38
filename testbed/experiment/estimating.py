"""Run a scenario's estimators on records, and put the bound beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from testbed.arrays import Covariance, Theta, Vector3
from testbed.assembly.estimation import estimation_settings, telemetry_of
from testbed.assembly.platform import PlatformModel
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.errors import InputError
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.combine import combined
from testbed.estimation.estimate import Estimate, EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.telemetry import Telemetry
from testbed.experiment.experiment import CombinedEstimation, Estimation
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.rotation.quaternion import quaternion_inverse, turned
from testbed.scenario.scenario import Scenario

_DOUBTFUL_STDS = 5.0
"""Standard deviations by which an answer may miss what is physical before it is called none."""
_ROUNDING = 1e-9
"""How far a correlation matrix's smallest eigenvalue may lie below zero: six numbers of order 1, inverted once."""


def estimate_flight(
    scenario: Scenario, nominal: PlatformModel, truth: PlatformModel, maneuver: Maneuver, record: Record
) -> Estimation:
    """Estimate the inertia from a simulated flight; the bound is that of its true motion.

    Args:
        scenario: estimators and their settings.
        nominal: what they believe.
        truth: what flew; only the bound knows it.
        maneuver: the reference.
        record: of the flight.
    """
    telemetry = telemetry_of(record, scenario, nominal)
    by_name, failures = run_estimators(scenario, telemetry, estimation_settings(scenario, nominal, maneuver))
    return Estimation(by_name=by_name, failures=failures, bound_std=_true_bound_std(truth, telemetry, record))


def try_estimate_flight(
    scenario: Scenario, nominal: PlatformModel, truth: PlatformModel, maneuver: Maneuver, record: Record
) -> Estimation:
    """As `estimate_flight`; a flight that gives no estimate, such as one that soon met the wall, is kept too."""
    try:
        return estimate_flight(scenario, nominal, truth, maneuver, record)
    except InputError as error:
        failures = {str(name): str(error) for name in scenario.estimation.estimators}
        return Estimation(by_name={}, failures=failures, bound_std=None)


def estimate_record(scenario: Scenario, nominal: PlatformModel, record: Record) -> Estimation:
    """Estimate the inertia from a record measured elsewhere; the bound is taken at the most efficient estimate.

    Args:
        scenario: estimators and their settings; its maneuver is not used.
        nominal: what the estimators believe.
        record: telemetry.

    Raises:
        InputError: the record lacks what estimators need, or none of them gave an estimate.
    """
    telemetry = telemetry_of(record, scenario, nominal)
    by_name, failures = run_estimators(scenario, telemetry, estimation_settings(scenario, nominal, maneuver=None))
    if not by_name:
        reasons = "; ".join(dict.fromkeys(failures.values()))  # often all for the same reason
        raise InputError(f"{record.details.name}: no estimator gave an estimate ({reasons})")
    best = min(by_name.values(), key=lambda estimate: float(np.trace(estimate.covariance)))
    return Estimation(
        by_name=by_name, failures=failures, bound_std=bound_std(telemetry, best.theta, best.initial_momentum_B)
    )


def combine_estimations(estimations: Mapping[str, Estimation]) -> CombinedEstimation:
    """Average each estimator over the runs in which it gave an estimate, eq. (33).

    Args:
        estimations: by run.
    """
    runs = estimations.values()
    names = {name: None for estimation in runs for name in estimation.by_name}
    return CombinedEstimation(
        by_name={
            name: combined([estimation.by_name[name] for estimation in runs if name in estimation.by_name])
            for name in names
        },
        runs=len(estimations),
    )


def run_estimators(
    scenario: Scenario, telemetry: Telemetry, settings: EstimationSettings
) -> tuple[Mapping[str, Estimate], Mapping[str, str]]:
    """Run every estimator that the scenario names; one that cannot answer does not stop the others.

    Returns:
        The estimates, and why an estimator gave none, both by its name.
    """
    by_name: dict[str, Estimate] = {}
    failures: dict[str, str] = {}
    for name in scenario.estimation.estimators:
        try:
            estimate = ESTIMATORS[name](telemetry, settings)
        except InputError as error:
            failures[name] = str(error)
            continue
        except np.linalg.LinAlgError:
            failures[name] = "the inertia cannot be determined: the record's equations are singular"
            continue
        if doubt := doubt_of(estimate):
            failures[name] = doubt
        else:
            by_name[name] = estimate
    return by_name, failures


def doubt_of(estimate: Estimate) -> str:
    """Return why an answer is none: not finite, or no inertia that a body can have, however wide the bands."""
    if not (np.isfinite(estimate.theta).all() and _is_covariance(estimate.covariance)):
        return "its answer is no finite inertia with a covariance; the record does not fit the model"
    smallest, middle, largest = np.linalg.eigvalsh(inertia_of(estimate.theta))
    slack = _DOUBTFUL_STDS * float(estimate.std.max())
    if smallest < -slack or largest > smallest + middle + 3.0 * slack:
        return (
            f"its answer, with principal moments {smallest:.3g}, {middle:.3g}, {largest:.3g} kg m2, is the inertia of "
            "no body: check the signs and units of gyro and actuators, and that the scenario is of this platform"
        )
    return ""


def _is_covariance(covariance: Covariance) -> bool:
    """Return whether a matrix is finite and positive semidefinite, judged free of its parameters' scales."""
    variance = np.diag(covariance)
    if not (np.isfinite(covariance).all() and (variance >= 0.0).all()):
        return False
    scale = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    return bool(np.linalg.eigvalsh(covariance / np.outer(scale, scale))[0] >= -_ROUNDING)


def bound_std(telemetry: Telemetry, theta: Theta, initial_momentum_B: Vector3) -> Theta | None:
    """Return the square root of the Cramér-Rao bound's diagonal, kg·m²; None where the motion leaves θ undetermined.

    Args:
        telemetry: times, noise and actuators of the motion.
        theta: at which the bound is taken.
        initial_momentum_B: at which the bound is taken, N·m·s.
    """
    try:
        covariance = cramer_rao_bound(telemetry, theta, initial_momentum_B)
    except (InputError, np.linalg.LinAlgError):
        return None
    return np.sqrt(np.diag(covariance)) if _is_covariance(covariance) else None


def _true_bound_std(truth: PlatformModel, telemetry: Telemetry, record: Record) -> Theta | None:
    """The bound of the motion as it was: true gimbal angles and rotor speeds, at the telemetry's times."""
    rows = np.searchsorted(record.time, telemetry.actuator_time)
    actual = replace(
        telemetry,
        cluster=truth.cluster,
        gimbal_angle=record.channels["true_gimbal_angle"][rows],
        rotor_momentum=record.channels["true_rotor_speed"][rows] * truth.cluster.rotor_spin_inertia,
    )
    first = int(np.searchsorted(record.time, telemetry.gyro_time[0]))
    attitude_BN = quaternion_inverse(record.channels["true_attitude"][first])
    momentum_B = turned(attitude_BN, record.channels["true_total_momentum"][first])
    return bound_std(actual, theta_of(truth.inertia), momentum_B)
