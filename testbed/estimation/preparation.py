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
from testbed.estimation.regression import rows_of
from testbed.estimation.telemetry import Telemetry, covered_part
from testbed.signals import AXES

NOISE_SHARE = np.diag([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
"""Mean of Γ(e)ᵀ Γ(e) for white e of unit variance."""


@lru_cache(maxsize=1)  # all estimators ask for the same one in turn
def identifiable_part(telemetry: Telemetry, settings: EstimationSettings) -> Telemetry:
    """Return the usable part of the telemetry, after a test of which parameters its motion identifies.

    The look is at a simulated motion: gyro noise excites every direction, and a fit to it would answer with confidence
    where there is nothing to see.

    Args:
        telemetry: one run, or flights side by side.
        settings: the nominal inertia.

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
    turns = np.any(body_rate, axis=-2).reshape(-1, 3).all(axis=0)
    dead = [axis for index, axis in enumerate(AXES) if not turns[index]]
    if dead:
        raise UnidentifiableError(
            f"the inertia cannot be determined: the gyro reads exactly zero throughout about {', '.join(dead)}, where "
            "the actuators should have turned the body; check the gyro's channels"
        )


def likely_theta(telemetry: Telemetry, nominal_theta: Theta) -> Theta:
    """Return the nominal inertia, corrected in the directions in which the gyro shows more than its own noise.

    Least squares in momentum form with the noise's mean share taken out of the normal matrix, so that what is excited
    is not pulled down by noise, and what is not excited stays nominal. Shape (..., 6), kg·m².
    """
    equation, variance = measured_equation(telemetry), telemetry.gyro_noise**2
    regressor = without_momentum(rows_of(unknown_columns(telemetry, equation.regressor)))
    samples = equation.response.shape[-2]
    normal = regressor.mT @ regressor - samples * variance * NOISE_SHARE
    response = equation.response.reshape(*regressor.shape[:-1])
    wanted = np.matvec(regressor.mT, response) - np.matvec(normal, nominal_theta)
    strength, directions = np.linalg.eigh(normal)
    noise_spread = 2.0 * variance * np.sqrt(2.0 * samples)
    seen = strength > np.maximum(SIGNIFICANCE * noise_spread, RELATIVE_RANK**2 * strength[..., -1:])
    along = np.divide(np.matvec(directions.mT, wanted), strength, where=seen, out=np.zeros_like(strength))
    likely = nominal_theta + np.matvec(directions, along)
    return np.where(is_physical(likely)[..., None], likely, nominal_theta)
