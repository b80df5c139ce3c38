"""All actuators give more or less torque than they are asked for, alike."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Scaled(Hooks):
    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return np.asarray(asked_B * (1.0 + value[:, :1, None]))


@final
class ActuatorGain(Effect):
    """τ = (1 + k) τ_asked; what torque and inertia have in common shows only as far as the inertia is known."""

    id = "actuator_gain"
    components = ("actuators",)
    parameters = (Parameter(name="gain_error", unit="1", typical=0.1, lower=-0.99, upper=10.0),)
    needs = ("applied_torque",)
    sentence = "The actuators give more or less torque than they are asked for, all in proportion."
    look_alikes = ("inertia", "gyro_scale")
    confirm = (
        "A known torque, such as a weight at a known arm, beside that of the actuators; or a better known inertia."
    )
    flies = False

    @override
    def hooks(self, component: str) -> Hooks:
        return _Scaled()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
