"""The motors of all wheels give their torques later than their commands are stamped."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import ALL_WHEELS, Effect, Extension, Parameter, only_wheel
from testbed.plant.unit_additions import WheelDelay as DelayedMotors
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.stamps import stamp_jitter
from testbed.scenario.scenario import Scenario


class _Delayed(Hooks):
    @override
    def wheel_delay(self, value: Array, wheels: int) -> Array:
        return only_wheel(ALL_WHEELS, value, wheels)


@final
class WheelDelay(Effect):
    """τ(t) = u(t - T), the same of all wheels: what a data bus, a computer's cycle, or a telemetry clock makes late."""

    id = "wheel_delay"
    components = (ALL_WHEELS,)
    parameters = (Parameter(name="delay_s", unit="s", typical=0.02, lower=0.0, upper=0.5, plausible=(0.0, 0.3)),)
    needs = ("wheel_speed", "wheel_torque_command")
    measured_by = ("wheel_speed",)
    sentence = "The motors of the wheels give their torques later than their commands are stamped."
    look_alikes = ("wheel_lag",)
    confirm = "Steps of the torque: behind a delay all speeds wait and then break off, behind a lag one of them bends."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Delayed()

    @override
    def unresolved(self, grid: Grid) -> Array:
        """A command that jumps counts from the row that shows it, which was written a little before or after."""
        return np.array([stamp_jitter(grid.runs)])

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(DelayedMotors(delay=float(values[0])),))
