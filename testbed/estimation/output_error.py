"""Output error: the inertia and the initial momentum that make the measured rates most likely."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import optimize

from testbed.arrays import Array, Regressor, Response, Vector3
from testbed.estimation.bound import rate_columns
from testbed.estimation.estimate import Estimate, EstimationSettings, estimate_of
from testbed.estimation.momentum_equation import mean_momentum
from testbed.estimation.motion import Motion, drive_of, is_physical, simulate
from testbed.estimation.preparation import identifiable_part, likely_theta
from testbed.estimation.telemetry import Telemetry

REFUSED = 1e3
"""rad/s; the residual of an inertia that is not tried, larger than any other."""


def output_error(telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
    """Estimate the inertia by the least squares of measured minus predicted rates, the maximum likelihood of eq. (4).

    Levenberg-Marquardt with analytic sensitivities. The covariance is that of the linearised problem at the answer,
    scaled by its residual.

    Args:
        telemetry: one run; the initial momentum is estimated along unless it is known to be zero.
        settings: the nominal inertia, which the search starts near.

    Raises:
        InputError: too few samples, or the search does not converge.
        UnidentifiableError: the motion leaves directions of the inertia open.

    Source: paper eqs. (1), (4), (12), (13).
    """
    part = identifiable_part(telemetry, settings)
    drive = drive_of(part)

    @lru_cache(maxsize=1)  # the residual and its sensitivities are asked for at the same parameters
    def motion(parameters: bytes) -> Motion:
        unknowns = np.frombuffer(parameters)
        return simulate(drive, unknowns[:6], _momentum(unknowns))

    def residual(parameters: Array) -> Response:
        if not is_physical(parameters[:6]):
            return np.full(part.body_rate.size, REFUSED)
        return np.asarray((motion(parameters.tobytes()).body_rate - part.body_rate).ravel())

    def sensitivity(parameters: Array) -> Regressor:
        return rate_columns(part, drive, motion(parameters.tobytes()))

    answer = optimize.least_squares(residual, _start(part, settings), sensitivity, method="lm", x_scale="jac")
    variance = float(answer.fun @ answer.fun) / (answer.fun.size - answer.x.size)
    return estimate_of(
        part,
        answer.x,
        variance * np.linalg.inv(answer.jac.T @ answer.jac),  # eqs. (12), (13)
        time=part.gyro_time,
        residual=-answer.fun,
        unit="rad/s",
        sigma=float(np.sqrt(variance)),
        iterations=answer.njev,
    )


def _start(telemetry: Telemetry, settings: EstimationSettings) -> Array:
    """Return the parameters to start from: a likely inertia, and the momentum that fits it best where unknown."""
    theta = likely_theta(telemetry, settings.nominal_theta)
    if telemetry.initial_momentum == "zero":
        return theta
    return np.concatenate([theta, mean_momentum(telemetry, telemetry.body_rate, theta)])


def _momentum(unknowns: Array) -> Vector3:
    return unknowns[6:] if len(unknowns) > 6 else np.zeros(3)
