"""The motion at one instant, as formulas read it: names of quantities, their units and values."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from testbed.arrays import Array
from testbed.signals import MOST_UNITS

AXES = ("x", "y", "z")
TIME = "t"
RATES = tuple(f"w_{axis}" for axis in AXES)
"""Components of the body rate, rad/s."""
ATTITUDES = tuple(f"R_{row}{column}" for row in AXES for column in AXES)
"""Entries of the attitude: R_zx is the component along the start's z axis of the body's x axis."""
GIMBALS = tuple(f"gimbal_{number}" for number in range(1, MOST_UNITS + 1))
"""Gimbal angles, rad."""
GIMBAL_RATES = tuple(f"gimbal_rate_{number}" for number in range(1, MOST_UNITS + 1))
"""Gimbal rates, rad/s."""
TORQUES = tuple(f"torque_{axis}" for axis in AXES)
"""Components of the torque of actuators that store no momentum, as telemetry has it, N·m, body axes."""
ELAPSED = "elapsed"
"""Time in the runs laid end to end, s, in which an instant is one of a single run; `once` alone reads it."""
QUANTITIES = (TIME, *RATES, *ATTITUDES, *GIMBALS, *GIMBAL_RATES, *TORQUES)
"""All that a formula may contain, in the order in which its factors are written."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """What formulas read at one instant; real or complex, of any leading shape that broadcasts.

    Attributes:
        time: since the first sample of the run, s.
        body_rate: ω, shape (..., 3), rad/s, body axes.
        attitude: R_AB, shape (..., 3, 3): turns body components into those of A, the body's axes at the first sample.
        gimbal_angle: shape (..., M), rad; without units M = 0.
        gimbal_rate: shape (..., M), rad/s.
        elapsed: time in the runs laid end to end, s.
        applied_torque: of actuators that store no momentum, shape (..., 3), N·m, body axes.
    """

    time: Array
    body_rate: Array
    attitude: Array = field(default_factory=lambda: np.eye(3))
    gimbal_angle: Array = field(default_factory=lambda: np.zeros(0))
    gimbal_rate: Array = field(default_factory=lambda: np.zeros(0))
    elapsed: Array = field(default_factory=lambda: np.zeros(()))
    applied_torque: Array = field(default_factory=lambda: np.zeros(3))

    def value(self, quantity: str) -> Array:
        """Return a quantity by its name in `QUANTITIES`."""
        if quantity == TIME:
            return self.time
        if quantity == ELAPSED:
            return self.elapsed
        if quantity in RATES:
            return np.asarray(self.body_rate[..., RATES.index(quantity)])
        if quantity in ATTITUDES:
            row, column = divmod(ATTITUDES.index(quantity), len(AXES))
            return np.asarray(self.attitude[..., row, column])
        if quantity in TORQUES:
            return np.asarray(self.applied_torque[..., TORQUES.index(quantity)])
        of_unit = self.gimbal_rate if quantity in GIMBAL_RATES else self.gimbal_angle
        return np.asarray(of_unit[..., unit_of(quantity) - 1])


def unit_of(quantity: str) -> int:
    """Return the number, from 1, of the unit whose angle or rate a quantity is; 0 where it is of none."""
    number = re.fullmatch(r"gimbal_(?:rate_)?(\d+)", quantity)
    return int(number[1]) if number else 0


def needs_attitude(quantity: str) -> bool:
    """Return whether a quantity is an entry of the attitude."""
    return quantity in ATTITUDES


def depends_on_motion(quantity: str) -> bool:
    """Return whether the body's own motion changes a quantity; others are as telemetry has them."""
    return quantity in RATES or quantity in ATTITUDES
