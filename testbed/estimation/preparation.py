"""What every estimator does first: keep the covered samples, and refuse a motion that leaves the inertia open."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from testbed.arrays import Theta, Vectors3
from testbed.errors import UnidentifiableError
from testbed.estimation.bound import rate_columns
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.identifiability import (
    RELATIVE_RANK,
    SIGNIFICANCE,
    inertia_size,
    require_identifiable,
    without_momentum,
)
from testbed.estimation.momentum_equation import likely_motion, measured_equation, unknown_columns
from testbed.estimation.motion import is_physical
from testbed.estimation.telemetry import Telemetry, covered_part
from testbed.signals import AXES

NOISE_SHARE = np.diag([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
"""Mean of Γ(e)ᵀ Γ(e) for white e of unit variance."""


@lru_cache(maxsize=1)  # all estimators ask for the same one in turn
def identifiable_part(telemetry: Telemetry, settings: EstimationSettings) -> Telemetry:
    """Return the usable part of the telemetry, after a test of which parameters its motion identifies.

    The look is at a simulated motion: gyro noise excites every direction, and a fit to it would answer with confidence
    where there is nothing to see.

    Raises:
        InputError: too few samples.
        UnidentifiableError: the motion leaves directions of the inertia open, or the gyro shows none of it.
    """
    part = covered_part(telemetry)
    theta = likely_theta(part, settings.nominal_theta)
    drive, motion = likely_motion(part, theta)
    require_identifiable(rate_columns(part, drive, motion), part.gyro_noise, inertia_size(theta), motion.body_rate)
    _require_live_gyro(part.body_rate)
    return part


def _require_live_gyro(body_rate: Vectors3) -> None:
    dead = [axis for axis, rate in zip(AXES, body_rate.T, strict=True) if not rate.any()]
    if dead:
        raise UnidentifiableError(
            f"the inertia cannot be determined: the gyro reads exactly zero throughout about {', '.join(dead)}, where "
            "the actuators should have turned the body; check the gyro's channels"
        )


def likely_theta(telemetry: Telemetry, nominal_theta: Theta) -> Theta:
    """Return the nominal inertia, corrected in the directions in which the gyro shows more than its own noise.

    Least squares in momentum form with the noise's mean share taken out of the normal matrix, so that what is excited
    is not pulled down by noise, and what is not excited stays nominal. Shape (6,), kg·m².
    """
    equation, variance = measured_equation(telemetry), telemetry.gyro_noise**2
    columns = unknown_columns(telemetry, equation.regressor)
    regressor = without_momentum(columns.reshape(-1, columns.shape[-1]))
    samples = len(equation.response)
    normal = regressor.T @ regressor - samples * variance * NOISE_SHARE
    wanted = regressor.T @ equation.response.ravel() - normal @ nominal_theta
    strength, directions = np.linalg.eigh(normal)
    noise_spread = 2.0 * variance * np.sqrt(2.0 * samples)
    seen = strength > np.maximum(SIGNIFICANCE * noise_spread, RELATIVE_RANK**2 * strength[-1])
    known = directions[:, seen]
    likely = np.asarray(nominal_theta + known @ ((known.T @ wanted) / strength[seen]))
    return likely if is_physical(likely) else nominal_theta
