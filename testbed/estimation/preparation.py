"""What every estimator does first: keep the covered samples, and refuse a motion that leaves the inertia open."""

from __future__ import annotations

from testbed.arrays import Theta
from testbed.estimation.bound import rate_columns
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.identifiability import require_identifiable
from testbed.estimation.momentum_equation import mean_momentum
from testbed.estimation.motion import drive_of, simulate
from testbed.estimation.telemetry import Telemetry, covered_part


def identifiable_part(telemetry: Telemetry, settings: EstimationSettings) -> Telemetry:
    """Return the usable part of the telemetry, after a look at what its motion can tell.

    The look is at the nominal model's motion, which is free of noise: noise excites every direction, and a fit to it
    would answer with confidence where there is nothing to see.

    Raises:
        InputError: too few samples.
        UnidentifiableError: the motion leaves directions of the inertia open.
    """
    part = covered_part(telemetry)
    drive = drive_of(part)
    theta = settings.nominal_theta
    motion = simulate(drive, theta, mean_momentum(part, part.body_rate, theta))
    require_identifiable(rate_columns(part, drive, motion), part.gyro_noise, inertia_size(theta), motion.body_rate)
    return part


def inertia_size(theta: Theta) -> float:
    """Return the mean principal moment, kg·m²."""
    return float(theta[:3].mean())
