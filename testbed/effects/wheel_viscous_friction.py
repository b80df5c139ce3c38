"""The bearing of one wheel, or of each alike, brakes it in proportion to its speed, more or less than is believed."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import ALL_WHEELS, WHEELS, Effect, Extension, Parameter, only_wheel, wheels_named
from testbed.prediction.hooks import Hooks
from testbed.prediction.wheel_impulses import Impulses
from testbed.scenario.actuators import reaction_wheels
from testbed.scenario.scenario import Scenario


class _Braked(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def wheel_impulse(self, impulse: Array, value: Array, of: Impulses) -> Array:
        return np.asarray(impulse - only_wheel(self._component, value, impulse.shape[-1])[:, None] * of.turned)


@final
class WheelViscousFriction(Effect):
    """τ = ... + c Ω of the motor, beside the friction that the scenario states: in the cold, of all wheels alike."""

    id = "wheel_viscous_friction"
    components = (*WHEELS, ALL_WHEELS)
    # Oil that has gone stiff in the cold brakes several times as much as at room temperature.
    parameters = (Parameter(name="coefficient_N_m_s_rad", unit="N·m·s/rad", typical=1e-8),)
    needs = ("wheel_speed", "wheel_torque")
    measured_by = ("wheel_speed",)
    sentence = "The bearing of {component} brakes in proportion to its speed, more or less than its drawing says."
    look_alikes = ("wheel_coulomb_friction",)
    confirm = (
        "Let one wheel run down from half and from its whole speed: only a viscous friction is in proportion to it."
    )

    @override
    def hooks(self, component: str) -> Hooks:
        return _Braked(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        arrays = reaction_wheels(scenario.actuators)
        believed = tuple(each.viscous_friction_N_m_s_rad for each in arrays for _ in range(each.wheels))
        friction = np.array(scenario.truth.wheel_viscous_friction_N_m_s_rad or believed)
        named = wheels_named(component)
        friction[named] = np.maximum(friction[named] + values[0], 0.0)
        return Extension(scenario={"truth": {"wheel_viscous_friction_N_m_s_rad": friction.tolist()}})
