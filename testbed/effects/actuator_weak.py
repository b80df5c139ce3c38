"""One actuator of many gives less than it is commanded."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import HOLDING_MOMENTUM, THRUSTERS, Effect, Extension, Parameter
from testbed.effects.single_actuator import SingleActuator
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Weak(SingleActuator):
    @override
    def asked_torque(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return np.asarray(asked_B - value[:, :1, None] * self.own_torque_B(grid))


@final
class ActuatorWeak(Effect):
    """F = (1 - l) F_commanded; l below zero of one that gives more."""

    id = "actuator_weak"
    components = THRUSTERS
    # Motors of one kind give the same to some per cent, and with age all lose.
    parameters = (Parameter(name="lost_share", unit="1", typical=0.1, lower=-1.0, upper=1.0, plausible=(-0.05, 1.0)),)
    needs = ("thrust",)
    measured_by = HOLDING_MOMENTUM
    sentence = "{component} gives less thrust than it is commanded, or more where the lost share is negative."
    look_alikes = ("actuator_misaligned", "thrust_offset", "actuator_gain")
    confirm = "A step of this actuator alone, on a balance or in flight: its thrust falls short in proportion."
    flies = False

    @override
    def hooks(self, component: str) -> Hooks:
        return _Weak(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
