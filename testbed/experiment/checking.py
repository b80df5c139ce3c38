"""Checks of a record's estimates: residuals like noise, estimators that agree, the size of what is neglected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from testbed.arrays import Array, Covariance, Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.estimation.agreement import Agreement, estimators_agreement
from testbed.estimation.bound import rate_columns
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.considered import considered_errors, considered_shifts
from testbed.estimation.estimate import Estimate, EstimationSettings
from testbed.estimation.motion import Drive, Motion, drive_of, simulate, torque_basis, with_torque
from testbed.estimation.preparation import identifiable_part, likely_theta
from testbed.estimation.regression import covariance_of
from testbed.estimation.residual_check import ResidualCheck, checked_rows, residual_check
from testbed.estimation.sensitivity import torque_sensitivity
from testbed.estimation.stated_noise import influence_of_white, whitened
from testbed.estimation.telemetry import ConstantTorque, Telemetry
from testbed.estimation.telemetry_noise import Attenuation, attenuation, common_to_neighbours, predicted_rate_variance

AnyEstimate = TypeVar("AnyEstimate", Estimate, CombinedEstimate)

_EFFICIENT = ("output_error", "iv_momentum")
"""Estimators that reach the bound, the better one first: they believe the whole motion."""
_ROBUST = ("iv", "iv_momentum")
"""Estimators that believe less of it: the prefilter forgets what was long ago."""


@dataclass(frozen=True, kw_only=True)
class NeglectedTorque:
    """A constant torque that is not estimated.

    Attributes:
        frame: in which it is constant.
        size: that moves a parameter by one standard deviation, along the worst axis, N·m.
        parameter: which one.
    """

    frame: ConstantTorque
    size: float
    parameter: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Compared:
    """An efficient and a robust estimator on the same data.

    Attributes:
        efficient: name of the one.
        robust: name of the other.
        covariance: of both answers together by the gyro's noise, shape (12, 12), kg²·m⁴; on a pivot (18, 18), each with
            the offset behind it, m.
        agreement: of the two.
    """

    efficient: str
    robust: str
    covariance: Covariance
    agreement: Agreement


@dataclass(frozen=True, kw_only=True)
class Checks:
    """Results of the checks of one record's estimates.

    Attributes:
        best: the estimator whose residual was tested: the most efficient one that answered.
        residual: of its prediction of the gyro's samples.
        compared: an efficient estimator with a robust one; None where there is but one.
        neglected: constant torques that are not estimated.
        attenuation: of the inverse inertia by noise of the actuators' telemetry.
    """

    best: str
    residual: ResidualCheck
    compared: Compared | None
    neglected: tuple[NeglectedTorque, ...]
    attenuation: Attenuation


def considered(
    by_name: Mapping[str, Estimate], telemetry: Telemetry, settings: EstimationSettings
) -> Mapping[str, Estimate]:
    """Return the estimates with what uncertain actuators and gyro add to their covariance.

    Args:
        by_name: with their influences.
        telemetry: of the run.
        settings: with what is uncertain.
    """
    if settings.uncertainty.nothing or not by_name:
        return by_name
    part = identifiable_part(telemetry, settings)
    influences = {name: _influence(estimate, part) for name, estimate in by_name.items()}
    shifts = considered_shifts(part, likely_theta(part, settings.nominal_theta), settings.uncertainty, influences)
    return {
        name: replace(
            estimate,
            considered=shifts.by_name[name][:6],
            considered_kinds=shifts.kinds,
            offset_considered=shifts.by_name[name][6:],
        )
        for name, estimate in by_name.items()
    }


def checks_of(by_name: Mapping[str, Estimate], telemetry: Telemetry, settings: EstimationSettings) -> Checks | None:
    """Test the estimates of a record; None where there are none.

    Args:
        by_name: with their influences, everything considered.
        telemetry: of the run.
        settings: with what is uncertain.
    """
    if not by_name:
        return None
    part = identifiable_part(telemetry, settings)
    best = _first(_EFFICIENT, by_name) or min(by_name, key=lambda name: float(np.trace(by_name[name].covariance)))
    estimate = by_name[best]
    drive = with_torque(drive_of(part), estimate.acting)
    motion = simulate(drive, estimate.theta, estimate.initial_momentum_B)
    robust = _first(tuple(name for name in _ROBUST if name != best), by_name) if best in _EFFICIENT else None
    return Checks(
        best=best,
        residual=_residual(part, settings, drive, motion),
        compared=None if robust is None else _compared((best, estimate), (robust, by_name[robust]), part),
        neglected=tuple(_neglected(estimate, part, drive, motion)),
        attenuation=attenuation(part, motion.body_rate, estimate.theta, estimate.covariance),
    )


def _first(names: tuple[str, ...], by_name: Mapping[str, Estimate]) -> str | None:
    return next((name for name in names if name in by_name), None)


def _influence(estimate: Estimate, part: Telemetry) -> Array:
    """Return ∂θ̂/∂e of all of the part's samples, shape (6 or 9, 3N); zero of those that the estimator left out."""
    assert estimate.influence is not None
    if len(estimate.residual_time) == len(part.gyro_time):
        return estimate.influence
    rows = len(estimate.influence)
    influence = np.zeros((rows, len(part.gyro_time), 3))
    used = np.searchsorted(part.gyro_time, estimate.residual_time)
    influence[:, used] = estimate.influence.reshape(rows, -1, 3)
    return influence.reshape(rows, -1)


