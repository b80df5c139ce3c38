"""Run a scenario's estimators on records, and put the bound beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Array, Covariance, Theta, Vector3
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import PlatformModel
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.environment import Pivoted
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.errors import InputError
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.estimate import Estimate, EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry, WheelTelemetry
from testbed.experiment.checking import checks_of, considered, with_spread
from testbed.experiment.experiment import Estimation
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.rotation.quaternion import quaternion_inverse, turned
from testbed.scenario.scenario import Scenario

_DOUBTFUL_STDS = 5.0
"""Standard deviations by which an estimate may miss what is physical before it is rejected."""
_ROUNDING = 1e-9
"""How far a correlation matrix's smallest eigenvalue may lie below zero: six numbers of order 1, inverted once."""


def estimate_flight(
    scenario: Scenario,
    nominal: PlatformModel,
    truth: PlatformModel,
    maneuver: Maneuver,
    record: Record,
    *,
    checked: bool = True,
) -> Estimation:
    """Estimate the inertia from a simulated flight; the bound is that of its true motion.

    Args:
        scenario: estimators and their settings.
        nominal: what they believe.
        truth: what flew; only the bound knows it.
        maneuver: the reference.
        record: of the flight.
        checked: whether to test the estimates; in a campaign the statistics do.
    """
    telemetry = telemetry_of(record, scenario, nominal)
    settings = estimation_settings(scenario, nominal, maneuver)
    estimation = run_estimators(scenario, telemetry, settings, checked=checked)
    return _with_bound(estimation, _true_bound_std(truth, telemetry, record))


def try_estimate_flight(
    scenario: Scenario,
    nominal: PlatformModel,
    truth: PlatformModel,
    maneuver: Maneuver,
    record: Record,
    *,
    checked: bool = True,
) -> Estimation:
    """As `estimate_flight`; a flight that gives no estimate, such as one that soon met the wall, is kept too."""
    try:
        return estimate_flight(scenario, nominal, truth, maneuver, record, checked=checked)
    except InputError as error:
        failures = {str(name): str(error) for name in scenario.estimation.estimators}
        return Estimation(by_name={}, failures=failures, bound_std=None)


def estimate_telemetry(scenario: Scenario, nominal: PlatformModel, telemetry: Telemetry, name: str) -> Estimation:
    """Estimate the inertia from telemetry measured elsewhere; the bound is taken at the most efficient estimate.

    Args:
        scenario: estimators and their settings; its maneuver is not used.
        nominal: what the estimators believe.
        telemetry: of one run.
        name: of the run, for messages.

    Raises:
        InputError: no estimator gave an estimate.
    """
    settings = estimation_settings(scenario, nominal, maneuver=None)
    estimation = run_estimators(scenario, telemetry, settings, checked=True)
    if not estimation.by_name:
        reasons = "; ".join(dict.fromkeys(estimation.failures.values()))  # often all for the same reason
        raise InputError(f"{name}: no estimator gave an estimate ({reasons})")
    best = min(estimation.by_name.values(), key=lambda estimate: float(np.trace(estimate.covariance)))
    acting = None if telemetry.pivot is None else best.acting
    bound = bound_std(telemetry, best.turned_theta(telemetry.pivot), best.initial_momentum_B, acting)
    return _with_bound(estimation, bound)


def _with_bound(estimation: Estimation, std: Array | None) -> Estimation:
    """Return the estimation with the bound's standard deviations, shape (6,), on a pivot (9,)."""
    if std is None:
        return estimation
    return replace(estimation, bound_std=std[:6], offset_bound_std=std[6:] if std[6:].size else None)


def run_estimators(
    scenario: Scenario, telemetry: Telemetry, settings: EstimationSettings, *, checked: bool
) -> Estimation:
    """Run every estimator that the scenario names; one that gives no estimate does not stop the others.

    Args:
        scenario: names the estimators.
        telemetry: of one run.
        settings: of the estimators.
        checked: whether to test what they answer.

    Returns:
        The estimates, everything considered, without a bound.
    """
    answers: dict[str, Estimate | str] = {
        name: _answer(name, telemetry, settings) for name in scenario.estimation.estimators
    }
    failures = {name: answer for name, answer in answers.items() if isinstance(answer, str)}
    estimates = {name: answer for name, answer in answers.items() if isinstance(answer, Estimate)}
    by_name = considered(estimates, telemetry, settings)
    checks = checks_of(by_name, telemetry, settings) if checked else None
    by_name = with_spread(by_name, None if checks is None else checks.compared)
    return Estimation(
        by_name={
            name: replace(estimate, influence=None).about_center_of_mass(telemetry.pivot)
            for name, estimate in by_name.items()
        },
        failures=failures,
        bound_std=None,
        pivot=telemetry.pivot,
        checks=checks,
        initial_momentum=telemetry.initial_momentum,
    )


