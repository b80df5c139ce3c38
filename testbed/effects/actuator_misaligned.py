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
        drawn_B = thrusters.direction_B[self.index]
        ways_B = np.stack([drawn_B, *across(drawn_B)])
        torques_B = [thrusters.torque_along(np.tile(way, (len(thrusters.reaction), 1)))[self.index] for way in ways_B]
        change_B = _turned(value) @ np.stack(torques_B)
        return np.asarray(asked_B + self.own_thrust(grid) * change_B[:, None])


def _turned(tilt: Array) -> Array:
    """Return what a direction changes by along itself and two directions across, shape (..., 3).

    Args:
        tilt: angles by which it is turned towards the one, then towards the other, shape (..., 2), rad.
    """
    first, second = tilt[..., 0], tilt[..., 1]
    along = np.cos(second) * np.cos(first) - 1.0
    return np.stack([along, np.cos(second) * np.sin(first), np.sin(second)], axis=-1)


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
    """F is turned towards two directions across its own, by the one angle and then by the other; its size stays.

    The first direction is e × d, the second d × (e × d), with d the actuator's own direction and e the body axis that
    is the least along it, the first of several: of a propeller that pushes along z the first is -y and the second x.
    """

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
