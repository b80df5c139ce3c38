"""The actuators do what they are asked for a moment later."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.actuator_response import late_momentum, late_torque
from testbed.effects.contract import SHOWING_UNITS, Effect, Extension, Parameter
from testbed.plant.unit_additions import ActuatorResponse
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Delayed(Hooks):
    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return asked_B if grid.torque_held else late_torque(asked_B, grid, np.zeros(1), value[:, 0])

    @override
    def held_torque_delay(self, value: Array) -> Array:
        return value[:, 0]

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        return late_momentum(momentum_B, grid, np.zeros(1), value[:, 0])


@final
class ActuatorDelay(Effect):
    """τ(t) = τ_cmd(t - T), τ_cmd the commanded torque; of actuators that hold momentum, h(t) = h_recorded(t - T)."""

    id = "actuator_delay"
    components = ("actuators",)
    parameters = (Parameter(name="delay_s", unit="s", typical=0.02, lower=0.0, upper=0.5, plausible=(0.0, 0.3)),)
    needs = ("applied_torque_or_cluster_momentum",)
    measured_by = SHOWING_UNITS
    sentence = "The actuators do what they are asked for a moment later."
    look_alikes = ("actuator_lag", "gyro_latency", "telemetry_skew")
    confirm = "Steps of the torque: behind a delay the body's rate waits and then breaks off, behind a lag it bends."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Delayed()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(ActuatorResponse(delay=float(values[0])),))