def _residual(part: Telemetry, settings: EstimationSettings, drive: Drive, motion: Motion) -> ResidualCheck:
    rows = checked_rows(len(part.gyro_time))
    theta = likely_theta(part, settings.nominal_theta)

    def looked_at(values: Array) -> Array:
        """Return what is white of the samples' values, shape (N, 3, C), of those that are tested, shape (3N', C)."""
        white = whitened(part, values.reshape(3 * len(part.gyro_time), -1))
        return white.reshape(len(part.gyro_time), 3, -1)[rows].reshape(3 * len(rows), -1)

    explained, _ = np.linalg.qr(looked_at(rate_columns(part, drive, motion)))
    errors = [
        np.zeros((3 * len(rows), 0)),
        *(looked_at(each) for each, _ in considered_errors(part, theta, settings.uncertainty)),
    ]
    residual = looked_at(part.body_rate - motion.body_rate)
    rest, beside = (values - explained @ (explained.T @ values) for values in (residual, np.hstack(errors)))
    added = predicted_rate_variance(part, theta)
    variance = part.gyro_noise**2 + added
    common = common_to_neighbours(part) * added / variance
    return residual_check(
        rest.reshape(-1, 3), np.sqrt(variance), beside, explained.shape[1], part.noise_freedom, common
    )


def _compared(efficient: tuple[str, Estimate], robust: tuple[str, Estimate], part: Telemetry) -> Compared:
    influence = np.vstack([_influence(estimate, part) for _, estimate in (efficient, robust)])
    covariance = covariance_of(influence_of_white(part, influence), efficient[1].residual_sigma ** 2)
    if (added := efficient[1].by_telemetry) is not None:
        covariance[: len(added), : len(added)] += added
    return Compared(
        efficient=efficient[0],
        robust=robust[0],
        covariance=covariance,
        agreement=agreement_of(efficient[1], robust[1], covariance),
    )


def agreement_of(
    efficient: Estimate | CombinedEstimate, robust: Estimate | CombinedEstimate, covariance: Covariance
) -> Agreement:
    """Test that two estimators agree.

    Args:
        efficient: the answer of the one.
        robust: of the other.
        covariance: of both together by the gyro's noise, as `Compared` has it.
    """
    apart = np.hstack([np.eye(6, len(efficient.joint)), -np.eye(6, len(robust.joint))])
    shift = efficient.considered - robust.considered
    return estimators_agreement(efficient.theta - robust.theta, apart @ covariance @ apart.T + shift @ shift.T)


def with_spread(by_name: Mapping[str, AnyEstimate], compared: Compared | None) -> Mapping[str, AnyEstimate]:
    """Return the estimates with the difference of two that should agree, and do not, in the covariance of both."""
    if compared is None or not compared.agreement.refused:
        return by_name
    pair = (compared.efficient, compared.robust)
    difference = by_name[pair[0]].theta - by_name[pair[1]].theta
    wider = {name: by_name[name].spread + np.outer(difference, difference) for name in pair}
    return {name: replace(each, spread=wider.get(name, each.spread)) for name, each in by_name.items()}


def _neglected(estimate: Estimate, part: Telemetry, drive: Drive, motion: Motion) -> Iterator[NeglectedTorque]:
    """Yield the constant torques that are not estimated, each with the size that matters."""
    estimated: dict[ConstantTorque, tuple[ConstantTorque, ...]] = {
        "none": ("body", "inertial"),
        "body": ("inertial",),
        "inertial": ("body",),
        "both": (),
    }
    for frame in estimated[part.constant_torque]:
        basis = torque_basis(replace(part, constant_torque=frame, surroundings=None), drive.grid_time)
        columns = torque_sensitivity(drive, motion, basis)
        shift = _influence(estimate, part)[:6] @ columns.reshape(-1, columns.shape[-1])
        moved: Theta = np.abs(shift).max(axis=1) / estimate.std
        worst = int(np.argmax(moved))
        yield NeglectedTorque(frame=frame, size=float(1.0 / moved[worst]), parameter=PARAMETER_NAMES[worst])
