"""A gimbal's motor gives the torque that it is asked for with a lag."""

from __future__ import annotations

from typing import final

from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import CLUSTER, UNITS, Effect, Extension, Parameter, only_unit, unit_index
from testbed.plant.unit_additions import GimbalMotorLag
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Behind(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def servo_lag(self, value: Array, units: int) -> Array:
        if self._component == CLUSTER:
            return value.repeat(units, axis=1)
        return only_unit(self._component, value[:, 0], units)


@final
class GimbalLag(Effect):
    """T τ̇ = τ_demand - τ of the motor, outside its tachometer loop; of one gimbal or of all alike."""

    id = "gimbal_lag"
    components = (CLUSTER, *UNITS)
    parameters = (
        Parameter(name="time_constant_s", unit="s", typical=0.02, lower=0.0, upper=1.0, plausible=(0.0, 0.3)),
    )
    needs = ("gimbal_angle", "gimbal_rate_command")
    measured_by = ("gimbal_angle",)
    sentence = "The motor of the gimbal of {component} gives the torque that it is asked for with a lag."
    look_alikes = ("gimbal_backlash",)
    confirm = "A step of that gimbal's rate: its encoder shows how it approaches what is asked."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Behind(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        units = range(scenario.gyros.units) if component == CLUSTER else (unit_index(component),)
        return Extension(platform=[GimbalMotorLag(unit=unit, time_constant=float(values[0])) for unit in units])
