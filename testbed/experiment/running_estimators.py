"""Run a scenario's estimators on records, and put the bound beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Covariance, Theta, Vector3
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import Body, PlatformModel
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.environment import Pivoted
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.errors import InputError
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.estimate import Estimate, EstimationSettings
from testbed.estimation.preparation import identifiable_part
from testbed.estimation.registry import ESTIMATORS, SIDE_BY_SIDE
from testbed.estimation.side_by_side import answers_side_by_side
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry, WheelTelemetry
from testbed.estimation.telemetry_covariance import with_telemetry_noise
from testbed.experiment.checking import checks_of, considered, with_spread
from testbed.experiment.experiment import Estimation
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.rotation.quaternion import quaternion_inverse, turned
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario

_DOUBTFUL_STDS = 5.0
"""Standard deviations by which an estimate may miss what is physical before it is rejected."""
_ROUNDING = 1e-9
"""How far a correlation matrix's smallest eigenvalue may lie below zero: six numbers of order 1, inverted once."""


class MeasuredFlight(NamedTuple):
    """A simulated flight to estimate from.

    Attributes:
        scenario: as it was flown; estimators and their settings are those of all flights that are estimated together.
        truth: what flew; only the bound knows it.
        record: of the flight.
    """

    scenario: Scenario
    truth: PlatformModel
    record: Record


def estimate_flight(
    flight: MeasuredFlight, nominal: PlatformModel, maneuver: Maneuver, *, checked: bool = True
) -> Estimation:
    """Estimate the inertia from one simulated flight; as `estimate_flights`."""
    (estimation,) = estimate_flights([flight], nominal, maneuver, checked=checked)
    return estimation


def estimate_flights(
    flights: Sequence[MeasuredFlight], nominal: PlatformModel, maneuver: Maneuver, *, checked: bool
) -> list[Estimation]:
    """Estimate the inertia from simulated flights, from each alone; the bound is that of its true motion.

    A flight that gives no estimate, such as one that soon met the wall, is kept too, with the reason.

    Args:
        flights: of one scenario.
        nominal: what the estimators believe.
        maneuver: the reference.
        checked: whether to test the estimates; in a campaign the statistics do.
    """
    if not flights:
        return []
    scenario = flights[0].scenario
    telemetry = [_telemetry_or_reason(flight, nominal) for flight in flights]
    sent = [(flight, each) for flight, each in zip(flights, telemetry, strict=True) if isinstance(each, Telemetry)]
    settings = estimation_settings(scenario, nominal, maneuver)
    estimated = iter(
        zip(
            run_side_by_side(scenario, [each for _, each in sent], settings, checked=checked),
            bounds_std(_true_motions(sent)),
            strict=True,
        )
    )
    return [
        _with_bound(*next(estimated)) if isinstance(each, Telemetry) else _failed(scenario, each) for each in telemetry
    ]


def _telemetry_or_reason(flight: MeasuredFlight, nominal: PlatformModel) -> Telemetry | str:
    try:
        return telemetry_of(flight.record, flight.scenario, nominal)
    except InputError as error:
        return str(error)


def _failed(scenario: Scenario, reason: str) -> Estimation:
    failures = {str(name): reason for name in scenario.estimation.estimators}
    return Estimation(by_name={}, failures=failures, bound_std=None)


def estimate_telemetry(scenario: BodyScenario, nominal: Body, telemetry: Telemetry, name: str) -> Estimation:
    """Estimate the inertia from telemetry measured elsewhere; the bound is taken at the most efficient estimate.

    Args:
        scenario: estimators and their settings; its maneuver is not used.
        nominal: what the estimators believe.
        telemetry: of one run.
        name: of the run, for messages.

    Raises:
        InputError: no estimator gave an estimate.
    """
    settings = replace(estimation_settings(scenario, nominal, maneuver=None), telemetry_noise=True)
    estimation = run_estimators(scenario, telemetry, settings, checked=True)
    if not estimation.by_name:
        reasons = "; ".join(dict.fromkeys(estimation.failures.values()))  # often all for the same reason
        raise InputError(f"{name}: no estimator gave an estimate ({reasons})")
    best = min(estimation.by_name.values(), key=lambda estimate: float(np.trace(estimate.covariance)))
    acting = None if telemetry.pivot is None else best.acting
    at = KnownMotion(telemetry, best.turned_theta(telemetry.pivot), best.initial_momentum_B, acting)
    return _with_bound(estimation, *bounds_std([at]))


