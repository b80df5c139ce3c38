"""The motor of one wheel, or of each wheel alike, follows its command late."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import ALL_WHEELS, WHEELS, Effect, Extension, Parameter, only_wheel, wheels_named
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.stamps import stamp_jitter
from testbed.scenario.actuators import wheel_count
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Behind(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def wheel_lag(self, value: Array, wheels: int) -> Array:
        return only_wheel(self._component, value, wheels)


@final
class WheelLag(Effect):
    """T τ̇ = u - τ, T of one wheel or the same of all: motors of one make are late alike."""

    id = "wheel_lag"
    components = (*WHEELS, ALL_WHEELS)
    parameters = (
        Parameter(name="time_constant_s", unit="s", typical=0.02, lower=0.0, upper=1.0, plausible=(0.0, 0.5)),
    )
    needs = ("wheel_speed", "wheel_torque_command")
    measured_by = ("wheel_speed",)
    sentence = "The motor of {component} gives the torque that it is commanded with a lag."
    look_alikes = ("wheel_torque_scale", "wheel_delay")
    confirm = "A step of that torque: behind a lag the speed bends before it grows along a line."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Behind(component)

    @override
    def unresolved(self, grid: Grid) -> Array:
        """A command that jumps counts from the row that shows it, which was written a little before or after."""
        return np.array([stamp_jitter(grid.runs)])

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        wheels = wheel_count(scenario.actuators)
        lags = np.array(per_unit(scenario.truth.wheel_motor_lag_s, wheels, 0.0))
        lags[wheels_named(component)] += values[0]
        return Extension(scenario={"truth": {"wheel_motor_lag_s": lags.tolist()}})