def _answer(name: str, telemetry: Telemetry, settings: EstimationSettings) -> Estimate | str:
    """Return an estimator's estimate, or why there is none."""
    try:
        estimate = ESTIMATORS[name](telemetry, settings)
    except InputError as error:
        return str(error)
    except np.linalg.LinAlgError:
        return "the inertia cannot be determined: the record's equations are singular"
    return doubt_of(estimate) or estimate


def doubt_of(estimate: Estimate) -> str:
    """Return why an estimate is rejected: not finite, or no inertia that a body can have, however wide the bands."""
    if not (np.isfinite(estimate.theta).all() and _is_covariance(estimate.covariance)):
        return "its estimate is no finite inertia with a covariance; the record does not fit the model"
    smallest, middle, largest = np.linalg.eigvalsh(inertia_of(estimate.theta))
    slack = _DOUBTFUL_STDS * float(estimate.std.max())
    if smallest < -slack or largest > smallest + middle + 3.0 * slack:
        return (
            f"its estimate, with principal moments {smallest:.3g}, {middle:.3g}, {largest:.3g} kg m2, is no rigid "
            "body's inertia: check the signs and units of gyro and actuators, and that the scenario is of this platform"
        )
    return ""


def _is_covariance(covariance: Covariance) -> bool:
    """Return whether a matrix is finite and positive semidefinite, judged free of its parameters' scales."""
    variance = np.diag(covariance)
    if not (np.isfinite(covariance).all() and (variance >= 0.0).all()):
        return False
    scale = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    return bool(np.linalg.eigvalsh(covariance / np.outer(scale, scale))[0] >= -_ROUNDING)


def bound_std(
    telemetry: Telemetry, theta: Theta, initial_momentum_B: Vector3, acting: Array | None = None
) -> Array | None:
    """Return the square root of the Cramér-Rao bound's diagonal, kg·m²; None where the motion leaves θ undetermined.

    Shape (6,); on a pivot (9,), the last three of the offset of the centre of mass, m.

    Args:
        telemetry: times, noise and actuators of the motion.
        theta: at which the bound is taken.
        initial_momentum_B: at which the bound is taken, N·m·s.
        acting: as of `cramer_rao_bound`.
    """
    try:
        covariance = cramer_rao_bound(telemetry, theta, initial_momentum_B, acting)
    except (InputError, np.linalg.LinAlgError):
        return None
    return np.sqrt(np.diag(covariance)) if _is_covariance(covariance) else None


def _true_bound_std(truth: PlatformModel, telemetry: Telemetry, record: Record) -> Array | None:
    """The bound of the motion as it was: true gimbal angles, rotor and wheel speeds, at the telemetry's times."""
    rows, gimbals, wheels = np.searchsorted(record.time, telemetry.actuator_time), None, None
    if truth.units:
        gimbals = GimbalTelemetry(
            cluster=truth.cluster,
            angle=record.channels["true_gimbal_angle"][rows],
            rotor_momentum=record.channels["true_rotor_speed"][rows] * truth.cluster.rotor_spin_inertia,
        )
    if len(truth.wheels.spin_inertia):
        momentum = record.channels["true_wheel_speed"][rows] * truth.wheels.spin_inertia
        wheels = WheelTelemetry(wheels=truth.wheels, momentum=momentum)
    actual = replace(telemetry, gimbals=gimbals, wheels=wheels)
    first = int(np.searchsorted(record.time, telemetry.gyro_time[0]))
    attitude_BN = quaternion_inverse(record.channels["true_attitude"][first])
    momentum_B = turned(attitude_BN, record.channels["true_total_momentum"][first])
    return bound_std(actual, theta_of(truth.turned_inertia), momentum_B, _true_acting(truth, telemetry))


def _true_acting(truth: PlatformModel, telemetry: Telemetry) -> Array | None:
    """Return what acts in truth beside what is believed, as `Telemetry.torque_of`; None without a pivot."""
    if telemetry.pivot is None or not isinstance(truth.environment, Pivoted):
        return None
    offset_error = truth.environment.offset_B - telemetry.pivot.offset_B
    return np.concatenate([np.zeros(len(telemetry.torque_names)), offset_error])
