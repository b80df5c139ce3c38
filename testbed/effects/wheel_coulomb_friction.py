"""The bearing of one wheel, or of each alike, brakes it with one torque at any speed, more or less than is believed."""

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


class _Rubbing(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def wheel_impulse(self, impulse: Array, value: Array, of: Impulses) -> Array:
        return np.asarray(impulse - only_wheel(self._component, value, impulse.shape[-1])[:, None] * of.directed)


@final
class WheelCoulombFriction(Effect):
    """τ = ... + τ_c sign Ω of the motor, beside the friction that the scenario states."""

    id = "wheel_coulomb_friction"
    components = (*WHEELS, ALL_WHEELS)
    parameters = (Parameter(name="torque_N_m", unit="N·m", typical=1e-5),)
    needs = ("wheel_speed", "wheel_torque")
    measured_by = ("wheel_speed",)
    sentence = (
        "The bearing of {component} brakes with the same torque at any speed, more or less than its drawing says."
    )
    look_alikes = ("wheel_viscous_friction",)
    confirm = (
        "Let one wheel run down: a dry friction stops it at a constant deceleration, a viscous one slows it ever less."
    )

    @override
    def hooks(self, component: str) -> Hooks:
        return _Rubbing(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        arrays = reaction_wheels(scenario.actuators)
        believed = tuple(each.coulomb_friction_N_m for each in arrays for _ in range(each.wheels))
        friction = np.array(scenario.truth.wheel_coulomb_friction_N_m or believed)
        named = wheels_named(component)
        friction[named] = np.maximum(friction[named] + values[0], 0.0)
        return Extension(scenario={"truth": {"wheel_coulomb_friction_N_m": friction.tolist()}})
