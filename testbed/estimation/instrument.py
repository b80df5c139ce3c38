"""The instrument's motion: near the true one, and free of the gyro noise that the regressor carries."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from testbed.arrays import Array, Theta, Vector3, Vectors3
from testbed.errors import InputError
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.momentum_equation import likely_motion
from testbed.estimation.motion import drive_of, is_physical, simulate, with_torque
from testbed.estimation.regression import Solution
from testbed.estimation.telemetry import Telemetry

APART = "flights of which some are iterated on and some are not go on one by one"
ITERATIONS = 3
"""Rounds of the iterated instrument; a fourth moves the estimate by less than 1 % of its standard deviation."""


def refined(
    telemetry: Telemetry, settings: EstimationSettings, solve: Callable[[Vectors3, Theta], Solution]
) -> tuple[Solution, int]:
    """Return the solution with the instrument of the settings, and the number of rounds.

    Args:
        telemetry: one run.
        settings: which instrument.
        solve: from the instrument's ω, shape (..., N, 3), rad/s, and the inertia known so far to a solution.

    Raises:
        InputError: the reference is asked for and there is none, or flights side by side part.
    """
    solution = solve(_first_rate(telemetry, settings), settings.nominal_theta)
    rounds = 1
    while settings.instrument == "iterated" and rounds < ITERATIONS and _all_physical(solution):
        theta = solution.parameters[..., :6]
        momentum_B = solution.parameters[..., 6:9] if telemetry.momentum_unknowns else np.zeros(3)
        torque = telemetry.torque_of(solution.parameters)
        solution = solve(_simulated_rate(telemetry, theta, momentum_B, torque), theta)
        rounds += 1
    return solution, rounds


def _all_physical(solution: Solution) -> bool:
    """Return whether bodies can have the inertias, of flights side by side alike."""
    physical = is_physical(solution.parameters[..., :6])
    if physical.any() != physical.all():
        raise InputError(APART)
    return bool(physical.all())


def _first_rate(telemetry: Telemetry, settings: EstimationSettings) -> Vectors3:
    if settings.instrument != "reference":
        _, motion = likely_motion(telemetry, settings.nominal_theta)
        return motion.body_rate
    if settings.reference_rate is None:
        raise InputError("the reference instrument needs the maneuver's reference rate, which is not given")
    return settings.reference_rate(telemetry.gyro_time)


def _simulated_rate(telemetry: Telemetry, theta: Theta, momentum_B: Vector3, torque: Array) -> Vectors3:
    return simulate(with_torque(drive_of(telemetry), torque), theta, momentum_B).body_rate
