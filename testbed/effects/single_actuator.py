"""What the effects in one of many actuators share: which one, and the torque of its thrust alone."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.effects.contract import thruster_index
from testbed.estimation.telemetry import Thrusters
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks


class SingleActuator(Hooks):
    """An effect in one actuator."""

    def __init__(self, component: str) -> None:
        """Take the actuator's number, from 1."""
        self.index = thruster_index(component)

    def own_thrust(self, grid: Grid) -> Array:
        """Return what it is commanded, shape (R, 1, L + T, 1), N."""
        assert grid.thrust is not None
        return np.asarray(grid.thrust[..., [self.index]])

    def own_torque_B(self, grid: Grid) -> Array:
        """Return the torque of that thrust, shape (R, 1, L + T, 3), N·m."""
        return np.asarray(self.own_thrust(grid) * thrusters_of(grid).torque_per_thrust_B[self.index])


def thrusters_of(grid: Grid) -> Thrusters:
    """Return the actuators of runs that know their single commands."""
    assert grid.thrusters is not None
    return grid.thrusters
