"""Output error: the inertia and the initial momentum that make the measured rates most likely."""

from __future__ import annotations

import numpy as np
import scipy

from testbed.arrays import Array, Regressor, Theta, Vector3
from testbed.errors import InputError
from testbed.estimation.bound import rate_columns
from testbed.estimation.estimate import Estimate, EstimationSettings, estimate_of
from testbed.estimation.identifiability import inertia_size
from testbed.estimation.likelihood import most_likely, require_physical
from testbed.estimation.momentum_equation import mean_momentum
from testbed.estimation.motion import Drive, Motion, drive_of, simulate, with_torque
from testbed.estimation.preparation import identifiable_part, likely_theta
from testbed.estimation.telemetry import Telemetry


def output_error(telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
    """Estimate the inertia by the least squares of measured minus predicted rates, the maximum likelihood of eq. (4).

    Levenberg-Marquardt with analytic sensitivities. The covariance is that of the linearised problem at the answer,
    scaled by its residual.

    Args:
        telemetry: one run; the initial momentum is estimated jointly unless it is known to be zero.
        settings: the nominal inertia, which the search starts near.

    Raises:
        InputError: too few samples, or the search finds no minimum.
        UnidentifiableError: the motion leaves directions of the inertia open.

    Source: paper eqs. (1), (4), (12), (13).
    """
    part = identifiable_part(telemetry, settings)
    answer = _search(part, _start(part, settings))
    variance = float(answer.fun @ answer.fun) / (answer.fun.size - answer.x.size)
    inverse = np.linalg.inv(answer.jac.T @ answer.jac)
    covariance = variance * inverse  # eqs. (12), (13)
    _require_minimum(answer.x[:6], covariance)
    return estimate_of(
        part,
        answer.x,
        covariance,
        influence=inverse @ answer.jac.T,
        time=part.gyro_time,
        residual=-answer.fun,
        unit="rad/s",
        sigma=float(np.sqrt(variance)),
        iterations=answer.njev,
    )


def _search(telemetry: Telemetry, start: Array) -> scipy.optimize.OptimizeResult:
    """Minimise the squares of predicted minus measured rates over the unknowns."""
    drive = drive_of(telemetry)

    def acting(unknowns: Array) -> Drive:
        return with_torque(drive, telemetry.torque_of(unknowns))

    def motion(unknowns: Array) -> Motion:
        require_physical(unknowns[:6])
        return simulate(acting(unknowns), unknowns[:6], _momentum(telemetry, unknowns))

    def sensitivity(unknowns: Array, at: Motion) -> Regressor:
        return rate_columns(telemetry, acting(unknowns), at)  # gravity's feedback goes with the offset

    return most_likely(telemetry.body_rate, start, motion, sensitivity)


def _require_minimum(theta: Theta, covariance: Array) -> None:
    """Refuse where the search ran off to an inertia so large that the rates no longer depend on it."""
    size, std = inertia_size(theta), float(np.sqrt(np.abs(np.diag(covariance)[:6]).max()))
    if std > size:
        raise InputError(
            f"output error found no minimum: it ended at an inertia of {size:.2g} kg m2, uncertain by {std:.2g} kg m2; "
            "check the signs of gyro and actuators, and that the scenario is of this platform"
        )


def _start(telemetry: Telemetry, settings: EstimationSettings) -> Array:
    """Return the parameters to start from: a likely inertia, the momentum that fits it best if unknown, no torques."""
    theta = likely_theta(telemetry, settings.nominal_theta)
    momentum_B = mean_momentum(telemetry, theta)[: telemetry.momentum_unknowns]
    return np.concatenate([theta, momentum_B, np.zeros(telemetry.torque_unknowns)])


def _momentum(telemetry: Telemetry, unknowns: Array) -> Vector3:
    return unknowns[6:9] if telemetry.momentum_unknowns else np.zeros(3)
