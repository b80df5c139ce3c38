"""The motor of one gimbal works against a friction in proportion to its rate."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit, unit_index
from testbed.plant.unit_additions import GimbalFriction
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Braked(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def motor_torque(self, torque: Array, value: Array, gimbal_rate: Array) -> Array:
        against = only_unit(self._component, value[:, 0], torque.shape[-1])[:, None]
        return np.asarray(torque + against * gimbal_rate)


@final
class GimbalViscousFriction(Effect):
    """τ_motor = ... + c ḋ."""

    id = "gimbal_viscous_friction"
    components = UNITS
    parameters = (Parameter(name="coefficient_N_m_s_rad", unit="N·m·s/rad", typical=1e-4, lower=0.0),)
    needs = ("gimbal_angle", "gimbal_torque")
    measured_by = ("gimbal_angle",)
    sentence = "The motor of the gimbal of {component} works against a friction that grows with the gimbal's rate."
    look_alikes = ("gimbal_coulomb_friction",)
    confirm = "Turn that gimbal at half and at twice the rate: only a viscous friction stays in proportion."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Braked(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(GimbalFriction(unit=unit_index(component), viscous=float(values[0])),))
