"""Output error: the inertia and the initial momentum that make the measured rates most likely."""

from __future__ import annotations

from functools import partial

import numpy as np

from testbed.arrays import Array, Covariance, Indices, Regressor, Theta, Vector3
from testbed.errors import InputError
from testbed.estimation.bound import rate_columns
from testbed.estimation.estimate import Estimate, EstimationSettings, estimates_of
from testbed.estimation.identifiability import inertia_size
from testbed.estimation.levenberg_marquardt import Searches
from testbed.estimation.likelihood import most_likely, require_physical
from testbed.estimation.momentum_equation import mean_momentum
from testbed.estimation.motion import Drive, Motion, drive_of, drive_of_some, simulate, with_torque
from testbed.estimation.preparation import identifiable_part, likely_theta
from testbed.estimation.stated_noise import influence_of_errors, whitened
from testbed.estimation.telemetry import Telemetry


def output_error(telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
    """Estimate the inertia from one run, as `output_errors`."""
    (estimate,) = output_errors(telemetry, settings)
    return estimate


def output_errors(telemetry: Telemetry, settings: EstimationSettings) -> list[Estimate]:
    """Estimate the inertia by the least squares of measured minus predicted rates, the maximum likelihood of eq. (4).

    Where the gyro's bias is stated to wander, of what that does not foretell. Levenberg-Marquardt with analytic
    sensitivities, all flights side by side in every round. The covariance is that of the linearised problem at the
    answer, scaled by its residual.

    Args:
        telemetry: one run, or flights side by side; the initial momentum is estimated jointly unless it is known to be
            zero.
        settings: the nominal inertia, which the search starts near.

    Raises:
        InputError: too few samples, or the search finds no minimum.
        UnidentifiableError: the motion leaves directions of the inertia open.

    Source: paper eqs. (1), (4), (12), (13).
    """
    part = identifiable_part(telemetry, settings)
    answer = _search(part, _start(part, settings))
    freedom = answer.residual.shape[1] - answer.unknowns.shape[1]
    variance = np.vecdot(answer.residual, answer.residual) / freedom
    inverse = np.linalg.inv(answer.columns.mT @ answer.columns)
    covariance = variance[:, None, None] * inverse  # eqs. (12), (13)
    _require_minima(answer.unknowns[:, :6], covariance)
    return estimates_of(
        part,
        answer.unknowns,
        covariance,
        influence=influence_of_errors(part, inverse @ answer.columns.mT),
        residual=-answer.residual,
        sigma=np.sqrt(variance),
        iterations=answer.rounds,
    )


def _search(telemetry: Telemetry, start: Array) -> Searches:
    """Minimise the squares of predicted minus measured rates over the unknowns of each flight, shape (F, P)."""
    drive, lead = drive_of(telemetry), telemetry.body_rate.shape[:-2]

    def acting(unknowns: Array, flights: Indices) -> Drive:
        own = drive if len(flights) == len(start) else drive_of_some(drive, flights)
        return with_torque(own, telemetry.torque_of(unknowns))

    def motion(unknowns: Array, flights: Indices) -> Motion:
        unknowns = unknowns if lead else unknowns[0]
        require_physical(unknowns[..., :6])
        return simulate(acting(unknowns, flights), unknowns[..., :6], _momentum(telemetry, unknowns))

    def sensitivity(unknowns: Array, flights: Indices, at: Motion) -> Regressor:
        unknowns = unknowns if lead else unknowns[0]
        return rate_columns(telemetry, acting(unknowns, flights), at)  # gravity's feedback goes with the offset

    measured_rate = telemetry.body_rate.reshape(len(start), -1, 3)
    return most_likely(measured_rate, start, motion, sensitivity, partial(whitened, telemetry))


def _require_minima(theta: Theta, covariance: Covariance) -> None:
    """Refuse where a search ran off to an inertia so large that the rates no longer depend on it."""
    sizes = inertia_size(theta)
    stds = np.sqrt(np.abs(np.diagonal(covariance, axis1=1, axis2=2)[:, :6]).max(axis=1))
    for size, std in zip(sizes, stds, strict=True):
        if std > size:
            raise InputError(
                f"output error found no minimum: it ended at an inertia of {size:.2g} kg m2, uncertain by {std:.2g} "
                "kg m2; check the signs of gyro and actuators, and that the scenario is of this platform"
            )


def _start(telemetry: Telemetry, settings: EstimationSettings) -> Array:
    """Return the unknowns to start from: a likely inertia, the momentum that fits it best if unknown, no torques."""
    theta = likely_theta(telemetry, settings.nominal_theta)
    start = np.zeros((*theta.shape[:-1], 6 + telemetry.momentum_unknowns + telemetry.torque_unknowns))
    start[..., :6] = theta
    if telemetry.momentum_unknowns:
        start[..., 6:9] = mean_momentum(telemetry, theta)
    return start.reshape(-1, start.shape[-1])


def _momentum(telemetry: Telemetry, unknowns: Array) -> Vector3:
    return unknowns[..., 6:9] if telemetry.momentum_unknowns else np.zeros(3)
