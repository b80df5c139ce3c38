"""All actuators give more or less torque than they are asked for, alike."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter, Quantity
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Scaled(Hooks):
    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return np.asarray(asked_B * np.exp(value[:, None]))


@final
class ActuatorGain(Effect):
    """τ = exp(k) τ_asked about each body axis; of torque and inertia, only the ratio shows."""

    id = "actuator_gain"
    components = ("actuators",)
    parameters = tuple(
        Parameter(name=f"log_gain_{axis}", unit="1", typical=0.1, lower=-5.0, upper=5.0) for axis in "xyz"
    )
    needs = ("applied_torque",)
    sentence = "The actuators give more or less torque about an axis than they are asked for, in proportion."
    look_alikes = ("inertia", "gyro_scale")
    confirm = (
        "A known torque, such as a weight at a known arm, beside that of the actuators; or a better known inertia."
    )
    flies = False

    @override
    def hooks(self, component: str) -> Hooks:
        return _Scaled()

    @override
    def quantities(self, values: Array, std: Array) -> tuple[Quantity, ...]:
        gain = np.exp(values)
        names = zip("xyz", gain, gain * std, strict=True)
        return tuple(
            Quantity(name=f"gain_{axis}", unit="1", value=float(value), std=float(error))
            for axis, value, error in names
        )

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
