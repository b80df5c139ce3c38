"""The motor of one gimbal works against a friction that only knows the direction of turning."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit, unit_index
from testbed.plant.unit_additions import GimbalFriction
from testbed.prediction.hooks import Hooks
from testbed.prediction.smoothed import direction_of
from testbed.scenario.scenario import Scenario


class _Rubbing(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def motor_torque(self, torque: Array, value: Array, gimbal_rate: Array) -> Array:
        against = only_unit(self._component, value[:, 0], torque.shape[-1])[:, None]
        return np.asarray(torque + against * direction_of(gimbal_rate))


@final
class GimbalCoulombFriction(Effect):
    """τ_motor = ... + τ_c sign(ḋ)."""

    id = "gimbal_coulomb_friction"
    components = UNITS
    parameters = (Parameter(name="torque_N_m", unit="N·m", typical=1e-4, lower=0.0),)
    needs = ("gimbal_angle", "gimbal_torque")
    measured_by = ("gimbal_angle",)
    sentence = (
        "The motor of the gimbal of {component} works against a dry friction, which jumps when the gimbal reverses."
    )
    look_alikes = ("gimbal_viscous_friction",)
    confounds = ("gimbal_lag",)  # a gimbal that sticks at reversals
    confirm = "Turn that gimbal slowly to and fro: the motor's torque steps at each reversal."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Rubbing(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(GimbalFriction(unit=unit_index(component), dry=float(values[0])),))