def _with_bound(estimation: Estimation, std: Array | None) -> Estimation:
    """Return the estimation with the bound's standard deviations, shape (6,), on a pivot (9,)."""
    if std is None:
        return estimation
    return replace(estimation, bound_std=std[:6], offset_bound_std=std[6:] if std[6:].size else None)


def run_estimators(
    scenario: BodyScenario, telemetry: Telemetry, settings: EstimationSettings, *, checked: bool
) -> Estimation:
    """Run every estimator that the scenario names on one run; as `run_side_by_side`."""
    (estimation,) = run_side_by_side(scenario, [telemetry], settings, checked=checked)
    return estimation


def run_side_by_side(
    scenario: BodyScenario, flights: Sequence[Telemetry], settings: EstimationSettings, *, checked: bool
) -> list[Estimation]:
    """Run every estimator that the scenario names on every run; one that gives no estimate does not stop the others.

    Args:
        scenario: names the estimators.
        flights: the telemetry of each run.
        settings: of the estimators.
        checked: whether to test what they answer.

    Returns:
        The estimates of each, everything considered, without a bound.
    """
    by_name = {name: _answers(name, flights, settings) for name in scenario.estimation.estimators}
    return [
        _estimation({name: answers[index] for name, answers in by_name.items()}, telemetry, settings, checked=checked)
        for index, telemetry in enumerate(flights)
    ]


_INTEGRATING = "output_error"
"""It integrates the momentum: in the equations of the others, noise of telemetry stands at its own sample alone."""


_WEAK = 100.0
"""Times the standard deviation of output error, about any parameter, from which on an estimator's answer is left out.

Source: chosen: tables on a bearing have ratios of 0.7 to 9, and four of their runs, which hardly turn the vertical
to see the offset, 600 to 150,000. Linear in the noise an estimator is no more where its instrument is that weak."""


def _weak(estimates: Mapping[str, Estimate]) -> dict[str, str]:
    """Return the estimators that a measured run hardly determines, beside output error, each with the reason."""
    best = estimates[_INTEGRATING]
    times = {name: float((each.std / best.std).max()) for name, each in estimates.items()}
    return {
        name: f"its uncertainty is {ratio:.2g} times that of output error: this run hardly determines it"
        for name, ratio in times.items()
        if ratio > _WEAK
    }


def _estimation(
    answers: Mapping[str, Estimate | str], telemetry: Telemetry, settings: EstimationSettings, *, checked: bool
) -> Estimation:
    """Consider and check what the estimators answer on one run."""
    failures = {name: answer for name, answer in answers.items() if isinstance(answer, str)}
    estimates = {name: answer for name, answer in answers.items() if isinstance(answer, Estimate)}
    if settings.telemetry_noise and _INTEGRATING in estimates:
        part = identifiable_part(telemetry, settings)
        weak = _weak(estimates)
        failures |= weak
        estimates = {name: estimate for name, estimate in estimates.items() if name not in weak}
        estimates[_INTEGRATING] = with_telemetry_noise(estimates[_INTEGRATING], part)
    by_name = considered(estimates, telemetry, settings)
    try:
        checks = checks_of(by_name, telemetry, settings) if checked else None
    except InputError as error:  # an estimate by which the motion runs away is none
        by_name, checks, failures = {}, None, failures | dict.fromkeys(by_name, str(error))
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


