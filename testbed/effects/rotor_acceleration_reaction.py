"""A rotor that is made to turn faster turns the body the other way at once, before its drag or thrust has grown."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import AXES, HOLDING_MOMENTUM, Effect, Extension, Parameter
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.smooth import node_slopes
from testbed.scenario.scenario import Scenario


class _Reacting(Hooks):
    def __init__(self, component: str) -> None:
        self._along = np.array([axis == component for axis in AXES], dtype=float)

    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        half_step = 0.5 * grid.step[:, None, None, None]
        slopes_B = node_slopes(asked_B.real, half_step)
        if np.iscomplexobj(asked_B):
            slopes_B = slopes_B + 1j * node_slopes(asked_B.imag, half_step)
        return np.asarray(asked_B + value[:, :1, None] * self._along * slopes_B)


@final
class RotorAccelerationReaction(Effect):
    """τ = τ_drag + T dτ_drag/dt about the rotors' axis, T = J_rotor Ω / (2 τ_drag) of drag in proportion to Ω²."""

    id = "rotor_acceleration_reaction"
    components = AXES
    parameters = (Parameter(name="lead_s", unit="s", typical=0.03, lower=0.0, upper=2.0, plausible=(0.0, 0.5)),)
    needs = ("applied_torque",)
    measured_by = HOLDING_MOMENTUM
    sentence = "Rotors turn the body about its {component} axis by their own acceleration, ahead of their drag."
    look_alikes = ("actuator_lag", "actuator_delay")
    confirm = "Steps of the torque about this axis: the body's rate jumps at once by what the rotors took up."
    flies = False

    @override
    def described(self, component: str) -> str:
        return self.sentence.format(component=component)

    @override
    def hooks(self, component: str) -> Hooks:
        return _Reacting(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
