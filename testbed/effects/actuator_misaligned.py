"""One actuator of many pushes in another direction than it is meant to."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import HOLDING_MOMENTUM, THRUSTERS, Effect, Extension, Parameter
from testbed.effects.single_actuator import SingleActuator, thrusters_of
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Tilted(SingleActuator):
    @override
    def asked_torque(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        thrusters = thrusters_of(grid)
        changes_B = across(thrusters.direction_B[self.index])
        per_tilt = np.stack([thrusters.torque_along(np.tile(way, (len(thrusters.reaction), 1))) for way in changes_B])
        change_B = value @ per_tilt[:, self.index]
        return np.asarray(asked_B + self.own_thrust(grid) * change_B[:, None])


def across(direction_B: Array) -> Array:
    """Return two unit vectors across a direction, shape (2, 3): the first across the axis that is least along it too.

    Args:
        direction_B: unit vector, shape (3,).
    """
    first = np.cross(np.eye(3)[np.argmin(np.abs(direction_B))], direction_B)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction_B, first)])


@final
class ActuatorMisaligned(Effect):
    """F is turned by small angles towards two directions across its own."""

    id = "actuator_misaligned"
    components = THRUSTERS
    parameters = tuple(
        Parameter(name=f"tilt_{number}_rad", unit="rad", typical=0.05, lower=-0.8, upper=0.8, plausible=(-0.2, 0.2))
        for number in (1, 2)
    )
    needs = ("thrust",)
    measured_by = HOLDING_MOMENTUM
    sentence = "{component} pushes in another direction than it is meant to, as a bent mount does."
    look_alikes = ("actuator_weak", "thrust_offset")
    confirm = "A step of this actuator alone: the body turns about another axis than it should."
    flies = False

    @override
    def hooks(self, component: str) -> Hooks:
        return _Tilted(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