def _answers(name: str, flights: Sequence[Telemetry], settings: EstimationSettings) -> list[Estimate | str]:
    """Return an estimator's estimate of each run, or why there is none."""

    def alone(index: int) -> Estimate | str:
        return _answer(name, flights[index], settings)

    estimator = SIDE_BY_SIDE.get(name)
    if estimator is None:
        return [alone(index) for index in range(len(flights))]
    return answers_side_by_side(
        flights, lambda each, _: [doubt_of(estimate) or estimate for estimate in estimator(each, settings)], alone
    )


def _answer(name: str, telemetry: Telemetry, settings: EstimationSettings) -> Estimate | str:
    """Return an estimator's estimate of one run, or why there is none."""
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


class KnownMotion(NamedTuple):
    """A motion at which the bound is taken.

    Attributes:
        telemetry: times, noise and actuators.
        theta: inertia parameters, shape (6,), kg·m².
        initial_momentum_B: at the first sample, shape (3,), N·m·s.
        acting: as of `cramer_rao_bound`.
    """

    telemetry: Telemetry
    theta: Theta
    initial_momentum_B: Vector3
    acting: Array | None = None


def bounds_std(motions: Sequence[KnownMotion]) -> list[Array | None]:
    """Return the square roots of each bound's diagonal, kg·m²; None where the motion leaves θ undetermined.

    Shape (6,); on a pivot (9,), the last three of the offset of the centre of mass, m.

    Args:
        motions: each with its own bound.
    """

    def together(telemetry: Telemetry, which: Sequence[int]) -> list[Array | None]:
        theta = np.stack([motions[index].theta for index in which])
        momentum_B = np.stack([motions[index].initial_momentum_B for index in which])
        return [_std_of(bound) for bound in cramer_rao_bound(telemetry, theta, momentum_B)]

    def alone(index: int) -> Array | None:
        try:
            return _std_of(cramer_rao_bound(*motions[index]))
        except (InputError, np.linalg.LinAlgError):
            return None

    return answers_side_by_side([motion.telemetry for motion in motions], together, alone)


def _std_of(covariance: Covariance) -> Array | None:
    return np.sqrt(np.diag(covariance)) if _is_covariance(covariance) else None


def _true_motions(flights: Sequence[tuple[MeasuredFlight, Telemetry]]) -> list[KnownMotion]:
    """Return the motions as they were, at the telemetry's times."""
    firsts = [
        (flight.record.channels, int(np.searchsorted(flight.record.time, telemetry.gyro_time[0])))
        for flight, telemetry in flights
    ]
    attitude_NB = np.array([channels["true_attitude"][row] for channels, row in firsts]).reshape(-1, 4)
    momentum_N = np.array([channels["true_total_momentum"][row] for channels, row in firsts]).reshape(-1, 3)
    momenta_B = turned(quaternion_inverse(attitude_NB), momentum_N) if firsts else momentum_N
    return [
        KnownMotion(
            _true_telemetry(flight, telemetry),
            theta_of(flight.truth.turned_inertia),
            momentum_B,
            _true_acting(flight.truth, telemetry),
        )
        for (flight, telemetry), momentum_B in zip(flights, momenta_B, strict=True)
    ]


def _true_telemetry(flight: MeasuredFlight, telemetry: Telemetry) -> Telemetry:
    """Return the telemetry with true gimbal angles, rotor and wheel speeds."""
    truth, record = flight.truth, flight.record
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
    return replace(telemetry, gimbals=gimbals, wheels=wheels)


def _true_acting(truth: PlatformModel, telemetry: Telemetry) -> Array | None:
    """Return what acts in truth beside what is believed, as `Telemetry.torque_of`; None without a pivot."""
    if telemetry.pivot is None or not isinstance(truth.environment, Pivoted):
        return None
    offset_error = truth.environment.offset_B - telemetry.pivot.offset_B
    return np.concatenate([np.zeros(len(telemetry.torque_names)), offset_error])
