"""The actuators follow what they are asked for with a first-order lag."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.actuator_response import late_momentum, late_torque
from testbed.effects.contract import SHOWING_UNITS, THRUSTERS, Effect, Extension, Parameter
from testbed.effects.single_actuator import SingleActuator
from testbed.errors import InputError
from testbed.plant.unit_additions import ActuatorResponse
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Lagging(Hooks):
    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return late_torque(asked_B, grid, value[:, 0], np.zeros(1))

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        return late_momentum(momentum_B, grid, value[:, 0], np.zeros(1))


class _OneLagging(SingleActuator):
    @override
    def asked_torque(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        own_B = self.own_torque_B(grid)
        return np.asarray(asked_B + late_torque(own_B, grid, value[:, 0], np.zeros(1)) - own_B)


@final
class ActuatorLag(Effect):
    """T dτ/dt = τ_cmd - τ, τ_cmd the commanded torque; of actuators that hold momentum, T dh/dt = h_recorded - h."""

    id = "actuator_lag"
    components = ("actuators", *THRUSTERS)
    parameters = (
        Parameter(name="time_constant_s", unit="s", typical=0.03, lower=0.0, upper=2.0, plausible=(0.0, 1.9)),
    )
    needs = ("applied_torque_or_cluster_momentum",)
    measured_by = SHOWING_UNITS
    sentence = "The torque or momentum of {component} follows what is asked for with a lag, as motors with inertia do."
    look_alikes = ("actuator_delay", "gyro_bandwidth", "gyro_latency")
    confirm = "Steps of the torque: behind a lag the body's rate bends, behind a delay it waits and then breaks off."

    @override
    def hooks(self, component: str) -> Hooks:
        return _OneLagging(component) if component in THRUSTERS else _Lagging()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        if component in THRUSTERS:
            raise InputError(f"actuator_lag:{component}: MuJoCo flies no single thrusters; leave it out of the model")
        return Extension(platform=(ActuatorResponse(time_constant=float(values[0])),))
